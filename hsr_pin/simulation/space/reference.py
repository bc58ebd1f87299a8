"""The functions of the loops for arms in space with Pinocchio's spherical joints: the reference for the compiled loops.

The velocity of Pinocchio's spherical joint is the angular velocity in the body, Jexp3(w) w' for the rotation vector w. Forces and
inertias are transformed to the components of the vector, on which springs and dampers act. The bias is computed by the recursive
Newton-Euler algorithm, the mass matrix by CRBA; the cost is O(N^3).
"""

from __future__ import annotations

from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
import pinocchio as pin

from hsr_pin.effects.effect import effect_subset
from hsr_pin.robot.rotations import vectors
from hsr_pin.simulation import contact, integrate, reference
from hsr_pin.simulation.compiled import Loops
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.space import equilibrium, kernel
from hsr_pin.simulation.space.elements import drift as drift_of
from hsr_pin.simulation.space.elements import factors
from hsr_pin.simulation.space.kernel import bends
from hsr_pin.trajectory import Array

#: Smallest angle [rad] at which Pinocchio's second derivative of the logarithm is accurate; it is undefined at the straight pose.
_CLEAR = 0.1
#: Matrix (3, 3) from a joint's rotation vector to its coordinates; its transpose is the inverse.
_ORDER = vectors(np.eye(3))


def substep(
    system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array, torque: Array, d: float, scratch: Array
) -> None:
    """Take a linearly implicit Euler step in place, as :func:`hsr_pin.simulation.space.kernel.substep`."""
    for b in range(len(q)):
        v[b] += d * acceleration(system, b, q[b], v[b], z, moment[b], torque[b], d)
    q += d * v


def acceleration(system: PinocchioSystem, b: int, q: Array, v: Array, z: Array, moment: Array, torque: Array, d: float) -> Array:
    """Return the joint accelerations (3 N,) [rad/s^2] of one arm, with the implicit terms of a step of length d [s]."""
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
    if a.world.shape[1]:
        added, force = _contacts(system, b, q, v, z, d)
        left, right = left + added, right - force
    out = np.zeros(len(q))
    out[moves] = np.linalg.solve(left[np.ix_(moves, moves)], right[moves])
    return out


def _contacts(system: PinocchioSystem, b: int, q: Array, v: Array, z: Array, d: float) -> tuple[Array, Array]:
    """Return what contacts add to the mass matrix (3 N, 3 N) and to the required torque (3 N,) of an arm in a substep."""
    reach, links = system.arrays.reach[b], len(q) // 3
    g, work = np.empty((contact.POSES, links)), np.empty((kernel.SCRATCH, 3 * links))
    contact.poses_in_space(q, v, system.arrays.world[b, 0, contact.START], reach, g)
    kernel.place(q, v, work)
    moves, drift = np.zeros((links, 6, 3 * links)), np.zeros((6, links))
    axes, bias, omega = work[8:11].T, work[13].reshape(-1, 3), g[9:12].T  # axes (3 N, 3): one for each coordinate
    for i in range(links):
        moves[i, :3, : 3 * i + 3] = axes[: 3 * i + 3].T
        for j in range(3 * i + 3):
            moves[i, 3:, j] = np.cross(axes[j], g[:3, i] - g[:3, j // 3])
        drift[:3, i] = bias[: i + 1].sum(axis=0)
        if i:
            along = reach[i - 1] * g[3:6, i - 1]
            spun = np.cross(omega[i - 1], np.cross(omega[i - 1], along))
            drift[3:, i] = drift[3:, i - 1] + np.cross(drift[:3, i - 1], along) + spun
    return reference.contacts(system, b, g, moves, drift, z, d)


def rigid_torques(model: pin.Model, data: pin.Data, q: Array, v: Array, a: Array) -> Array:
    """Return the torques (3 N,) [N m] of the bodies of one arm for a motion with the joint coordinates q, v, a (3 N,)."""
    whole, omega, drift, blocks = _in_bodies(q, v)
    return np.asarray(blocks.T @ pin.rnea(model, data, whole, omega, blocks @ a + drift))


def mass_matrix(model: pin.Model, data: pin.Data, q: Array) -> Array:
    """Return the mass matrix (3 N, 3 N) [kg m^2] of one arm for the joint coordinates q (3 N,)."""
    whole, _, _, blocks = _in_bodies(q, np.zeros(len(q)))
    upper = np.triu(pin.crba(model, data, whole))
    return np.asarray(blocks.T @ (upper + np.triu(upper, 1).T) @ blocks)


def _in_bodies(q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
    """Return Pinocchio's configuration (4 N,), angular velocities and their drift (3 N,), and d omega / d v (3 N, 3 N)."""
    w, w_rate = q.reshape(-1, 3) @ _ORDER, v.reshape(-1, 3) @ _ORDER
    turns = [pin.exp3(each) for each in w]
    whole = np.concatenate([pin.Quaternion(turn).coeffs() for turn in turns])
    to_body = [pin.Jexp3(each) for each in w]
    omega = np.concatenate([j @ rate for j, rate in zip(to_body, w_rate, strict=True)])
    blocks = np.zeros((len(q), len(q)))  # d omega / d v
    drift = np.zeros(len(q))
    for i, (turn, j) in enumerate(zip(turns, to_body, strict=True)):
        own = slice(3 * i, 3 * i + 3)
        blocks[own, own] = j @ _ORDER.T
        drift[own] = _drift(turn, w[i], w_rate[i], omega[own])
    return whole, omega, drift, blocks


def _drift(turn: Array, w: Array, rate: Array, omega: Array) -> Array:
    """Return the angular acceleration (3,) [rad/s^2] in the body if the rotation vector changes at a constant rate.

    Pinocchio computes it where its derivative is accurate.
    """
    if w @ w > _CLEAR**2:
        return np.asarray(-pin.Jexp3(w) @ pin.Hlog3(turn, omega) @ omega)
    _, c, db, dc = factors(float(w @ w))
    return np.asarray(turn.T @ drift_of(tuple(w), tuple(rate), db, c, dc))


def _forces(system: PinocchioSystem, b: int, torque: Array) -> pin.StdVec_Force:
    """Return the loads in the joint frames of the last forward kinematics."""
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


def add_joint_moments(system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array) -> None:
    """Add the moments of the laws, as :func:`hsr_pin.simulation.space.kernel.add_joint_moments`."""
    total = np.zeros((len(q), q.shape[1] // 3), dtype=complex)
    reference.add_joint_moments(system, bends(q), bends(v), z, total)
    moment[:, 0::3] += total.real
    moment[:, 1::3] += total.imag


def update_states(system: PinocchioSystem, z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """Compute the states of the laws after a motion, as :func:`hsr_pin.simulation.space.kernel.update_states`."""
    reference.updated_states(system.effects, z, bends(start), bends(end), elapsed, out)
    reference.update_contacts(system, z, start, end, elapsed, out)


def single_arm(system: PinocchioSystem, b: int) -> PinocchioSystem:
    """Return the system of one of the arms."""
    chosen = slice(b, b + 1)
    effects = tuple(effect_subset(effect, chosen) for effect in system.effects)
    return PinocchioSystem(kernel.single_arm(system.arrays, b), system.models[chosen], system.data[chosen], effects, system.solve)


@lru_cache(maxsize=1)
def python_loops() -> Loops:
    """Return the loops as Python functions with Pinocchio."""
    scope: dict[str, Any] = {name: getattr(kernel, name) for name in ("ROWS", "bending_angle", "mean_torque")}
    scope |= {
        "single_arm": single_arm,
        "update_states": update_states,
        "add_joint_moments": add_joint_moments,
        "substep": substep,
    }
    for module, names in (
        (integrate, ("extrapolate", "integrate", "integrate_separately", "advance")),
        (equilibrium, ("laws_at", "equilibrium")),
    ):
        for name in names:
            function = getattr(module, name)
            scope[name] = FunctionType(function.__code__, {**function.__globals__, **scope}, name, function.__defaults__)
    return Loops(scope["integrate"], scope["integrate_separately"], scope["advance"], scope["equilibrium"])
