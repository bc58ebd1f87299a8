"""The functions of the loops with Pinocchio: the reference for the compiled loops, and the default of ``hsr-sim``.

One call of ABA with ``armature`` = d D + d^2 K solves the linearly implicit Euler step of length d exactly, because Pinocchio
adds the armature to the diagonal of the mass matrix. "rnea" computes the bias by the recursive Newton-Euler algorithm and the
mass matrix by CRBA, which the paper names as future work; its cost is O(N^3).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from hsr_pin.effects.effect import Bending, Effect, effect_subset, middles
from hsr_pin.simulation import contact, kernel
from hsr_pin.simulation.kernel import ROWS
from hsr_pin.trajectory import Array

__all__ = [
    "ROWS",
    "add",
    "add_joint_moments",
    "bending_angle",
    "interpolate",
    "single_arm",
    "substep",
    "update_states",
    "updated_states",
]


@dataclass(frozen=True, eq=False)
class PinocchioSystem:
    """B arms for the Python loops: their arrays, their Pinocchio models and their laws.

    Attributes:
        arrays: the arrays of the compiled loops, :class:`hsr_pin.simulation.kernel.System`.
        models, data: (B,) models and data of Pinocchio.
        effects: the effects that act in the joints, with (B,) parameters.
        solve: "aba" or "rnea".
    """

    arrays: Any
    models: tuple[pin.Model, ...]
    data: tuple[pin.Data, ...]
    effects: tuple[Effect, ...]
    solve: str
    laws: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "laws", np.zeros((len(self.effects), 4)))  # one row per law, which the loops count

    @property
    def world(self) -> Array:
        """The obstacles (B, O, ENTRIES)."""
        return self.arrays.world  # type: ignore[no-any-return]

    @property
    def points(self) -> int:
        """Number of points of contact of a link."""
        return int(self.arrays.touch[3])


def substep(
    system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array, torque: Array, d: float, scratch: Array
) -> None:
    """Take a linearly implicit Euler step in place, as :func:`hsr_pin.simulation.kernel.substep`.

    With obstacles, "aba" is replaced by "rnea": the implicit part of a contact is no inertia that Pinocchio's ABA accepts.
    """
    a = system.arrays
    tau = a.share * torque[:, None] - a.spring * q - (a.damper + d * a.stiff) * v - moment
    armature = d * (a.drag + d * a.stiff)
    touching = a.world.shape[1] > 0
    for b, (model, data) in enumerate(zip(system.models, system.data, strict=True)):
        if touching:
            added, force = planar_contacts(system, b, q[b], v[b], z, d)
            v[b] += d * _newton_euler(model, data, q[b], v[b], tau[b] - force, np.diag(armature[b]) + added)
        elif system.solve == "rnea":
            v[b] += d * _newton_euler(model, data, q[b], v[b], tau[b], np.diag(armature[b]))
        else:
            model.armature = armature[b]
            v[b] += d * pin.aba(model, data, q[b], v[b], tau[b])
    q += d * v


def planar_contacts(system: PinocchioSystem, b: int, q: Array, v: Array, z: Array, d: float) -> tuple[Array, Array]:
    """Return what contacts add to the mass matrix (N, N) and to the required torque (N,) of a planar arm in a substep."""
    g = np.empty((contact.POSES, len(q)))
    world, reach = system.arrays.world[b], system.arrays.reach[b]
    contact.poses_in_plane(q, v, world[0, contact.START], reach, g)
    moves = np.zeros((len(q), 6, len(q)))  # angular velocity and velocity of each link's joint per rate
    for i in range(len(q)):
        moves[i, 2, : i + 1] = 1.0
        moves[i, 3, : i + 1], moves[i, 4, : i + 1] = g[1, : i + 1] - g[1, i], g[0, i] - g[0, : i + 1]
    drift = np.zeros((6, len(q)))  # acceleration of each joint at constant rates
    drift[3:5, 1:] = -np.cumsum(reach[:-1] * g[11, :-1] ** 2 * g[3:5, :-1], axis=1)
    return contacts(system, b, g, moves, drift, z, d)


def contacts(system: PinocchioSystem, b: int, g: Array, moves: Array, drift: Array, z: Array, d: float) -> tuple[Array, Array]:
    """Return what contacts add to the mass matrix and to the required torque of an arm in a substep.

    Args:
        system: the arms.
        b: index of the arm.
        g: (POSES, N) poses of its links.
        moves: (N, 6, C) angular velocity and velocity of each link at its joint per rate of the C coordinates.
        drift: (6, N) the accelerations at constant rates.
        z: (states, B, N) states.
        d: length of the step [s].
    """
    out = np.empty((kernel.ADDED, g.shape[1]))
    contact.press(g, _bristles(system, z)[:, :, b], system.arrays.reach[b], system.arrays.world[b], system.points, d, out)
    mass, force = np.zeros((moves.shape[2],) * 2), np.zeros(moves.shape[2])
    upper = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
    for i, (move, more) in enumerate(zip(moves, out.T, strict=True)):
        cross = more[6:15].reshape(3, 3)
        inertia = np.block([[more[upper], cross], [cross.T, more[15 + upper]]])
        mass += move.T @ inertia @ move
        force += move.T @ (inertia @ drift[:, i] + more[21:])
    return mass, force


def _bristles(system: PinocchioSystem, z: Array) -> Array:
    """Return the tangential displacements (points, 3, B, N) [m] in the states, as a view; zeros without friction."""
    first = system.arrays.touch[2]
    shape = (system.points, contact.COMPONENTS, *system.arrays.reach.shape)
    return z.real[first:].reshape(shape) if first >= 0 else np.zeros(shape)


def _newton_euler(model: pin.Model, data: pin.Data, q: Array, v: Array, tau: Array, armature: Array) -> Array:
    bias = pin.rnea(model, data, q, v, np.zeros_like(v))
    model.armature = np.zeros_like(v)  # some versions of Pinocchio include the armature in CRBA
    upper = np.triu(pin.crba(model, data, q))
    return np.asarray(np.linalg.solve(upper + np.triu(upper, 1).T + armature, tau - bias))


def add_joint_moments(system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array) -> None:
    """Add the moments (B, N) [N m] of the laws to ``moment``."""
    links, first = q.shape[1], 0
    for effect in system.effects:
        memory = tuple(z[first : first + effect.states])
        bending = Bending(links * q, links * v, system.arrays.keq[:, None], system.arrays.profile, middles(links), memory)
        moment += effect.moment(_columns(effect.p), bending)
        if effect.acts_through("contact_force"):
            moment += contact_moments(effect, q, system.arrays.reach)
        first += effect.states


def contact_moments(effect: Effect, q: Array, reach: Array) -> Array:
    """Return the joint moments (B, N) [N m] of a contact force, for angles [rad] and link lengths [m] (B, N)."""
    theta, p = q.cumsum(axis=1), _columns(effect.p)
    rest = reach[:, ::-1].cumsum(axis=1)[:, ::-1]  # from each joint to the tip
    beyond = (1 - effect.place(p)) * (rest[:, :1] + reach[:, :1] - reach[:, -1:])  # [m] from the point of contact to the tip
    carried = np.clip(rest - beyond, 0.0, reach)  # part of each link before the point of contact
    force = effect.contact_force(p, (carried * np.sin(theta)).sum(axis=1, keepdims=True))
    return np.asarray(-force * (carried * np.cos(theta))[:, ::-1].cumsum(axis=1)[:, ::-1])


def update_states(system: PinocchioSystem, z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """Compute the states (states, B, N) of the laws after a motion of the joints.

    The joint angles change from ``start`` to ``end`` (B, N) [rad] within ``elapsed`` [s].
    """
    updated_states(system.effects, z, start, end, elapsed, out)
    update_contacts(system, z, start, end, elapsed, out)


def update_contacts(system: PinocchioSystem, z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """Compute the states of friction after a motion, as :func:`hsr_pin.simulation.kernel.update_contacts`."""
    arrays = system.arrays
    if arrays.touch[2] < 0:
        return
    before, after, new = _bristles(system, z), _bristles(system, out), np.zeros((2, contact.POSES, arrays.reach.shape[1]))
    poses = contact.poses_in_space if np.iscomplexobj(z) else contact.poses_in_plane
    for b in range(len(start)):
        world, reach = arrays.world[b], arrays.reach[b]
        for pose, g in zip((start[b], end[b]), new, strict=True):
            poses(pose, np.zeros_like(pose), world[0, contact.START], reach, g)
        contact.slide(new[0], new[1], before[:, :, b], reach, world, system.points, after[:, :, b])
    if np.isinf(elapsed):  # no friction acts in a pose that was reached before the simulation
        after[:] = 0.0


def updated_states(effects: tuple[Effect, ...], z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """Compute the states (states, B, N) of the given laws after a motion of the joints."""
    links, first = start.shape[1], 0
    for effect in effects:
        p = _columns(effect.p)
        for k in range(effect.states):
            out[first + k] = effect.update(p, k, z[first + k], links * start, links * end, elapsed)
        first += effect.states


def _columns(p: Any) -> Any:
    """Return the parameters of B arms in a shape that broadcasts to (B, N)."""
    return type(p)(*(value[:, None] if isinstance(value, np.ndarray) else value for value in p))


def single_arm(system: PinocchioSystem, b: int) -> PinocchioSystem:
    """Return the system of one of the arms."""
    chosen = slice(b, b + 1)
    effects = tuple(effect_subset(effect, chosen) for effect in system.effects)
    return PinocchioSystem(kernel.single_arm(system.arrays, b), system.models[chosen], system.data[chosen], effects, system.solve)


def add(total: Array, weight: float, term: Array) -> None:
    """Add ``weight`` times ``term`` to ``total``."""
    total += weight * term


def interpolate(q: Array, v: Array, q_end: Array, v_end: Array, h: float, x: float, angle: Array, rate: Array) -> None:
    """Interpolate angles and rates within a step, as :func:`hsr_pin.simulation.kernel.interpolate`."""
    rise = q_end - q
    first, last = h * v - rise, rise - h * v_end
    bow = first * (1 - x) + last * x
    angle[:] = (1 - x) * q + x * q_end + x * (1 - x) * bow
    rate[:] = (rise + (1 - 2 * x) * bow + x * (1 - x) * (last - first)) / h


def bending_angle(q: Array, b: int) -> float:
    """Return the bending angle [rad] of a whole arm."""
    return float(q[b].sum())
