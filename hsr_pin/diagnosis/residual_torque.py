"""The torque along the arm that the model lacks: inverse dynamics of the smoothed, measured motion minus those of the model's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.signal import savgol_filter

from hsr_pin.identification.evaluation import Response, respond
from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.fit import Fit
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

#: Window of the Savitzky-Golay filter [s], and its degree.
_WINDOW, _DEGREE = 0.13, 3
#: Expected size of the deviation in each curvature mode [rad]; higher ones are held smaller.
_PRIOR = 0.3
#: Draws of noise for the uncertainty.
_DRAWS = 6


@dataclass(frozen=True, eq=False)
class ResidualTorque:
    """Of one run.

    Attributes:
        torque: (T, N) [N m] what is missing at each joint so that the arm moves as measured.
        noise: (N,) [N m] RMS of it that marker noise alone would make.
        bending: (T,) [rad] bending angle of the whole arm, by the model.
        rate: (T,) [rad/s] its rate.
    """

    torque: Array
    noise: Array
    bending: Array
    rate: Array


def residual_torques(experiment: Experiment, fit: Fit, seed: int) -> list[ResidualTorque]:
    """For each run, about the motion that a fitted model without effects predicts.

    Few markers tell only a few modes of curvature: the deviation of the joint angles is a sum of Legendre polynomials along the
    arm, as many as there are marker coordinates in the plane (four at most), with a Gaussian prior that shrinks what the markers
    do not tell (ridge regression). It is differentiated in time by a Savitzky-Golay filter.
    """
    generator = np.random.default_rng(seed)
    answers = []
    for run in experiment.runs:
        model = respond(experiment, run, fit.hypothesis, fit.values[None])
        if np.isfinite(model.positions).all():
            answers.append(_residual(experiment, run, model, generator))
    return answers


def _residual(experiment: Experiment, run: Run, model: Response, generator: np.random.Generator) -> ResidualTorque:
    arm, q, v = model.columns.arms.specification(0), model.angles[:, 0], model.rates[:, 0]
    places = marker_map(arm, np.array([marker.arc_length for marker in experiment.markers]))
    gap = np.nan_to_num(run.measured - model.positions[:, 0])
    seen = np.isfinite(run.measured)
    bend = _Bend(experiment, places, arm, q, seen)
    rigid = build_model(arm).model

    def torque(miss: Array) -> Array:
        return _missing(arm, rigid, q, v, bend.deviation(miss), run.step)

    noise = [generator.normal(size=gap.shape) * experiment.noise[:, None] * seen for _ in range(_DRAWS)]
    zero = torque(np.zeros_like(gap))
    power = np.mean([(torque(draw) - zero) ** 2 for draw in noise], axis=(0, 1))
    return ResidualTorque(torque(gap), np.sqrt(power), q.sum(axis=1), v.sum(axis=1))


class _Bend:
    """From marker deviations (T, M, 3) [m] to joint angle deviations (T, N) [rad]."""

    def __init__(self, experiment: Experiment, places: MarkerMap, arm: ArmSpecification, q: Array, seen: Array) -> None:
        links = arm.links
        modes = min(2 * len(experiment.markers), 4, links)
        s = 2 * arm.element_arc_lengths - 1
        self._shapes = np.polynomial.legendre.legvander(s, modes - 1) / links  # (N, K)
        theta = np.cumsum(q, axis=1)
        way = np.cos(theta)[..., None] * places.normal[0] - np.sin(theta)[..., None] * places.direction[0]  # (T, N, 3)
        turn = (places.spans[0][None, :, :, None] * way[:, :, None]).reshape(*theta.shape, -1)  # (T, N, 3M) d p / d theta
        summed = np.cumsum(self._shapes, axis=0)  # d theta / d mode
        jacobian = np.einsum("tnx,nk->txk", turn, summed)
        weight = (seen / experiment.noise[:, None]).reshape(len(q), -1)
        self._weighted = jacobian * weight[..., None] ** 2
        prior = np.diag(((1 + np.arange(modes)) / _PRIOR) ** 2)
        self._normal = np.einsum("txk,txl->tkl", self._weighted, jacobian) + prior

    def deviation(self, miss: Array) -> Array:
        right = np.einsum("txk,tx->tk", self._weighted, miss.reshape(len(miss), -1))
        modes = np.linalg.solve(self._normal, right[..., None])[..., 0]
        return np.asarray(modes @ self._shapes.T)


def _missing(arm: ArmSpecification, model: pin.Model, q: Array, v: Array, deviation: Array, step: float) -> Array:
    """(T, N) [N m] inverse dynamics of the deviated motion minus that of the model's own."""
    window = max(_DEGREE + 2, 2 * round(_WINDOW / step / 2) + 1)
    if window > len(q):
        return np.zeros_like(q)
    dq, dv, da = (savgol_filter(deviation, window, _DEGREE, deriv=k, delta=step, axis=0) for k in range(3))
    a = np.gradient(v, step, axis=0)
    data = model.createData()
    rigid = [
        pin.rnea(model, data, q_d, v_d, a_d) - pin.rnea(model, data, q_0, v_0, a_0)
        for q_d, v_d, a_d, q_0, v_0, a_0 in zip(q + dq, v + dv, a + da, q, v, a, strict=True)
    ]
    return np.asarray(np.array(rigid) + arm.joint_stiffness * dq + arm.joint_damping * dv)
