"""The benchmark problem in SciPy's stiff solvers, with accelerations and their derivatives from Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from problem import SAMPLE, TORQUE, times
from scipy.integrate import solve_ivp

from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

METHODS = ("Radau", "LSODA")


class ScipyChain:
    """A solver by SciPy.

    Args:
        arm: arm to simulate.
        method: "Radau" or "LSODA".
        tolerance: relative tolerance; the absolute one [rad, rad/s] is a hundredth of it.
        sample: time between samples [s].
    """

    def __init__(self, arm: ArmSpecification, method: str, tolerance: float, sample: float = SAMPLE) -> None:
        self.setting = f"tolerance {tolerance:.0e}"
        self._arm, self._method, self._tolerance, self._times = arm, method, tolerance, times(sample)
        self._model = build_model(arm).model
        self._data = self._model.createData()

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        n = self._arm.links
        options = {"rtol": self._tolerance, "atol": 1e-2 * self._tolerance}
        span = self._times[[0, -1]]
        found = solve_ivp(self._slope, span, np.zeros(2 * n), self._method, self._times, jac=self._jacobian, **options)
        return np.asarray(found.y[:n].T[:, None])

    def _torque(self, q: Array, v: Array) -> Array:
        return np.asarray(TORQUE - self._arm.joint_stiffness * q - self._arm.joint_damping * v)

    def _slope(self, _: float, state: Array) -> Array:
        q, v = np.split(state, 2)
        return np.concatenate([v, pin.aba(self._model, self._data, q, v, self._torque(q, v))])

    def _jacobian(self, _: float, state: Array) -> Array:
        q, v = np.split(state, 2)
        by_q, by_v, inverse = pin.computeABADerivatives(self._model, self._data, q, v, self._torque(q, v))
        inverse = np.triu(inverse) + np.triu(inverse, 1).T
        below = by_q - self._arm.joint_stiffness * inverse, by_v - self._arm.joint_damping * inverse
        return np.block([[np.zeros_like(by_q), np.eye(len(q))], list(below)])
