"""The inner loops of arms in space, for the compiler: one substep of a chain of spherical joints, and array operations.

They correspond to :mod:`hsr_pin.simulation.kernel`. The input of an arm is a row of U = 2 S + 6 K numbers: for each section the
torques towards x and towards y, then force and moment of each load.
"""

from __future__ import annotations

from math import hypot, inf
from typing import Any

import numpy as np

from hsr_pin.simulation.kernel import ADDED, add_contacts, call_law, update_contacts
from hsr_pin.simulation.kernel import add as add
from hsr_pin.simulation.kernel import interpolate as interpolate
from hsr_pin.simulation.space.elements import Vector, combined, cross, dot, drift, factors, plus, turned
from hsr_pin.simulation.space.system import SpaceSystem
from hsr_pin.trajectory import Array

#: Rows of the scratch array. For each coordinate: moment and force of the outboard chain per unit of acceleration, 1/D, free
#: torque and axis; for each joint: direction of its link, angular velocity and drift.
SCRATCH = 14
#: Rows of the scratch array: also what contacts add, (ADDED, N), and two rows for the time integration.
ROWS = SCRATCH + ADDED // 3 + 2
#: Functions that are compiled, in the order of their dependencies.
PARTS = (
    *("dot", "cross", "plus", "factors", "turned", "drift", "combined", "place", "add_contacts", "added", "gather", "move"),
    *("substep", "mean_torque", "add", "interpolate", "bending_angle", "single_arm", "bends", "add_joint_moments"),
    *("update_contacts", "update_states"),
)


def substep(system: Any, q: Array, v: Array, z: Array, moment: Array, torque: Array, d: float, scratch: Array) -> None:
    """Take a linearly implicit Euler step in place: (M + d D + d^2 K) a = f(q, v) - d K v, v += d a, q += d v.

    The articulated-body algorithm (R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, ch. 7), with every link in the
    axes of the base. The three coordinates of a joint are eliminated one by one, like three hinges at one point; a joint that
    does not twist has two.

    Args:
        system: the arms.
        q: (B, 3 N) coordinates [rad].
        v: (B, 3 N) rates [rad/s].
        z: (states, B, N) complex states of the laws and of the contacts.
        moment: (B, 3 N) moments of the laws, which oppose bending [N m].
        torque: (B, U) torques and loads.
        d: step length [s].
        scratch: (ROWS, 3 N) workspace.
    """
    for b in range(q.shape[0]):
        if system.world.shape[1]:
            add_contacts(system, b, q, v, z, d, scratch[SCRATCH:])
        place(q[b], v[b], scratch)
        gather(system, b, q[b], v[b], moment[b], torque[b], d, scratch)
        move(system, b, q[b], v[b], d, scratch)


def place(q: Array, v: Array, scratch: Array) -> None:
    """Compute the directions and the angular velocities of the links of an arm."""
    x, y, z, omega = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
    for i in range(len(q) // 3):
        j = 3 * i
        w, rate = (-q[j + 1], q[j], q[j + 2]), (-v[j + 1], v[j], v[j + 2])
        t = dot(w, w)
        bb, c, db, dc = factors(t)
        a = 1.0 - t * c
        towards_x = combined(x, y, z, turned(w, a, bb, c, (0.0, 1.0, 0.0)))
        towards_y = combined(x, y, z, turned(w, a, bb, c, (-1.0, 0.0, 0.0)))
        twist = combined(x, y, z, turned(w, a, bb, c, (0.0, 0.0, 1.0)))
        relative = combined(towards_x, towards_y, twist, (v[j], v[j + 1], v[j + 2]))
        bias = plus(combined(x, y, z, drift(w, rate, db, c, dc)), 1.0, cross(omega, relative))
        omega = plus(omega, 1.0, relative)
        straight = 1.0 - t * bb
        x, y, z = (
            combined(x, y, z, turned(w, straight, a, bb, (1.0, 0.0, 0.0))),
            combined(x, y, z, turned(w, straight, a, bb, (0.0, 1.0, 0.0))),
            combined(x, y, z, turned(w, straight, a, bb, (0.0, 0.0, 1.0))),
        )
        scratch[8, j], scratch[9, j], scratch[10, j] = towards_x
        scratch[8, j + 1], scratch[9, j + 1], scratch[10, j + 1] = towards_y
        scratch[8, j + 2], scratch[9, j + 2], scratch[10, j + 2] = twist
        scratch[11, j], scratch[11, j + 1], scratch[11, j + 2] = z
        scratch[12, j], scratch[12, j + 1], scratch[12, j + 2] = omega
        scratch[13, j], scratch[13, j + 1], scratch[13, j + 2] = bias


def added(scratch: Array, row: int, i: int, links: int) -> Vector:
    """Return three successive rows of what contacts add to link i."""
    first = SCRATCH + row // 3  # rows of N links within rows of 3 N
    return scratch[first, i], scratch[first, links + i], scratch[first, 2 * links + i]


def gather(system: Any, b: int, q: Array, v: Array, moment: Array, torque: Array, d: float, scratch: Array) -> None:
    """Compute articulated inertias and forces from tip to base.

    The inertias are J, the rows of H, and M; symmetric matrices have six entries. For the angular acceleration alpha and the
    acceleration a of its joint, a link requires the moment J alpha + H a + n and the force H' alpha + M a + f.
    """
    loads, sections, links = system.link.shape[1], system.inputs.shape[1], len(q) // 3
    none = (0.0, 0.0, 0.0)
    h0, h1, h2, n, f = none, none, none, none, none
    j00, j01, j02, j11, j12, j22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    m00, m01, m02, m11, m12, m22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    g = (system.gravity[b, 0], system.gravity[b, 1], system.gravity[b, 2])
    for step in range(len(q) // 3):
        i = len(q) // 3 - 1 - step
        j = 3 * i
        axis = (scratch[11, j], scratch[11, j + 1], scratch[11, j + 2])
        omega = (scratch[12, j], scratch[12, j + 1], scratch[12, j + 2])
        bias = (scratch[13, j], scratch[13, j + 1], scratch[13, j + 2])
        inwards = cross(omega, cross(omega, axis))
        # transform from the next joint to this one
        r = (system.reach[b, i] * axis[0], system.reach[b, i] * axis[1], system.reach[b, i] * axis[2])
        bow = (system.reach[b, i] * inwards[0], system.reach[b, i] * inwards[1], system.reach[b, i] * inwards[2])
        n = plus(n, 1.0, (dot(h0, bow), dot(h1, bow), dot(h2, bow)))
        m0, m1, m2 = (m00, m01, m02), (m01, m11, m12), (m02, m12, m22)
        f = plus(f, 1.0, (dot(m0, bow), dot(m1, bow), dot(m2, bow)))
        n = plus(n, 1.0, cross(r, f))
        s0, s1, s2 = cross(r, h0), cross(r, h1), cross(r, h2)
        c0, c1, c2 = cross(r, m0), cross(r, m1), cross(r, m2)
        h0 = (h0[0] + c0[0], h0[1] + c1[0], h0[2] + c2[0])
        h1 = (h1[0] + c0[1], h1[1] + c1[1], h1[2] + c2[1])
        h2 = (h2[0] + c0[2], h2[1] + c1[2], h2[2] + c2[2])
        e0, e1, e2 = cross(r, h0), cross(r, h1), cross(r, h2)
        j00, j01, j02 = j00 + s0[0] + e0[0], j01 + s0[1] + e1[0], j02 + s0[2] + e2[0]
        j11, j12, j22 = j11 + s1[1] + e1[1], j12 + s1[2] + e2[1], j22 + s2[2] + e2[2]
        # the link itself
        m, lever = system.mass[b, i], system.lever[b, i]
        arm, across = m * lever, system.inertia[b, i] + m * lever * lever
        more = system.axial[b, i] - across
        j00, j01, j02 = j00 + across + more * axis[0] * axis[0], j01 + more * axis[0] * axis[1], j02 + more * axis[0] * axis[2]
        j11, j12 = j11 + across + more * axis[1] * axis[1], j12 + more * axis[1] * axis[2]
        j22 += across + more * axis[2] * axis[2]
        h0 = (h0[0], h0[1] - arm * axis[2], h0[2] + arm * axis[1])
        h1 = (h1[0] + arm * axis[2], h1[1], h1[2] - arm * axis[0])
        h2 = (h2[0] - arm * axis[1], h2[1] + arm * axis[0], h2[2])
        m00, m11, m22 = m00 + m, m11 + m, m22 + m
        f = plus(plus(f, arm, inwards), -m, g)
        n = plus(plus(n, more * dot(axis, omega), cross(omega, axis)), -arm, cross(axis, g))
        for k in range(loads):
            if system.link[b, k] == i:
                u = 2 * sections + 6 * k
                force, turn = (torque[u], torque[u + 1], torque[u + 2]), (torque[u + 3], torque[u + 4], torque[u + 5])
                f = plus(f, -1.0, force)
                n = plus(plus(n, -1.0, turn), -system.place[b, k], cross(axis, force))
        if system.world.shape[1]:
            top, low = added(scratch, 0, i, links), added(scratch, 3, i, links)
            j00, j01, j02, j11, j12, j22 = j00 + top[0], j01 + top[1], j02 + top[2], j11 + low[0], j12 + low[1], j22 + low[2]
            h0, h1 = plus(h0, 1.0, added(scratch, 6, i, links)), plus(h1, 1.0, added(scratch, 9, i, links))
            h2 = plus(h2, 1.0, added(scratch, 12, i, links))
            top, low = added(scratch, 15, i, links), added(scratch, 18, i, links)
            m00, m01, m02, m11, m12, m22 = m00 + top[0], m01 + top[1], m02 + top[2], m11 + low[0], m12 + low[1], m22 + low[2]
            n, f = plus(n, 1.0, added(scratch, 21, i, links)), plus(f, 1.0, added(scratch, 24, i, links))
        # the joint
        f = plus(f, 1.0, combined(h0, h1, h2, bias))
        n = plus(n, 1.0, combined((j00, j01, j02), (j01, j11, j12), (j02, j12, j22), bias))
        for k in range(3):
            if k == 2 and system.twist[b, i] == inf:
                scratch[6, j + k], scratch[7, j + k] = 0.0, 0.0
                for row in range(6):
                    scratch[row, j + k] = 0.0
                continue
            spring, damper, share = system.spring[b, i], system.damper[b, i], system.share[b, i]
            stiff, drag = system.stiff[b, i], system.drag[b, i]
            drive = 0.0
            if k == 2:
                spring, damper, share = system.twist[b, i], system.twist_damper[b, i], 0.0
                stiff, drag = spring, damper
            else:
                for part in range(sections):
                    drive += system.inputs[i, part] * torque[2 * part + k]
            s = (scratch[8, j + k], scratch[9, j + k], scratch[10, j + k])
            un = combined((j00, j01, j02), (j01, j11, j12), (j02, j12, j22), s)
            uf = combined(h0, h1, h2, s)
            free = share * drive - spring * q[j + k] - (damper + d * stiff) * v[j + k] - moment[j + k] - dot(s, n)
            over = 1.0 / (dot(s, un) + d * (drag + d * stiff))
            scratch[0, j + k], scratch[1, j + k], scratch[2, j + k] = un
            scratch[3, j + k], scratch[4, j + k], scratch[5, j + k] = uf
            scratch[6, j + k], scratch[7, j + k] = over, free
            n, f = plus(n, free * over, un), plus(f, free * over, uf)
            j00, j01, j02 = j00 - over * un[0] * un[0], j01 - over * un[0] * un[1], j02 - over * un[0] * un[2]
            j11, j12, j22 = j11 - over * un[1] * un[1], j12 - over * un[1] * un[2], j22 - over * un[2] * un[2]
            h0, h1, h2 = plus(h0, -over * un[0], uf), plus(h1, -over * un[1], uf), plus(h2, -over * un[2], uf)
            m00, m01, m02 = m00 - over * uf[0] * uf[0], m01 - over * uf[0] * uf[1], m02 - over * uf[0] * uf[2]
            m11, m12, m22 = m11 - over * uf[1] * uf[1], m12 - over * uf[1] * uf[2], m22 - over * uf[2] * uf[2]


def move(system: Any, b: int, q: Array, v: Array, d: float, scratch: Array) -> None:
    """Compute accelerations from base to tip, and advance the arm by the step."""
    alpha, a = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(len(q) // 3):
        j = 3 * i
        for step in range(3):
            k = 2 - step
            un = (scratch[0, j + k], scratch[1, j + k], scratch[2, j + k])
            uf = (scratch[3, j + k], scratch[4, j + k], scratch[5, j + k])
            change = (scratch[7, j + k] - dot(un, alpha) - dot(uf, a)) * scratch[6, j + k]
            alpha = plus(alpha, change, (scratch[8, j + k], scratch[9, j + k], scratch[10, j + k]))
            v[j + k] += d * change
            q[j + k] += d * v[j + k]
        alpha = plus(alpha, 1.0, (scratch[13, j], scratch[13, j + 1], scratch[13, j + 2]))
        axis = (scratch[11, j], scratch[11, j + 1], scratch[11, j + 2])
        omega = (scratch[12, j], scratch[12, j + 1], scratch[12, j + 2])
        a = plus(a, system.reach[b, i], plus(cross(alpha, axis), 1.0, cross(omega, cross(omega, axis))))


def mean_torque(impulse: Array, start: float, end: float, torque: Array) -> None:
    """Compute the mean of inputs (B, C + 1, U) over an interval, as :func:`hsr_pin.simulation.integrate.mean_torque`."""
    cells = impulse.shape[1] - 1
    first, last = min(int(start), cells - 1), min(int(end), cells - 1)
    for b in range(impulse.shape[0]):
        for u in range(impulse.shape[2]):
            low = impulse[b, first, u] + (start - first) * (impulse[b, first + 1, u] - impulse[b, first, u])
            high = impulse[b, last, u] + (end - last) * (impulse[b, last + 1, u] - impulse[b, last, u])
            torque[b, u] = (high - low) / (end - start)


def bending_angle(q: Array, b: int) -> float:
    """Return the bending angle [rad] of a whole arm: the length of the sum of the bending vectors of its joints."""
    x, y = 0.0, 0.0
    for i in range(q.shape[1] // 3):
        x += q[b, 3 * i]
        y += q[b, 3 * i + 1]
    return hypot(x, y)


def single_arm(system: Any, b: int) -> Any:
    """Return the system of one of the arms."""
    s, e = system, b + 1
    return SpaceSystem(
        s.mass[b:e], s.lever[b:e], s.inertia[b:e], s.reach[b:e], s.axial[b:e], s.spring[b:e], s.damper[b:e], s.stiff[b:e],
        s.drag[b:e], s.share[b:e], s.profile[b:e], s.twist[b:e], s.twist_damper[b:e], s.gravity[b:e], s.keq[b:e], s.laws,
        np.ascontiguousarray(s.numbers[:, :, b:e]), s.world[b:e], s.touch, s.link[b:e], s.place[b:e], s.inputs,
    )  # fmt: skip


def bends(q: Array) -> Any:
    """Return the bending towards x and towards y as complex numbers (B, N), from coordinates (B, 3 N)."""
    count, links = q.shape[0], q.shape[1] // 3
    out = np.empty((count, links), dtype=np.complex128)
    for b in range(count):
        for i in range(links):
            out[b, i] = complex(q[b, 3 * i], q[b, 3 * i + 1])
    return out


def add_joint_moments(system: Any, q: Any, v: Any, z: Any, moment: Any) -> None:
    """Add the moments of the laws to ``moment`` (B, 3 N) [N m]; q and v are (B, 3 N), z is (states, B, N) complex."""
    angle, rate = bends(q), bends(v)
    total = np.zeros(angle.shape, dtype=np.complex128)
    for k in range(system.laws.shape[0]):
        first, numbers = system.laws[k, 2], system.numbers[k]
        call_law(
            system.laws[k, 0], angle, rate, system.keq, system.profile, system.profile, z[first:], numbers, total, angle.shape[0],
            angle.shape[1],
        )  # fmt: skip
    for b in range(angle.shape[0]):
        for i in range(angle.shape[1]):
            moment[b, 3 * i] += total[b, i].real
            moment[b, 3 * i + 1] += total[b, i].imag


def update_states(system: Any, z: Any, start: Any, end: Any, elapsed: float, out: Any) -> None:
    """Compute the complex states of the laws after a motion, as :func:`hsr_pin.simulation.kernel.update_states`."""
    before, after = bends(start), bends(end)
    for k in range(system.laws.shape[0]):
        if system.laws[k, 3]:
            first, numbers = system.laws[k, 2], system.numbers[k]
            call_law(system.laws[k, 1], z[first:], before, after, numbers, out[first:], before.shape[0], before.shape[1], elapsed)
    if system.world.shape[1]:
        update_contacts(system, z, start, end, elapsed, out)
