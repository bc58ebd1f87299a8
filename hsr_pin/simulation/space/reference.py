"""What the march asks of arms in space, by Pinocchio's spherical joints: the reference for the compiled loops.

Pinocchio moves a spherical joint by its angular velocity in the body, Jexp3(w) w' of the rotation vector w: forces and inertias
are brought to the vector's own components, on which springs and dampers act. Bias by the recursive Newton-Euler algorithm, mass
matrix by CRBA; O(N^3).
"""

from __future__ import annotations

from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
import pinocchio as pin

from hsr_pin.effects.effect import columns_of
from hsr_pin.robot.rotations import vectors
from hsr_pin.simulation import march, reference
from hsr_pin.simulation.compiled import Loops
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.space import kernel, rest
from hsr_pin.simulation.space.elements import drift as drift_of
from hsr_pin.simulation.space.elements import factors
from hsr_pin.simulation.space.kernel import bends
from hsr_pin.trajectory import Array

#: Near the straight pose [rad] Pinocchio's second derivative of the logarithm loses its digits, and at it has none.
_CLEAR = 0.1
#: A joint's coordinates from its rotation vector: (3, 3), and the vector from them by the transpose.
_ORDER = vectors(np.eye(3))


def substep(system: PinocchioSystem, q: Array, v: Array, moment: Array, torque: Array, d: float, scratch: Array) -> None:
    """As :func:`hsr_pin.simulation.space.kernel.substep`."""
    for b in range(len(q)):
        v[b] += d * acceleration(system, b, q[b], v[b], moment[b], torque[b], d)
    q += d * v


def acceleration(system: PinocchioSystem, b: int, q: Array, v: Array, moment: Array, torque: Array, d: float) -> Array:
    """(3 N,) [rad/s^2] of one arm, with what a step of length d [s] treats implicitly."""
    a, model, data = system.arrays, system.models[b], system.data[b]
    whole, omega, drift, blocks = _in_bodies(q, v)
    pin.forwardKinematics(model, data, whole)
    bias = pin.rnea(model, data, whole, omega, drift, _forces(system, b, torque))
    upper = np.triu(pin.crba(model, data, whole))
    inertia = upper + np.triu(upper, 1).T

    def joints(bending: Array, twist: Array) -> Array:
        return np.column_stack([bending[b], bending[b], twist[b]]).ravel()

    moves = np.isfinite(joints(a.spring, a.twist))
    spring, damper = (np.where(moves, each, 0.0) for each in (joints(a.spring, a.twist), joints(a.damper, a.twist_damper)))
    stiff, drag = (np.where(moves, each, 0.0) for each in (joints(a.stiff, a.twist), joints(a.drag, a.twist_damper)))
    parts = torque[: 2 * a.inputs.shape[1]].reshape(-1, 2)
    drive = (a.share[b][:, None] * (a.inputs @ np.column_stack([parts, np.zeros(len(parts))]))).ravel()
    right = drive - spring * q - (damper + d * stiff) * v - moment - blocks.T @ bias
    left = blocks.T @ inertia @ blocks + np.diag(d * (drag + d * stiff))
    out = np.zeros(len(q))
    out[moves] = np.linalg.solve(left[np.ix_(moves, moves)], right[moves])
    return out


def rigid_torques(model: pin.Model, data: pin.Data, q: Array, v: Array, a: Array) -> Array:
    """(3 N,) [N m] that the bodies of one arm take in a motion, on the coordinates q, v, a (3 N,) of its joints."""
    whole, omega, drift, blocks = _in_bodies(q, v)
    return np.asarray(blocks.T @ pin.rnea(model, data, whole, omega, blocks @ a + drift))


def mass_matrix(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """(3 N, 3 N) [kg m^2] of one arm, on the coordinates q (3 N,) of its joints."""
    whole, _, _, blocks = _in_bodies(q, np.zeros(len(q)))
    upper = np.triu(pin.crba(model, data, whole))
    return np.asarray(blocks.T @ (upper + np.triu(upper, 1).T) @ blocks)


def _in_bodies(q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
    """Pinocchio's configuration (4 N,), angular velocities and what they change by at even rates (3 N,), and d omega / d v."""
    w, w_rate = q.reshape(-1, 3) @ _ORDER, v.reshape(-1, 3) @ _ORDER
    turns = [pin.exp3(each) for each in w]
    whole = np.concatenate([pin.Quaternion(turn).coeffs() for turn in turns])
    to_body = [pin.Jexp3(each) for each in w]
    omega = np.concatenate([j @ rate for j, rate in zip(to_body, w_rate, strict=True)])
    blocks = np.zeros((len(q), len(q)))  # from the coordinates' rates
    drift = np.zeros(len(q))
    for i, (turn, j) in enumerate(zip(turns, to_body, strict=True)):
        own = slice(3 * i, 3 * i + 3)
        blocks[own, own] = j @ _ORDER.T
        drift[own] = _drift(turn, w[i], w_rate[i], omega[own])
    return whole, omega, drift, blocks


def _drift(turn: Array, w: Array, rate: Array, omega: Array) -> Array:
    """(3,) [rad/s^2] in the body, where the rotation vector changes at an even rate; by Pinocchio where it has all digits."""
    if w @ w > _CLEAR**2:
        return np.asarray(-pin.Jexp3(w) @ pin.Hlog3(turn, omega) @ omega)
    _, c, db, dc = factors(float(w @ w))
    return np.asarray(turn.T @ drift_of(tuple(w), tuple(rate), db, c, dc))


def _forces(system: PinocchioSystem, b: int, torque: Array) -> pin.StdVec_Force:
    """The loads in the frames of the joints, whose places are those of the last forward kinematics."""
    model, data, a = system.models[b], system.data[b], system.arrays
    found = pin.StdVec_Force()
    found.extend([pin.Force.Zero() for _ in range(model.njoints)])
    base = model.jointPlacements[1].rotation
    wrenches = torque[2 * a.inputs.shape[1] :].reshape(-1, 2, 3)
    for k, link in enumerate(a.link[b].tolist()):
        if link >= 0:
            force, turn = (data.oMi[link + 1].rotation.T @ base @ part for part in wrenches[k])
            found[link + 1] += pin.Force(force, turn + a.place[b, k] * np.cross([0.0, 0.0, 1.0], force))
    return found


def resist(system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array) -> None:
    """As :func:`hsr_pin.simulation.space.kernel.resist`."""
    total = np.zeros((len(q), q.shape[1] // 3), dtype=complex)
    reference.resist(system, bends(q), bends(v), z, total)
    moment[:, 0::3] += total.real
    moment[:, 1::3] += total.imag


def remember(system: PinocchioSystem, z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """As :func:`hsr_pin.simulation.space.kernel.remember`."""
    reference.remembered(system.effects, z, bends(start), bends(end), elapsed, out)


def alone(system: PinocchioSystem, b: int) -> PinocchioSystem:
    """One of the arms."""
    chosen = slice(b, b + 1)
    effects = tuple(columns_of(effect, chosen) for effect in system.effects)
    return PinocchioSystem(kernel.alone(system.arrays, b), system.models[chosen], system.data[chosen], effects, system.solve)


@lru_cache(maxsize=1)
def python_loops() -> Loops:
    """The march and the search for rest as Python, over Pinocchio."""
    scope: dict[str, Any] = {name: getattr(kernel, name) for name in ("ROWS", "bent", "mean_torque")}
    scope |= {"alone": alone, "remember": remember, "resist": resist, "substep": substep}
    for module, names in ((march, ("extrapolate", "march", "march_apart", "advance")), (rest, ("laws_at", "rest"))):
        for name in names:
            function = getattr(module, name)
            scope[name] = FunctionType(function.__code__, {**function.__globals__, **scope}, name, function.__defaults__)
    return Loops(scope["march"], scope["march_apart"], scope["advance"], scope["rest"])
