"""The equilibrium under a constant torque: share u - springs - laws + gravity = 0, by a damped Newton method.

If Newton's method fails (at kinks, or within play, where there is no stiffness), pseudo-transient continuation finds the
equilibrium: C. T. Kelley, D. E. Keyes, Convergence analysis of pseudo-transient continuation, SIAM J. Numer. Anal. 35 (1998).

The functions run as Python and compiled, like those of :mod:`~hsr_pin.simulation.integrate`. The potential of gravity is linear
in cos and sin of the link angles theta_i = q_1 + ... + q_i: -sum_i lean_i (g_x cos theta_i + g_y sin theta_i).
"""

from __future__ import annotations

from math import cos, inf, sin, sqrt
from typing import Any

import numpy as np

from hsr_pin.simulation.reference import add_joint_moments, update_states
from hsr_pin.trajectory import Array

#: Residual torque [N m] at which the search stops, and the residual torque that is accepted if rounding prevents a smaller one.
TOLERANCE, ACCEPTED = 1e-12, 1e-8
#: Iterations of Newton's method, halvings of each of its steps, and iterations of the continuation.
_NEWTON, _HALVINGS, _CREEP = 60, 8, 400
#: Largest change of a joint angle in one step [rad].
_FARTHEST = 0.5
#: Functions that are compiled in addition to the search itself.
PARTS = ("laws_at", "imbalance", "newton_step")


def laws_at(system: Any, q: Array, work: Array, z: Array, moment: Array) -> None:
    """Compute the moments (B, N) [N m] of the laws in arms at rest in a pose q (B, N) that was reached from the straight arm."""
    moment[:] = 0.0
    if system.laws.shape[0]:
        work[:] = 0.0
        z[0] = 0.0
        update_states(system, z[0], work, q, inf, z[1])
        add_joint_moments(system, q, work, z[1], moment)


def imbalance(arrays: Any, q: Array, torque: Array, moment: Array, out: Array) -> None:
    """Compute the residual torque (B, N) [N m] of each joint."""
    count, links = q.shape
    for b in range(count):
        theta = 0.0
        for i in range(links):
            theta += q[b, i]
            pull = arrays.lean[b, i] * (arrays.gravity[b, 1] * cos(theta) - arrays.gravity[b, 0] * sin(theta))
            out[b, i] = arrays.share[b, i] * torque[b] - arrays.spring[b, i] * q[b, i] - moment[b, i]
            moment[b, i] = pull
        total = 0.0
        for k in range(links):
            i = links - 1 - k
            total += moment[b, i]
            out[b, i] += total


def newton_step(joint: Array, link: Array, residual: Array, step: Array, work: Array) -> None:
    """Solve (diag(joint) + U diag(link) U^T) step = residual, (N,) each, where U is the upper triangular matrix of ones.

    The system is tridiagonal in the link angles; work (2, N).
    """
    links = len(joint)
    upper, right = work[0], work[1]
    singular = False
    for i in range(links):
        diagonal = joint[i] + link[i]
        value = residual[i]
        if i + 1 < links:
            diagonal += joint[i + 1]
            value -= residual[i + 1]
        if i:
            diagonal += joint[i] * upper[i - 1]
            value += joint[i] * right[i - 1]
        if diagonal == 0.0:
            singular = True
            break
        upper[i] = -joint[i + 1] / diagonal if i + 1 < links else 0.0
        right[i] = value / diagonal
    if singular:  # at the buckling point gravity is ignored
        step[:] = residual / joint
        return
    for k in range(links):
        i = links - 1 - k
        if i + 1 < links:
            right[i] -= upper[i] * right[i + 1]
    step[0] = right[0]
    for i in range(1, links):
        step[i] = right[i] - right[i - 1]


def equilibrium(system: Any, arrays: Any, torque: Array, wanted: Array, q: Array, found: Array, states: int) -> None:
    """Find the poses in which arms rest under constant torques, loaded from the straight pose.

    Args:
        system: the arms.
        arrays: the arrays of the arms (the same as ``system`` if compiled).
        torque: (B,) torques [N m].
        wanted: (B,) whether to solve for each arm.
        q: (B, N) initial poses of the search [rad]; overwritten with the equilibrium poses, or 0 if there is none.
        found: (B,) whether there is an equilibrium; overwritten.
        states: number of states of the laws.
    """
    count, links = q.shape
    z = np.zeros((2, states, count, links))
    still, moment, out, near, trial, ahead, behind, step = np.zeros((8, count, links))
    work, joint, link = np.zeros((2, links)), np.zeros(links), np.zeros(links)
    size, drag, scale, far = np.zeros(count), np.zeros(count), np.ones(count), np.zeros(count)
    near[:] = q
    width = 1e-6 / links
    for phase in range(2):
        for b in range(count):
            drag[b] = 3 * links * arrays.keq[b] if phase else 0.0
        for _ in range(_CREEP if phase else _NEWTON):
            laws_at(system, q, still, z, moment)
            imbalance(arrays, q, torque, moment, out)
            moving = False
            for b in range(count):
                size[b], far[b] = sqrt((out[b] ** 2).sum()), np.abs(out[b]).max()
                far[b] /= max(1.0, abs(torque[b]))
                if wanted[b] and not found[b] and not far[b] < TOLERANCE:
                    moving = True
            if not moving:
                break
            trial[:] = q + width
            laws_at(system, trial, still, z, ahead)
            trial[:] = q - width
            laws_at(system, trial, still, z, behind)
            step[:] = 0.0
            for b in range(count):
                if not wanted[b] or found[b] or far[b] < TOLERANCE:
                    continue
                theta = 0.0
                for i in range(links):
                    theta += q[b, i]
                    joint[i] = arrays.spring[b, i] + (ahead[b, i] - behind[b, i]) / (2 * width) + drag[b]
                    link[i] = arrays.lean[b, i] * (arrays.gravity[b, 0] * cos(theta) + arrays.gravity[b, 1] * sin(theta))
                newton_step(joint, link, out[b], step[b], work)
                largest = np.abs(step[b]).max()
                if largest > _FARTHEST:
                    step[b] *= _FARTHEST / largest
            if phase:
                q += step
                laws_at(system, q, still, z, moment)
                imbalance(arrays, q, torque, moment, out)
                for b in range(count):
                    change = sqrt((out[b] ** 2).sum()) / max(size[b], 1e-300)
                    drag[b] = min(drag[b] * min(max(change, 0.3), 3.0), 100 * links * arrays.keq[b])
                continue
            scale[:] = 1.0
            for _halving in range(_HALVINGS):
                for b in range(count):
                    trial[b] = q[b] + scale[b] * step[b]
                laws_at(system, trial, still, z, moment)
                imbalance(arrays, trial, torque, moment, out)
                worse = False
                for b in range(count):
                    if size[b] > 1e-9 and step[b].any() and not sqrt((out[b] ** 2).sum()) <= size[b] * (1 - 1e-4 * scale[b]):
                        scale[b] /= 2
                        worse = True
                if not worse:
                    break
            q[:] = trial
        laws_at(system, q, still, z, moment)
        imbalance(arrays, q, torque, moment, out)
        lost = False
        for b in range(count):
            if wanted[b] and not found[b]:
                found[b] = np.abs(out[b]).max() < ACCEPTED * max(1.0, abs(torque[b]))
                if not found[b]:
                    lost = True
                    q[b] = near[b]
        if not lost:
            break
    for b in range(count):
        if not found[b]:
            q[b] = 0.0
