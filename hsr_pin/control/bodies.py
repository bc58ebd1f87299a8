"""The rigid-body dynamics of an arm for controllers: planar arms with Pinocchio's hinges, spatial ones with spherical joints.

q, v, a and torques are rows of the joints' coordinates: (N,) of a planar arm; (3 N,) in space, towards x, towards y and twist of
each joint, of which a twist that is infinitely stiff does not move.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from hsr_pin.robot.model import build_model
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.space.reference import mass_matrix, rigid_torques
from hsr_pin.trajectory import Array

#: Steps of the finite differences for derivatives in space [rad], [rad/s].
_WIDTH = 1e-5


class Bodies(Protocol):
    """Interface of the rigid-body dynamics of planar and spatial arms."""

    def mass(self, q: Array) -> Array:
        """Return the mass matrix (n, n) [kg m^2]."""

    def coriolis(self, q: Array, v: Array) -> Array:
        """Return the Coriolis matrix C (n, n) [kg m^2/s] for which dM/dt - 2 C is skew-symmetric."""

    def torques(self, q: Array, v: Array, a: Array) -> Array:
        """Return the torques (n,) [N m] that a motion requires."""

    def accelerations(self, q: Array, v: Array, torques: Array) -> Array:
        """Return the accelerations (n,) [rad/s^2] under torques (n,) [N m] at the joints."""

    def derivatives(self, q: Array, v: Array, torques: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives (n, n) of the accelerations with respect to q, v and the torques, and the accelerations (n,)."""


class Hinged:
    """The rigid-body dynamics of a planar arm.

    R. Featherstone, Rigid Body Dynamics Algorithms, Springer (2008); derivatives: J. Carpentier, N. Mansard, Analytical
    derivatives of rigid body dynamics algorithms, RSS (2018).
    """

    def __init__(self, batch: ArmBatch) -> None:
        self._model = build_model(batch.arms.specification(0)).model.copy()
        self._data = self._model.createData()

    def mass(self, q: Array) -> Array:
        upper = np.triu(pin.crba(self._model, self._data, q))
        return np.asarray(upper + np.triu(upper, 1).T)

    def coriolis(self, q: Array, v: Array) -> Array:
        return np.array(pin.computeCoriolisMatrix(self._model, self._data, q, v))

    def torques(self, q: Array, v: Array, a: Array) -> Array:
        return np.array(pin.rnea(self._model, self._data, q, v, a))

    def accelerations(self, q: Array, v: Array, torques: Array) -> Array:
        return np.array(pin.aba(self._model, self._data, q, v, torques))

    def derivatives(self, q: Array, v: Array, torques: Array) -> tuple[Array, Array, Array, Array]:
        a_q, a_v, upper = (np.array(part) for part in pin.computeABADerivatives(self._model, self._data, q, v, torques))
        return a_q, a_v, np.triu(upper) + np.triu(upper, 1).T, np.array(self._data.ddq)


class Spherical:
    """The rigid-body dynamics of an arm in space, with derivatives by finite differences.

    Args:
        batch: the arm.
        moves: (3 N,) which coordinates move.
    """

    def __init__(self, batch: ArmBatch, moves: NDArray[np.bool_]) -> None:
        system = batch.pinocchio("rnea")
        self._model, self._data, self._free = system.models[0], system.data[0], np.ix_(moves, moves)
        self._moves = moves

    def mass(self, q: Array) -> Array:
        return mass_matrix(self._model, self._data, q)

    def coriolis(self, q: Array, v: Array) -> Array:
        n = len(q)
        slope = np.stack([self.mass(q + h) - self.mass(q - h) for h in _WIDTH * np.eye(n)], axis=2) / (2 * _WIDTH)
        return np.asarray(slope @ v + np.einsum("ikj,k->ij", slope, v) - np.einsum("jki,k->ij", slope, v)) / 2

    def torques(self, q: Array, v: Array, a: Array) -> Array:
        return rigid_torques(self._model, self._data, q, v, a)

    def accelerations(self, q: Array, v: Array, torques: Array) -> Array:
        found, right = np.zeros(len(q)), torques - self.torques(q, v, np.zeros(len(q)))
        found[self._moves] = np.linalg.solve(self.mass(q)[self._free], right[self._moves])
        return found

    def derivatives(self, q: Array, v: Array, torques: Array) -> tuple[Array, Array, Array, Array]:
        steps, mobile = _WIDTH * np.eye(len(q)), np.zeros((len(q), len(q)))
        a_q = [self.accelerations(q + h, v, torques) - self.accelerations(q - h, v, torques) for h in steps]
        a_v = [self.accelerations(q, v + h, torques) - self.accelerations(q, v - h, torques) for h in steps]
        mobile[self._free] = np.linalg.inv(self.mass(q)[self._free])
        still = np.outer(self._moves, self._moves)
        to_q, to_v = (np.where(still, np.array(part).T / (2 * _WIDTH), 0.0) for part in (a_q, a_v))
        return to_q, to_v, mobile, self.accelerations(q, v, torques)
