"""Equilibrium poses: the pose of a torque, and the torque whose equilibrium brings the tip nearest to a position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.errors import InputError
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.motion import Engine
from hsr_pin.trajectory import Array

#: Number of sizes and of directions of tried torques in space.
_RINGS, _SIDES = 6, 12
#: Number of tried torques before the nearest interval is searched.
_LOOKS = 33


@dataclass(frozen=True, eq=False)
class Rest:
    """An equilibrium of the arm.

    Attributes:
        torque: torque u that holds the arm [N m]; in space (2 S,).
        q: (N,) angles [rad]; in space (3 N,).
        tip: (3,) tip position in the world frame [m].
        distance: distance of the tip from the requested position [m]; 0 if none was requested.
    """

    torque: Any
    q: Array
    tip: Array
    distance: float = 0.0


def static_pose(dynamics: ArmDynamics, torque: ArrayLike) -> Array:
    """Return the equilibrium poses (..., N) [rad] under constant torques (...) [N m]; in space (..., 3 N) under (..., 2 S).

    Raises:
        InputError: a torque is invalid, or there is no equilibrium under it.
    """
    torques = np.asarray(torque, dtype=float)
    if not np.isfinite(torques).all():
        raise InputError("torque", expected="finite [N m]", received=torque)
    if not dynamics.batch.space:
        return static_poses(dynamics.batch, torques.reshape(-1, 1)).reshape(*torques.shape, -1)
    count = dynamics.b.shape[1]
    if torques.shape[-1:] != (count,):
        expected = "two components [N m]" + f" for each of {count // 2} sections" * (count > 2)
        raise InputError("torque", expected=expected, received=f"shape {torques.shape}")
    sections: Any = torques[..., 0::2] + 1j * torques[..., 1::2]
    return static_poses(dynamics.batch, sections.reshape(-1, 1, count // 2)).reshape(*torques.shape[:-1], -1)


def static_poses(batch: ArmBatch, torque: Array) -> Array:
    """Return the equilibrium poses (T, B, N) [rad] of B arms under constant torques (T, B) [N m].

    In space they are (T, B, 3 N), with complex torques (T, B) or (T, B, S).

    Raises:
        InputError: there is no equilibrium under a torque.
    """
    engine, wanted, straight = (
        Engine(batch, "compiled"),
        np.ones(len(batch), dtype=bool),
        np.zeros((len(batch), batch.coordinates)),
    )
    poses = np.empty((*torque.shape[:2], batch.coordinates))
    for row, pose in zip(torque, poses, strict=True):
        pose[:], found = engine.settled(row, wanted, straight)
        if not found.all():
            raise InputError(
                "torque", expected="one that the arm can rest under", received=f"{np.ravel(row[~found][0])[0]:g} N m"
            )
    return poses


def rest_under(dynamics: ArmDynamics, torque: ArrayLike) -> Rest:
    """Return the equilibrium under a torque [N m], in space (2 S,).

    Raises:
        InputError: as :func:`static_pose`.
    """
    q = static_pose(dynamics, torque)
    return Rest(torque, q, dynamics.tip(q))


def rest_at_tip(dynamics: ArmDynamics, position: ArrayLike, torque_range: tuple[float, float]) -> Rest:
    """Return the equilibrium whose tip is nearest to a position, among the torques of a range.

    Args:
        dynamics: the arm.
        position: (3,) or (2,) x and z in the world frame [m]; y is ignored. In space (3,).
        torque_range: lowest and highest torque [N m]; in space the highest is the largest magnitude for each section.

    Raises:
        InputError: the position is invalid, the range is empty, or the arm has no equilibrium under a torque of the range.
    """
    point = np.asarray(position, dtype=float)
    if point.shape not in ((2,), (3,)) or not np.isfinite(point).all():
        raise InputError("tip position", expected="x and z, or x, y and z [m]", received=position)
    low, high = torque_range
    if not low < high:
        raise InputError("torque range", expected="a lowest and a higher torque [N m]", received=torque_range)
    if dynamics.batch.space:
        return _rest_in_space(dynamics, point, high)
    wanted = point[[0, -1]]
    torques = np.linspace(low, high, _LOOKS)
    distances = np.linalg.norm(dynamics.tip(static_pose(dynamics, torques))[:, [0, 2]] - wanted, axis=1)
    nearest = int(np.argmin(distances))
    left, right = torques[max(nearest - 1, 0)], torques[min(nearest + 1, _LOOKS - 1)]

    def slope(torque: float) -> float:
        """Half the derivative of the squared distance with respect to the torque [m^2/(N m)]."""
        q = static_pose(dynamics, torque)
        return float((dynamics.tip(q)[[0, 2]] - wanted) @ (dynamics.tip_jacobian(q)[[0, 2]] @ compliance(dynamics, q, torque)))

    best = float(torques[nearest])
    if slope(left) < 0 < slope(right):
        best = float(brentq(slope, left, right, xtol=1e-12))
    found = rest_under(dynamics, best)
    return Rest(best, found.q, found.tip, float(np.linalg.norm(found.tip[[0, 2]] - wanted)))


def _rest_in_space(dynamics: ArmDynamics, point: Array, largest: float) -> Rest:
    """Return the equilibrium nearest to a point over torques in all directions, by sequential quadratic programming.

    The search starts from the nearest of some tried torques. Sections reach a point in many ways; it starts with equal torques of
    all sections.
    """
    if point.shape != (3,) or not largest > 0:
        raise InputError("tip position", expected="x, y and z [m], and torques above zero", received=f"{point}, {largest}")
    sections = dynamics.b.shape[1] // 2
    sizes, sides = np.meshgrid(np.linspace(0.0, largest, _RINGS), 2 * np.pi / _SIDES * np.arange(_SIDES), indexing="ij")
    grid = np.tile(np.stack([sizes * np.cos(sides), sizes * np.sin(sides)], axis=-1).reshape(-1, 2), sections)
    distances = np.linalg.norm(dynamics.tip(static_pose(dynamics, grid)) - point, axis=1)

    def half_square(u: Array) -> tuple[float, Array]:
        q = static_pose(dynamics, u)
        away = dynamics.tip(q) - point
        slope = dynamics.tip_jacobian(q) @ compliance(dynamics, q, u)
        return 0.5e4 * float(away @ away), 1e4 * np.asarray(away @ slope)

    within = {
        "type": "ineq",
        "fun": lambda u: largest**2 - (u.reshape(-1, 2) ** 2).sum(axis=1),
        "jac": lambda u: -2 * np.kron(np.eye(sections), np.ones((1, 2))) * u,
    }
    answer = minimize(half_square, grid[np.argmin(distances)], jac=True, method="SLSQP", constraints=[within], tol=1e-14)
    parts = answer.x.reshape(-1, 2)
    best = (parts * np.minimum(1.0, largest / np.maximum(np.linalg.norm(parts, axis=1, keepdims=True), 1e-300))).ravel()
    found = rest_under(dynamics, best)
    return Rest(best, found.q, found.tip, float(np.linalg.norm(found.tip - point)))


def compliance(dynamics: ArmDynamics, q: Array, torque: ArrayLike) -> Array:
    """Return the derivative (N,), in space (3 N, 2 S), of the equilibrium pose with respect to the torque [rad/(N m)].

    It is (K + dG/dq)^-1 b.
    """
    linear = dynamics.linearise(q, torque)
    n, free = len(q), dynamics.moves
    change = np.zeros((n, linear.B.shape[1]))
    change[free] = -np.linalg.solve(linear.A[n:, :n][np.ix_(free, free)], linear.B[n:][free])
    return change if dynamics.batch.space else change[:, 0]
