"""The inner loops of planar arms, for the compiler: one substep of a chain, and array operations of the time integration.

The functions are written for numba (``hsr_pin.simulation.compiled``), which compiles each of them; they also run as Python,
slowly. :mod:`hsr_pin.simulation.reference` has the same functions with Pinocchio.
"""

from __future__ import annotations

from math import cos, inf, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.trajectory import Array

#: Rows of a substep's own numbers of each link: cos, sin, rate of the link, J, hx, hy, 1/D, free torque.
SCRATCH = 8
#: Rows that contacts add to: J (6 rows), the rows of H (9) and M (6), moment (3) and force (3).
ADDED = 27
#: Rows of the scratch array; the last two are for the time integration.
ROWS = SCRATCH + ADDED + 2
#: Functions that are compiled, in the order of their dependencies.
PARTS = (
    "add_contacts",
    "substep",
    "add",
    "interpolate",
    "bending_angle",
    "single_arm",
    "add_joint_moments",
    "update_contacts",
    "update_states",
)


class System(NamedTuple):
    """The arrays of B arms that the loops need.

    Attributes:
        mass, lever, inertia, reach: (B, N) as in :class:`hsr_pin.robot.chain.Chain`.
        lean: (B, N) first moment of all bodies that a link carries, about its joint [kg m].
        spring, damper: (B, N) stiffness [Nm/rad] and damping [Nm s/rad] of the joints.
        stiff, drag: (B, N) stiffness and damping that are treated implicitly, with an upper bound for the laws [Nm/rad], [Nm
            s/rad].
        share: (B, N) share of the torque that arrives at each joint.
        profile: (B, N) stiffness along the arm, relative to keq.
        gravity: (B, 2) as in :class:`hsr_pin.robot.chain.Chain`.
        keq: (B,) bending stiffness of the whole arm [Nm/rad].
        laws: (K, 4) for each law the addresses of its moment and its state update, the index of its first state, and its number
            of states.
        numbers: (K, P, B) parameters of the laws.
        world: (B, O, ENTRIES) obstacles as in :mod:`hsr_pin.simulation.contact`.
        touch: (4,) addresses of the contact law and of its state update, index of its first state or -1 without friction, and
            number of points of contact of a link.
    """

    mass: Array
    lever: Array
    inertia: Array
    reach: Array
    lean: Array
    spring: Array
    damper: Array
    stiff: Array
    drag: Array
    share: Array
    profile: Array
    gravity: Array
    keq: Array
    laws: NDArray[np.int64]
    numbers: Array
    world: Array
    touch: NDArray[np.int64]

    def packed(self) -> tuple[Any, ...]:
        """Return the fields as seven arrays, the first of shape (11, B, N)."""
        return np.array(self[:11]), *self[11:]


def substep(system: Any, q: Array, v: Array, z: Array, moment: Array, torque: Array, d: float, scratch: Array) -> None:
    """Take a linearly implicit Euler step in place: (M + d D + d^2 K) a = f(q, v) - d K v, v += d a, q += d v.

    The articulated-body algorithm (R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, ch. 7) in the plane. All links
    are expressed in the axes of the base, so that no quantity is rotated from link to link: an articulated inertia consists of J
    about the joint, the coupling h of force and rotation, and the apparent mass m in x and y.

    Args:
        system: the arms.
        q: (B, N) angles [rad].
        v: (B, N) rates [rad/s].
        z: (states, B, N) states of the laws and of the contacts.
        moment: (B, N) moments of the laws, which oppose bending [N m].
        torque: (B,) torque of the actuators [N m].
        d: step length [s].
        scratch: (ROWS, N) workspace.
    """
    count, links = q.shape
    c, s, omega, inertia = scratch[0], scratch[1], scratch[2], scratch[3]
    hx, hy, inverse, free = scratch[4], scratch[5], scratch[6], scratch[7]
    obstacles = system.world.shape[1]
    for b in range(count):
        if obstacles:
            add_contacts(system, b, q, v, z, d, scratch[SCRATCH:])
        gx, gy = system.gravity[b, 0], system.gravity[b, 1]
        angle, rate = 0.0, 0.0
        for i in range(links):
            angle += q[b, i]
            rate += v[b, i]
            c[i], s[i], omega[i] = cos(angle), sin(angle), rate
        # articulated inertia and force of the links beyond, about their first joint
        j_out, hx_out, hy_out, xx, xy, yy, turn, fx, fy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(links):
            i = links - 1 - k
            m, ml = system.mass[b, i], system.mass[b, i] * system.lever[b, i]
            w2 = omega[i] * omega[i]
            rx, ry = system.reach[b, i] * c[i], system.reach[b, i] * s[i]
            fx -= w2 * (xx * rx + xy * ry)  # transform from the next joint to this one: centripetal acceleration
            fy -= w2 * (xy * rx + yy * ry)
            sx, sy = xy * rx - xx * ry, yy * rx - xy * ry  # m times the next joint's displacement per rotation about this one
            turn += rx * fy - ry * fx - w2 * (hx_out * rx + hy_out * ry)
            j = j_out + 2 * (hy_out * rx - hx_out * ry) + rx * sy - ry * sx
            j += system.inertia[b, i] + ml * system.lever[b, i]
            x, y = hx_out + sx - ml * s[i], hy_out + sy + ml * c[i]
            turn -= ml * (c[i] * gy - s[i] * gx)
            fx -= ml * w2 * c[i] + m * gx
            fy -= ml * w2 * s[i] + m * gy
            xx += m
            yy += m
            if obstacles:  # J_zz, the last row of H, M in the plane, and the force
                j += scratch[SCRATCH + 5, i]
                x += scratch[SCRATCH + 12, i]
                y += scratch[SCRATCH + 13, i]
                xx += scratch[SCRATCH + 15, i]
                xy += scratch[SCRATCH + 16, i]
                yy += scratch[SCRATCH + 18, i]
                turn += scratch[SCRATCH + 23, i]
                fx += scratch[SCRATCH + 24, i]
                fy += scratch[SCRATCH + 25, i]
            stiff, drag = system.stiff[b, i], system.drag[b, i]
            u = system.share[b, i] * torque[b] - system.spring[b, i] * q[b, i] - system.damper[b, i] * v[b, i]
            u -= d * stiff * v[b, i] + moment[b, i] + turn
            over = 1.0 / (j + d * (drag + d * stiff))
            inertia[i], hx[i], hy[i], inverse[i], free[i] = j, x, y, over, u
            j_out, hx_out, hy_out = j - j * j * over, x - x * j * over, y - y * j * over
            xx -= x * x * over
            xy -= x * y * over
            yy -= y * y * over
            turn += j * u * over
            fx += x * u * over
            fy += y * u * over
        alpha, ax, ay = 0.0, 0.0, 0.0
        for i in range(links):
            a = (free[i] - inertia[i] * alpha - hx[i] * ax - hy[i] * ay) * inverse[i]
            alpha += a
            rx, ry = system.reach[b, i] * c[i], system.reach[b, i] * s[i]
            w2 = omega[i] * omega[i]
            ax -= alpha * ry + w2 * rx
            ay += alpha * rx - w2 * ry
            v[b, i] += d * a
            q[b, i] += d * v[b, i]


def add_contacts(system: Any, b: int, q: Array, v: Array, z: Array, d: float, out: Array) -> None:
    """Compute what contacts add to the links of an arm in a substep, as :func:`hsr_pin.simulation.contact.press`."""
    first = max(system.touch[2], 0)
    call_law(
        system.touch[0], q[b], v[b], z[first:], system.reach[b], system.world[b], out, q.shape[0], b, system.reach.shape[1],
        system.world.shape[1], system.touch[3], d,
    )  # fmt: skip


def add(total: Array, weight: float, term: Array) -> None:
    """Add ``weight`` times ``term`` to ``total`` in place, (B, N) each."""
    for b in range(total.shape[0]):
        for i in range(total.shape[1]):
            total[b, i] += weight * term[b, i]


def interpolate(q: Array, v: Array, q_end: Array, v_end: Array, h: float, x: float, angle: Array, rate: Array) -> None:
    """Interpolate angles and rates (B, N) at the fraction x of a step of length h [s], by the cubic Hermite polynomial."""
    y = 1.0 - x
    for b in range(q.shape[0]):
        for i in range(q.shape[1]):
            rise = q_end[b, i] - q[b, i]
            first, last = h * v[b, i] - rise, rise - h * v_end[b, i]
            angle[b, i] = y * q[b, i] + x * q_end[b, i] + x * y * (first * y + last * x)
            rate[b, i] = (rise + (1.0 - 2.0 * x) * (first * y + last * x) + x * y * (last - first)) / h


def bending_angle(q: Array, b: int) -> float:
    """Return the bending angle [rad] of a whole arm."""
    total = 0.0
    for i in range(q.shape[1]):
        total += q[b, i]
    return total


def single_arm(system: Any, b: int) -> Any:
    """Return the system of one of the arms."""
    s, e = system, b + 1
    return System(
        s.mass[b:e], s.lever[b:e], s.inertia[b:e], s.reach[b:e], s.lean[b:e], s.spring[b:e], s.damper[b:e], s.stiff[b:e],
        s.drag[b:e], s.share[b:e], s.profile[b:e], s.gravity[b:e], s.keq[b:e], s.laws, np.ascontiguousarray(s.numbers[:, :, b:e]),
        s.world[b:e], s.touch,
    )  # fmt: skip


def call_law(address: int, *arguments: Any) -> None:
    """Call machine code at an address with arrays as pointers; a placeholder that the compiler replaces."""
    raise NotImplementedError


def add_joint_moments(system: Any, q: Any, v: Any, z: Any, moment: Any) -> None:
    """Add the moments (B, N) [N m] of the laws to ``moment``; q and v are (B, N), z is (states, B, N)."""
    for k in range(system.laws.shape[0]):
        first = system.laws[k, 2]
        call_law(
            system.laws[k, 0], q, v, system.keq, system.profile, system.reach, z[first:], system.numbers[k], moment, q.shape[0],
            q.shape[1],
        )  # fmt: skip


def update_states(system: Any, z: Any, start: Any, end: Any, elapsed: float, out: Any) -> None:
    """Compute the states (states, B, N) of the laws after a motion of the joints.

    The joint angles change from ``start`` to ``end`` (B, N) [rad] within ``elapsed`` [s].
    """
    for k in range(system.laws.shape[0]):
        if system.laws[k, 3]:
            first, numbers = system.laws[k, 2], system.numbers[k]
            call_law(system.laws[k, 1], z[first:], start, end, numbers, out[first:], start.shape[0], start.shape[1], elapsed)
    if system.world.shape[1]:
        update_contacts(system, z, start, end, elapsed, out)


def update_contacts(system: Any, z: Any, start: Any, end: Any, elapsed: float, out: Any) -> None:
    """Compute the states of friction after a motion; no friction acts in a pose that was reached before the simulation."""
    first = system.touch[2]
    if first < 0:
        return
    if elapsed == inf:
        out[first:] = 0.0
        return
    for b in range(start.shape[0]):
        call_law(
            system.touch[1], z[first:], start[b], end[b], system.reach[b], system.world[b], out[first:], start.shape[0], b,
            system.reach.shape[1], system.world.shape[1], system.touch[3],
        )  # fmt: skip
