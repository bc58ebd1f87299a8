"""Equilibrium under a constant torque: drive * u - springs - effects - G(q) = 0, by a damped Newton method.

Where that fails (play: no stiffness at all, and kinks), the arm creeps to rest: pseudo-transient continuation, C. T. Kelley,
D. E. Keyes, Convergence analysis of pseudo-transient continuation, SIAM J. Numer. Anal. 35 (1998).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hsr_pin.robot.model import ArmModel
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Residual torque [N m] at which a pose counts as an equilibrium.
TOLERANCE = 1e-12
#: Residual [N m] that is still accepted where rounding lets it fall no further.
ACCEPTED = 1e-8
_ITERATIONS = 60
_HALVINGS = 8
_CREEP_ITERATIONS = 400


class Gravity:
    """Torques of gravity at the joints of planar chains, linear in cos and sin of the link angles theta_i = q_1 + ... + q_i.

    The potential is -sum_i (c_i cos theta_i + s_i sin theta_i): (c_i, s_i) are gravity along and across the straight arm times
    the mass that link i carries, its own at its centre and all further ones at the next joint.
    """

    def __init__(self, arms: list[ArmModel]) -> None:
        pairs = {key: self._pair(arm) for key, arm in {id(arm.model): arm for arm in arms}.items()}
        self._cosine, self._sine = (
            np.column_stack([pairs[id(arm.model)][part] for arm in arms]) for part in range(2)
        )  # (N, B) [N m]

    @staticmethod
    def _pair(arm: ArmModel) -> tuple[Array, Array]:
        mass = np.array([body.mass for body in arm.model.inertias[1:]])
        lever = np.array([body.lever[2] for body in arm.model.inertias[1:]])
        reach = np.array([place.translation[2] for place in arm.model.jointPlacements[2:]] + [0.0])
        moment = mass * lever + reach * (mass[::-1].cumsum()[::-1] - mass)
        g = arm.model.gravity.linear
        return moment * (g @ arm.direction), moment * (g @ arm.normal)

    def torque(self, q: Array) -> Array:
        """(N, B) [N m] with which gravity turns the joints."""
        theta = q.cumsum(axis=0)
        own = self._sine * np.cos(theta) - self._cosine * np.sin(theta)
        return np.asarray(own[::-1].cumsum(axis=0)[::-1])

    def stiffness(self, q: Array) -> Array:
        """(N, B) [Nm/rad] second derivatives of the potential to the link angles; the mixed ones vanish."""
        theta = q.cumsum(axis=0)
        return np.asarray(self._cosine * np.cos(theta) + self._sine * np.sin(theta))


def equilibrium(
    columns: Columns, torque: Array, wanted: NDArray[np.bool_], near: Array | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """The poses at which the arms rest under constant torques (B,) [N m], loaded from the straight, never bent arm.

    Args:
        columns: the arms.
        torque: (B,) [N m].
        wanted: (B,) columns to solve for; the others stay straight.
        near: (N, B) [rad] where the search begins; default: straight.

    Returns:
        Joint angles (N, B) [rad], 0 where no equilibrium was found, and (B,) whether one was.
    """
    straight = np.zeros((columns.shape.links, len(columns.scenarios)), order="F")
    virgin = columns.virgin_states()
    gravity, drive = Gravity(columns.arm_models), columns.drive * torque

    def residual(q: Array) -> Array:
        states = columns.update(virgin, straight, q, math.inf)
        return np.asarray(drive + columns.torque(q, straight, states) + gravity.torque(q))

    def direction(q: Array, rest: Array, moving: NDArray[np.bool_], drag: Array) -> Array:
        local, weight = _local_stiffness(columns, q, virgin, straight) + drag, gravity.stiffness(q)
        way = np.zeros_like(q)
        for b in np.flatnonzero(moving):
            way[:, b] = _newton(local[:, b], weight[:, b], rest[:, b])
        return np.asarray(way * np.minimum(1.0, 0.5 / np.maximum(np.abs(way).max(axis=0), 1e-300)))

    def far(rest: Array, bound: Array | float) -> NDArray[np.bool_]:
        return np.asarray(~(np.abs(rest).max(axis=0) < bound * np.maximum(1.0, np.abs(torque))))  # NaN is far too

    begin = straight if near is None else np.where(wanted, near, straight)
    q, rest = begin, residual(begin)
    for _ in range(_ITERATIONS):
        moving = wanted & far(rest, TOLERANCE)
        if not moving.any():
            break
        q, rest = _line_search(residual, q, rest, direction(q, rest, moving, np.zeros(len(wanted))), moving)
    lost = wanted & far(rest, ACCEPTED)
    if lost.any():
        q = np.where(lost, begin, q)
        q, rest = _creep(residual, direction, q, lambda rest: lost & far(rest, TOLERANCE), columns.shape.links * columns.keq)
    found = wanted & ~far(rest, ACCEPTED)
    return np.where(found, q, 0.0), found


def _creep(
    residual: Callable[[Array], Array],
    direction: Callable[[Array, Array, NDArray[np.bool_], Array], Array],
    q: Array,
    moving: Callable[[Array], NDArray[np.bool_]],
    spring: Array,
) -> tuple[Array, Array]:
    """Steps of implicit Euler on dq/dt = residual, whose drag (B,) [Nm/rad] falls and rises with the residual."""
    rest = residual(q)
    size, drag = np.linalg.norm(rest, axis=0), 3.0 * spring
    for _ in range(_CREEP_ITERATIONS):
        active = moving(rest) & np.isfinite(size)
        if not active.any():
            break
        q = q + direction(q, rest, active, drag)
        rest = residual(q)
        new = np.linalg.norm(rest, axis=0)
        drag = np.minimum(drag * np.clip(new / np.maximum(size, 1e-300), 0.3, 3.0), 100 * spring)
        size = new
    return q, rest


def _newton(joint: Array, link: Array, rest: Array) -> Array:
    """(N,) solve (diag(joint) + U diag(link) U^T) x = rest, U the upper triangle of ones: tridiagonal in the link angles."""
    from scipy.linalg import solve_banded  # here: an arm that starts at rest hanging straight needs no solution

    bands = np.zeros((3, len(joint)))
    bands[1] = joint + link
    bands[1, :-1] += joint[1:]
    bands[0, 1:] = bands[2, :-1] = -joint[1:]
    try:
        turn = solve_banded((1, 1), bands, rest - np.append(rest[1:], 0.0), check_finite=False)
    except np.linalg.LinAlgError:  # at the point of buckling: as if gravity were not there
        return rest / joint
    return np.diff(turn, prepend=0.0)


def _line_search(
    residual: Callable[[Array], Array], q: Array, rest: Array, direction: Array, moving: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Halve the step of each moving column until its residual falls; near the solution, where rounding rules, take it whole."""
    size = np.linalg.norm(rest, axis=0)
    scale = np.ones(len(moving))
    for _ in range(_HALVINGS):
        trial = q + scale * direction
        new = residual(trial)
        worse = moving & (size > 1e-9) & ~(np.linalg.norm(new, axis=0) <= size * (1 - 1e-4 * scale))
        if not worse.any():
            break
        scale = np.where(worse, scale / 2, scale)
    return trial, new


def _local_stiffness(columns: Columns, q: Array, virgin: tuple[Array, ...], straight: Array) -> Array:
    """(N, B) [Nm/rad] of springs and effects; every law is local to its joint, so one difference gives the diagonal."""
    width = 1e-6 / columns.shape.links
    ends = [columns.torque(q + w, straight, columns.update(virgin, straight, q + w, math.inf)) for w in (-width, width)]
    return np.asarray((ends[0] - ends[1]) / (2 * width))
