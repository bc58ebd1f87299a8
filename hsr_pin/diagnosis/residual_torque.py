"""The torque along the arm that the model lacks: inverse dynamics of the measured motion minus that of the model's motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.evaluation import Response, simulate_run
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.pose import modes_of
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.fit import Fit
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.trajectory import Array

#: Window of the Savitzky-Golay filter [s], and its degree.
_WINDOW, _DEGREE = 0.13, 3
#: Prior standard deviation of the deviation in the first curvature mode [rad]; it is smaller for higher modes.
_PRIOR = 0.3
#: Least standard deviation of a marker position, as a share of the arm's length: the position of a marker on the arm is not known
#: better, even if smoothed tracks have much less noise.
_MARKER_ERROR = 1e-3
#: Number of noise samples for the uncertainty.
_DRAWS = 6


@dataclass(frozen=True, eq=False)
class ResidualTorque:
    """Missing torque in one run; complex numbers stand for two directions in space.

    Attributes:
        torque: (T, N) missing torque at each joint, with which the arm would move as measured [N m]; complex in space.
        noise: (N,) RMS missing torque that marker noise alone would cause [N m].
        bending: (T,) bending angle of the whole arm in the model [rad]; complex in space.
        rate: (T,) its rate [rad/s].
        bends: (T, N) bending angles of the joints [rad]; complex in space.
        rates: (T, N) their rates [rad/s].
        levers: (T, N) distances from each joint to the tip along the direction of the straight arm [m] (lever arms of a
            transverse force at the tip); zero in space.
        modes: number of curvature modes that the markers determine.
    """

    torque: Array
    noise: Array
    bending: Array
    rate: Array
    bends: Array
    rates: Array
    levers: Array
    modes: int


def residual_torques(experiment: Experiment, fit: Fit, seed: int) -> list[ResidualTorque]:
    """Return the missing torque in each run, relative to the motion that a fitted model without effects predicts.

    Few markers determine only a few modes of curvature. The deviation of the joint angles is therefore a sum of Legendre
    polynomials along the arm, as many as there are marker coordinates in a plane (at most four), with a Gaussian prior that
    shrinks undetermined modes (ridge regression). It is differentiated in time by a Savitzky-Golay filter.
    """
    generator = np.random.default_rng(seed)
    answers = []
    for run in experiment.runs:
        model = simulate_run(experiment, run.whole, fit.hypothesis, fit.values[None])
        if np.isfinite(model.positions).all():
            answers.append(_residual(experiment, run, model, generator))
    return answers


def _residual(experiment: Experiment, run: Run, model: Response, generator: np.random.Generator) -> ResidualTorque:
    batch, q, v = model.batch, model.angles[:, 0], model.rates[:, 0]
    seen = np.isfinite(run.measured)
    gap = _between(run, np.nan_to_num(run.measured - model.positions[:, 0]))
    shapes = modes_of(batch, len(experiment.markers))[0]
    bend = _Bend(experiment, experiment.cameras(batch).places.sways(q, shapes), shapes, seen)

    def torque(miss: Array) -> Array:
        return batch.bends(_missing(batch, q, v, bend.deviation(miss), run.step))

    noise = [generator.normal(size=gap.shape) * experiment.noise[:, None] * seen for _ in range(_DRAWS)]
    if run.rows is not None:
        noise, seen = [_between(run, draw) for draw in noise], np.ones_like(seen)
    zero = torque(np.zeros_like(gap))
    power = np.mean([np.abs(torque(draw) - zero) ** 2 for draw in noise], axis=(0, 1))
    bends, rates = (batch.bends(part) for part in (q, v))
    levers = np.zeros(bends.shape)
    if not batch.space:
        along = batch.arrays.reach[0] * np.cos(q.cumsum(axis=1))
        levers = along[:, ::-1].cumsum(axis=1)[:, ::-1]
    return ResidualTorque(
        torque(gap), np.sqrt(power), bends.sum(axis=1), rates.sum(axis=1), bends, rates, levers, shapes.shape[1]
    )


def _between(run: Run, values: Array) -> Array:
    """Return values (T, ...) interpolated linearly between the valid samples of a run; unchanged if all are valid."""
    if run.rows is None:
        return values
    flat, at = values.reshape(len(values), -1), np.arange(len(values))
    return np.stack([np.interp(at, run.rows, column[run.rows]) for column in flat.T], axis=1).reshape(values.shape)


class _Bend:
    """Estimator of joint angle deviations (T, N) [rad], in space (T, 3 N), from marker deviations (T, M, 3) [m]."""

    def __init__(self, experiment: Experiment, sways: Array, shapes: Array, seen: Array) -> None:
        self._shapes = shapes  # (N, K)
        samples, modes = len(seen), shapes.shape[1]
        jacobian = sways.reshape(samples, -1, modes)
        known = np.maximum(experiment.noise, _MARKER_ERROR * experiment.dataset.length)
        weight = (seen / known[:, None]).reshape(samples, -1)
        self._weighted = jacobian * weight[..., None] ** 2
        prior = np.diag(((1 + np.arange(modes) // len(experiment.directions)) / _PRIOR) ** 2)
        self._normal = np.einsum("txk,txl->tkl", self._weighted, jacobian) + prior

    def deviation(self, miss: Array) -> Array:
        right = np.einsum("txk,tx->tk", self._weighted, miss.reshape(len(miss), -1))
        modes = np.linalg.solve(self._normal, right[..., None])[..., 0]
        return np.asarray(modes @ self._shapes.T)


def _missing(batch: ArmBatch, q: Array, v: Array, deviation: Array, step: float) -> Array:
    """Return inverse dynamics of the measured motion minus that of the model's motion (T, N) [N m]; in space (T, 3 N)."""
    window = max(_DEGREE + 2, 2 * round(_WINDOW / step / 2) + 1)
    if window > len(q):
        return np.zeros_like(q)
    dq, dv, da = (smoothed(deviation, window, _DEGREE, deriv=k, step=step) for k in range(3))
    a, rigid, arm = np.gradient(v, step, axis=0), batch.rigid_torques(), batch.arms.specification(0)
    taken = [
        rigid(q_d, v_d, a_d) - rigid(q_0, v_0, a_0)
        for q_d, v_d, a_d, q_0, v_0, a_0 in zip(q + dq, v + dv, a + da, q, v, a, strict=True)
    ]
    return np.asarray(np.array(taken) + arm.joint_stiffness * dq + arm.joint_damping * dv)
