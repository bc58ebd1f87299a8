"""The equilibrium in space under a constant torque and loads, by a damped Newton method with pseudo-transient continuation.

The functions run as Python and compiled, like those of :mod:`hsr_pin.simulation.equilibrium`. Loads that keep their direction
make the stiffness matrix unsymmetric, and bending about two axes is coupled: the matrix is full, and its columns are finite
differences of the residual torque.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Any

import numpy as np

from hsr_pin.simulation.space.elements import combined, cross, dot, factors, plus, turned
from hsr_pin.simulation.space.kernel import add_joint_moments, single_arm, update_states
from hsr_pin.trajectory import Array

#: Residual torque [N m] at which the search stops, and the residual torque that is accepted if rounding prevents a smaller one.
TOLERANCE, ACCEPTED = 1e-12, 1e-8
#: Iterations of Newton's method, halvings of each of its steps, and iterations of the continuation.
_NEWTON, _HALVINGS, _CREEP = 60, 8, 400
#: Largest change of a coordinate in one step [rad].
_FARTHEST = 0.5
#: Step of the finite differences of the residual torque [rad].
_WIDTH = 1e-6
#: Torsional stiffness of a freely twisting arm during the search, relative to its bending stiffness.
_HELD = 1e-9
#: Functions that are compiled in addition to the search itself.
PARTS = ("laws_at", "imbalance", "matrix")


def laws_at(system: Any, q: Array, work: Array, z: Array, moment: Array) -> None:
    """Compute the moments (B, 3 N) [N m] of the laws in arms at rest in a pose q that was reached from the straight arm."""
    moment[:] = 0.0
    if system.laws.shape[0]:
        work[:] = 0.0
        z[0] = 0.0
        update_states(system, z[0], work, q, inf, z[1])
        add_joint_moments(system, q, work, z[1], moment)


def imbalance(arrays: Any, b: int, q: Array, drive: Array, moment: Array, out: Array, axes: Array) -> None:
    """Compute the residual torques (3 N,) [N m] of the coordinates q (3 N,) of arm b; ``axes`` (4, 3 N) is a workspace."""
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    links, sections = len(q) // 3, arrays.inputs.shape[1]
    for i in range(links):
        j = 3 * i
        w = (-q[j + 1], q[j], q[j + 2])
        t = dot(w, w)
        bb, c, _, _ = factors(t)
        a = 1.0 - t * c
        towards_x = combined(x, y, z, turned(w, a, bb, c, (0.0, 1.0, 0.0)))
        towards_y = combined(x, y, z, turned(w, a, bb, c, (-1.0, 0.0, 0.0)))
        twist = combined(x, y, z, turned(w, a, bb, c, (0.0, 0.0, 1.0)))
        straight = 1.0 - t * bb
        x, y, z = (
            combined(x, y, z, turned(w, straight, a, bb, (1.0, 0.0, 0.0))),
            combined(x, y, z, turned(w, straight, a, bb, (0.0, 1.0, 0.0))),
            combined(x, y, z, turned(w, straight, a, bb, (0.0, 0.0, 1.0))),
        )
        for k in range(3):
            axes[k, j], axes[k, j + 1], axes[k, j + 2], axes[3, j + k] = towards_x[k], towards_y[k], twist[k], z[k]
    g = (arrays.gravity[b, 0], arrays.gravity[b, 1], arrays.gravity[b, 2])
    force, turn = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)  # of all bodies and loads beyond the joint
    for step in range(links):
        i = links - 1 - step
        j = 3 * i
        axis = (axes[3, j], axes[3, j + 1], axes[3, j + 2])
        turn = plus(turn, arrays.reach[b, i], cross(axis, force))
        force = plus(force, arrays.mass[b, i], g)
        turn = plus(turn, arrays.mass[b, i] * arrays.lever[b, i], cross(axis, g))
        for k in range(arrays.link.shape[1]):
            if arrays.link[b, k] == i:
                u = 2 * sections + 6 * k
                load = (drive[u], drive[u + 1], drive[u + 2])
                force = plus(force, 1.0, load)
                turn = plus(plus(turn, 1.0, (drive[u + 3], drive[u + 4], drive[u + 5])), arrays.place[b, k], cross(axis, load))
        for k in range(3):
            pull = dot((axes[0, j + k], axes[1, j + k], axes[2, j + k]), turn) - moment[j + k]
            if k < 2:
                given = 0.0
                for part in range(sections):
                    given += arrays.inputs[i, part] * drive[2 * part + k]
                out[j + k] = arrays.share[b, i] * given - arrays.spring[b, i] * q[j + k] + pull
            elif arrays.twist[b, i] == inf:
                out[j + k] = 0.0
            else:
                out[j + k] = pull - arrays.twist[b, i] * q[j + k]


def matrix(arrays: Any, b: int, q: Array, drive: Array, free: Array, slope: Array, drag: float, out: Array, axes: Array) -> Array:
    """Return the stiffness matrix (3 N, 3 N) of an arm in a pose.

    Args:
        arrays: the arrays of the arms.
        b: index of the arm.
        q: (3 N,) coordinates [rad].
        drive: (U,) torques and loads.
        free: (3 N,) zeros.
        slope: (2, 3 N) derivatives of the laws' moments with respect to bending towards x and towards y.
        drag: stiffness that the continuation adds [Nm/rad].
        out: (3, 3 N) workspace.
        axes: (4, 3 N) workspace.
    """
    size = len(q)
    full = np.zeros((size, size))
    for j in range(size):
        i = j // 3
        if j % 3 == 2 and arrays.twist[b, i] == inf:
            full[j, j] = 1.0
            continue
        out[0] = q
        out[0, j] = q[j] + _WIDTH
        imbalance(arrays, b, out[0], drive, free, out[1], axes)
        out[0, j] = q[j] - _WIDTH
        imbalance(arrays, b, out[0], drive, free, out[2], axes)
        full[:, j] = (out[2] - out[1]) / (2 * _WIDTH)
        full[j, j] += drag + (_HELD * arrays.spring[b, i] if j % 3 == 2 else 0.0)
        if j % 3 < 2:
            full[3 * i, j] += slope[j % 3, 3 * i]
            full[3 * i + 1, j] += slope[j % 3, 3 * i + 1]
    return full


def equilibrium(system: Any, arrays: Any, torque: Array, wanted: Array, q: Array, found: Array, states: int) -> None:
    """Find the poses in which arms rest, loaded from the straight pose.

    Args:
        system: the arms.
        arrays: the arrays of the arms (the same as ``system`` if compiled).
        torque: (B, U) torques and loads.
        wanted: (B,) whether to solve for each arm.
        q: (B, 3 N) initial poses of the search [rad]; overwritten with the equilibrium poses, or 0 if there is none.
        found: (B,) whether there is an equilibrium; overwritten.
        states: number of states of the laws.
    """
    count, size = q.shape
    z = np.zeros((2, states, 1, size // 3), dtype=np.complex128)
    still, moment, trial, behind = np.zeros((4, 1, size))
    slope, free, work, axes = np.zeros((2, 1, size)), np.zeros(size), np.zeros((3, size)), np.zeros((4, size))
    out, step, width = np.zeros(size), np.zeros(size), 3 * _WIDTH / size
    for b in range(count):
        if not wanted[b]:
            q[b] = 0.0
            continue
        one, pose, near, far, after = single_arm(system, b), q[b : b + 1], q[b].copy(), inf, inf
        for phase in range(2):
            drag = size * arrays.keq[b] if phase else 0.0
            for _ in range(_CREEP if phase else _NEWTON):
                laws_at(one, pose, still, z, moment)
                imbalance(arrays, b, q[b], torque[b], moment[0], out, axes)
                far, before = np.abs(out).max() / max(1.0, np.abs(torque[b]).max()), sqrt((out**2).sum())
                if not far >= TOLERANCE:
                    break
                if system.laws.shape[0]:
                    for k in range(2):
                        trial[:] = pose
                        trial[0, k::3] += width
                        laws_at(one, trial, still, z, slope[k])
                        trial[0, k::3] -= 2 * width
                        laws_at(one, trial, still, z, behind)
                        slope[k] = (slope[k] - behind) / (2 * width)
                stiffness = matrix(arrays, b, q[b], torque[b], free, slope[:, 0], drag, work, axes)
                step[:] = np.linalg.solve(stiffness, out)
                largest = np.abs(step).max()
                if not largest < inf:
                    break
                scale = min(1.0, _FARTHEST / largest)
                for _halving in range(1 if phase else _HALVINGS):
                    trial[0] = q[b] + scale * step
                    laws_at(one, trial, still, z, moment)
                    imbalance(arrays, b, trial[0], torque[b], moment[0], out, axes)
                    after = sqrt((out**2).sum())
                    if before < 1e-9 or after <= before * (1 - 1e-4 * scale):
                        break
                    scale /= 2
                q[b] = trial[0]
                if phase:
                    drag = min(drag * min(max(after / max(before, 1e-300), 0.3), 3.0), 100 * size * arrays.keq[b])
            found[b] = far < ACCEPTED
            if found[b]:
                break
            q[b] = near
        if not found[b]:
            q[b] = 0.0
