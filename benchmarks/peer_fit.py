"""Fit of two parameters with MuJoCo and SciPy: the same chain, recordings, loss and accuracy, and derivatives by differences.

This is a typical implementation: one model for each trial, `mj_step` looping in C from sample to sample, and
`scipy.optimize.least_squares`. Reading, the torque of every sample and the places of the markers on the links are set up
beforehand and not timed.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from peer_mujoco import mujoco_model
from scipy.optimize import least_squares

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.trajectory import Array

#: Relative change of cost and values at which the fit ends, as ours does.
_DONE = 1e-4
#: Largest error of a marker [m] in any trial, as declared: what a step of our fits may be in error by.
ACCURATE = 2e-4
#: Steps from sample to sample that are tried, and those of what they are compared with.
_STEPS, _FINE = tuple(round(1.2**k) for k in range(4, 28)), 400


class _Trial:
    """One trial with its arm as declared, initially at rest under no torque."""

    def __init__(self, experiment: Experiment, run: Run, method: str, steps: int) -> None:
        self._arm, self._run, self._steps = Hypothesis().declared(experiment, run), run, steps
        self._model = mujoco_model(self._arm, method, run.step / steps)
        self._data = mujoco.MjData(self._model)
        self._map, self._axes = marker_map(self._arm, experiment.reach), experiment.axes

    def positions(self, stiffness: float, damping: float) -> Array:
        """Return the marker positions (T, M, 2) [m] for factors on the declared stiffness and damping."""
        model, data, torque = self._model, self._data, self._run.torque
        spring = stiffness * self._arm.joint_stiffness
        model.jnt_stiffness[:], model.dof_damping[:] = spring, damping * self._arm.joint_damping
        mujoco.mj_resetData(model, data)
        angles = np.zeros((len(torque), model.nv))
        for n in range(1, len(torque)):
            model.qpos_spring[:] = torque[n - 1] / spring
            mujoco.mj_step(model, data, nstep=self._steps)
            angles[n] = data.qpos
        return self._map.positions(angles)[..., self._axes]


class MujocoFit:
    """Fit of stiffness and damping to an experiment in which every trial begins straight and without torque.

    Args:
        experiment: experiment that is fitted.
        method: MuJoCo's integrator.
        steps: number of its steps between samples.
    """

    def __init__(self, experiment: Experiment, method: str, steps: int) -> None:
        if any(run.start_pose is not None or abs(run.torque[0]) > 0.02 for run in experiment.runs):
            raise ValueError("a trial does not begin straight and without torque")
        self.setting = f"{method}, {1e3 * experiment.runs[0].step / steps:.3g} ms"
        self._trials = [_Trial(experiment, run, method, steps) for run in experiment.runs]
        self._seen = [np.isfinite(run.compared) for run in experiment.runs]
        self._measured = [run.compared for run in experiment.runs]
        self._noise = float(experiment.noise.mean())

    def run(self) -> Array:
        """Return the fitted factors on the declared stiffness and damping, (2,)."""
        answer = least_squares(
            self._residual, (1.0, 1.0), x_scale=(0.1, 0.2), bounds=((0.1, 0.02), (10, 50)), loss="soft_l1",
            f_scale=6 * float(np.median(np.abs(self._residual((1.0, 1.0)))) / 0.6745), ftol=_DONE, xtol=_DONE,
        )  # fmt: skip
        return np.asarray(answer.x)

    def predicted(self) -> list[Array]:
        """Return the marker positions of each trial, (T, M, 2) [m], with the declared values."""
        return [trial.positions(1.0, 1.0) for trial in self._trials]

    def _residual(self, factors: Sequence[float]) -> Array:
        parts = zip(self._trials, self._measured, self._seen, strict=True)
        return np.concatenate([((trial.positions(*factors) - here) / self._noise)[seen] for trial, here, seen in parts])


def cheapest_fit(experiment: Experiment) -> MujocoFit:
    """Return the fit with Euler's method, MuJoCo's cheapest at this accuracy, and the longest accurate steps."""
    exact = MujocoFit(experiment, "Euler", _FINE).predicted()
    for steps in _STEPS:
        fit = MujocoFit(experiment, "Euler", steps)
        if max(np.abs(one - other).max() for one, other in zip(fit.predicted(), exact, strict=True)) <= ACCURATE:
            return fit
    raise ValueError("MuJoCo is not accurate enough in any of the steps that are tried")
