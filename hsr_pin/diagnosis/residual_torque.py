"""The torque along the arm that the model lacks: inverse dynamics of the smoothed, measured motion minus those of the model's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.evaluation import Response, respond
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.pose import modes_of
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.fit import Fit
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Window of the Savitzky-Golay filter [s], and its degree.
_WINDOW, _DEGREE = 0.13, 3
#: Expected size of the deviation in each curvature mode [rad]; higher ones are held smaller.
_PRIOR = 0.3
#: What a model misses of a marker by less than this share of the arm's length is no sign of a bend, however still the marker is:
#: where it sits on the arm is not known better. Cameras that smooth leave a thousandth of it.
_PLACED = 1e-3
#: Draws of noise for the uncertainty.
_DRAWS = 6


@dataclass(frozen=True, eq=False)
class ResidualTorque:
    """Of one run.

    Attributes:
        torque: (T, N) [N m] what is missing at each joint so that the arm moves as measured; in space complex.
        noise: (N,) [N m] RMS of it that marker noise alone would make.
        bending: (T,) [rad] bending angle of the whole arm, by the model; in space complex.
        rate: (T,) [rad/s] its rate.
        bends: (T, N) [rad] of its joints; in space complex.
        rates: (T, N) [rad/s] theirs.
        levers: (T, N) [m] from each joint to the tip along the straight arm: the moments of a force across it; in space zeros.
        modes: of curvature that the markers tell.
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
    """For each run, about the motion that a fitted model without effects predicts.

    Few markers tell only a few modes of curvature: the deviation of the joint angles is a sum of Legendre polynomials along the
    arm, as many as there are marker coordinates in a plane (four at most), with a Gaussian prior that shrinks what the markers
    do not tell (ridge regression). It is differentiated in time by a Savitzky-Golay filter.
    """
    generator = np.random.default_rng(seed)
    answers = []
    for run in experiment.runs:
        model = respond(experiment, run.whole, fit.hypothesis, fit.values[None])
        if np.isfinite(model.positions).all():
            answers.append(_residual(experiment, run, model, generator))
    return answers


def _residual(experiment: Experiment, run: Run, model: Response, generator: np.random.Generator) -> ResidualTorque:
    columns, q, v = model.columns, model.angles[:, 0], model.rates[:, 0]
    seen = np.isfinite(run.measured)
    gap = _between(run, np.nan_to_num(run.measured - model.positions[:, 0]))
    shapes = modes_of(columns, len(experiment.markers))[0]
    bend = _Bend(experiment, experiment.cameras(columns).places.sways(q, shapes), shapes, seen)

    def torque(miss: Array) -> Array:
        return columns.bends(_missing(columns, q, v, bend.deviation(miss), run.step))

    noise = [generator.normal(size=gap.shape) * experiment.noise[:, None] * seen for _ in range(_DRAWS)]
    if run.rows is not None:
        noise, seen = [_between(run, draw) for draw in noise], np.ones_like(seen)
    zero = torque(np.zeros_like(gap))
    power = np.mean([np.abs(torque(draw) - zero) ** 2 for draw in noise], axis=(0, 1))
    bends, rates = (columns.bends(part) for part in (q, v))
    levers = np.zeros(bends.shape)
    if not columns.space:
        along = columns.arrays.reach[0] * np.cos(q.cumsum(axis=1))
        levers = along[:, ::-1].cumsum(axis=1)[:, ::-1]
    return ResidualTorque(
        torque(gap), np.sqrt(power), bends.sum(axis=1), rates.sum(axis=1), bends, rates, levers, shapes.shape[1]
    )


def _between(run: Run, values: Array) -> Array:
    """(T, ...) values (T, ...) with straight lines between the samples of a run that count; where all count, as they are."""
    if run.rows is None:
        return values
    flat, at = values.reshape(len(values), -1), np.arange(len(values))
    return np.stack([np.interp(at, run.rows, column[run.rows]) for column in flat.T], axis=1).reshape(values.shape)


class _Bend:
    """From marker deviations (T, M, 3) [m] to joint angle deviations (T, N) [rad]; in space (T, 3 N)."""

    def __init__(self, experiment: Experiment, sways: Array, shapes: Array, seen: Array) -> None:
        self._shapes = shapes  # (N, K)
        samples, modes = len(seen), shapes.shape[1]
        jacobian = sways.reshape(samples, -1, modes)
        known = np.maximum(experiment.noise, _PLACED * experiment.dataset.length)
        weight = (seen / known[:, None]).reshape(samples, -1)
        self._weighted = jacobian * weight[..., None] ** 2
        prior = np.diag(((1 + np.arange(modes) // len(experiment.directions)) / _PRIOR) ** 2)
        self._normal = np.einsum("txk,txl->tkl", self._weighted, jacobian) + prior

    def deviation(self, miss: Array) -> Array:
        right = np.einsum("txk,tx->tk", self._weighted, miss.reshape(len(miss), -1))
        modes = np.linalg.solve(self._normal, right[..., None])[..., 0]
        return np.asarray(modes @ self._shapes.T)


def _missing(columns: Columns, q: Array, v: Array, deviation: Array, step: float) -> Array:
    """(T, N) [N m] inverse dynamics of the deviated motion minus that of the model's own; in space (T, 3 N)."""
    window = max(_DEGREE + 2, 2 * round(_WINDOW / step / 2) + 1)
    if window > len(q):
        return np.zeros_like(q)
    dq, dv, da = (smoothed(deviation, window, _DEGREE, deriv=k, step=step) for k in range(3))
    a, rigid, arm = np.gradient(v, step, axis=0), columns.rigid_torques(), columns.arms.specification(0)
    taken = [
        rigid(q_d, v_d, a_d) - rigid(q_0, v_0, a_0)
        for q_d, v_d, a_d, q_0, v_0, a_0 in zip(q + dq, v + dv, a + da, q, v, a, strict=True)
    ]
    return np.asarray(np.array(taken) + arm.joint_stiffness * dq + arm.joint_damping * dv)
