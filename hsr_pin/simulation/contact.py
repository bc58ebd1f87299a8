"""Contact of arms with obstacles: forces, their linearisation, and the state of friction, for the compiler.

An arm is a chain of capsules. Points at even distances along its backbone, with the arm's radius, bear the force per length of
:class:`hsr_pin.obstacles.Surface`: F = stiffness (1 + dissipation u) (depth n - b), with the closing speed u, the normal n, and
the tangential displacement b of the surface, which is limited by |b| <= friction depth. Normal: K. H. Hunt, F. R. E. Crossley,
Coefficient of restitution interpreted as damping in vibroimpact, J. Appl. Mech. 42 (1975). Friction: P. R. Dahl, A solid friction
model (1968), in the form of an elastic and perfectly plastic spring.

In a linearly implicit step of length d, a contact acts on its link like a small mass d (d stiffness + damping) at the point of
contact, which resists acceleration along the normal, and along the tangent where the surfaces stick. The articulated-body
algorithm therefore treats stiff contacts at the cost of a few additions.

The functions run as Python and compiled, like those of :mod:`~hsr_pin.simulation.integrate`. Vectors are in the axes of the base.
"""

from __future__ import annotations

from functools import cache, partial
from math import ceil, cos, sin, sqrt
from typing import Any

import numpy as np

from hsr_pin.obstacles import BOX, CYLINDER, DISSIPATION, FRICTION, SPHERE, STIFFNESS
from hsr_pin.obstacles import ENTRIES as SHAPE
from hsr_pin.simulation.code_cache import cached
from hsr_pin.simulation.kernel import ADDED
from hsr_pin.simulation.laws import with_helpers
from hsr_pin.simulation.source_hash import source_hash
from hsr_pin.simulation.space.elements import Vector
from hsr_pin.simulation.space.kernel import place as place_links
from hsr_pin.trajectory import Array

#: Rows of an array with the poses of N links: position of the joint, direction of the link, and their velocities.
POSES = 12
#: Entries of an obstacle: its row, then the arm's radius, the length of its round end, which counts as part of the last point,
#: and the place of the first joint [m].
ENTRIES, RADIUS, END, START = SHAPE + 3, SHAPE, SHAPE + 1, SHAPE + 2
#: Distance between two points of contact, relative to the arm's diameter. On a thin post, the surface deviates by 0.06 % of it.
SPACING = 0.05
#: States of friction per point: the components of a vector, in space as complex numbers without imaginary parts.
COMPONENTS = 3


def points_per_link(reach: Array, diameter: Array) -> int:
    """Return the number of points of contact of a link, for lengths (B, N) and diameters (B,) [m]."""
    return ceil(float((reach / (SPACING * diameter[:, None])).max()) - 1e-9)


def distance(w: Array, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return the distance [m] of a point from the surface of an obstacle w (ENTRIES,), negative inside, and the normal there."""
    x, y, z = x - w[1], y - w[2], z - w[3]
    a, b, c = w[4] * x + w[5] * y + w[6] * z, w[7] * x + w[8] * y + w[9] * z, w[10] * x + w[11] * y + w[12] * z
    na, nb, nc, gap = 0.0, 0.0, 1.0, c
    if w[0] == SPHERE:
        far = sqrt(a * a + b * b + c * c)
        gap = far - w[13]
        if far > 0.0:
            na, nb, nc = a / far, b / far, c / far
    elif w[0] == CYLINDER:
        far = sqrt(a * a + b * b)
        ra, rb = (a / far, b / far) if far > 0.0 else (1.0, 0.0)
        aside, ahead, sign = far - w[13], abs(c) - w[14], 1.0 if c >= 0.0 else -1.0
        if aside > 0.0 and ahead > 0.0:
            gap = sqrt(aside * aside + ahead * ahead)
            na, nb, nc = aside / gap * ra, aside / gap * rb, ahead / gap * sign
        elif aside > ahead:
            gap, na, nb, nc = aside, ra, rb, 0.0
        else:
            gap, nc = ahead, sign
    elif w[0] == BOX:
        sa, sb, sc = 1.0 if a >= 0.0 else -1.0, 1.0 if b >= 0.0 else -1.0, 1.0 if c >= 0.0 else -1.0
        a, b, c = abs(a) - w[13], abs(b) - w[14], abs(c) - w[15]
        if a > 0.0 or b > 0.0 or c > 0.0:
            ua, ub, uc = max(a, 0.0), max(b, 0.0), max(c, 0.0)
            gap = sqrt(ua * ua + ub * ub + uc * uc)
            na, nb, nc = sa * ua / gap, sb * ub / gap, sc * uc / gap
        else:
            gap = max(a, b, c)
            na, nb, nc = (sa, 0.0, 0.0) if a == gap else ((0.0, sb, 0.0) if b == gap else (0.0, 0.0, sc))
    nx, ny, nz = na * w[4] + nb * w[7] + nc * w[10], na * w[5] + nb * w[8] + nc * w[11], na * w[6] + nb * w[9] + nc * w[12]
    return gap, nx, ny, nz


def along_surface(x: float, y: float, z: float, nx: float, ny: float, nz: float, limit: float) -> tuple[float, float, float]:
    """Return the part of a displacement along a surface with a normal, up to a limit [m]."""
    away = x * nx + y * ny + z * nz
    x, y, z = x - away * nx, y - away * ny, z - away * nz
    size = sqrt(x * x + y * y + z * z)
    if size > limit:
        x, y, z = x * limit / size, y * limit / size, z * limit / size
    return x, y, z


def add_contact(
    out: Array, i: int, place: Vector, normal: Vector, along: float, across: float, drift: Vector, force: Vector
) -> None:
    """Add one contact to what contacts add to link i, as in :func:`press`.

    Args:
        out: (ADDED, N) sums.
        i: index of the link.
        place: point of contact, from the joint of the link [m].
        normal: normal of the surface.
        along: resistance to acceleration along the normal [kg].
        across: resistance to acceleration across the normal [kg].
        drift: centripetal acceleration of the point [m/s^2].
        force: force of the obstacle [N].
    """
    (nx, ny, nz), (rx, ry, rz), more = normal, place, along - across
    xx, xy, xz = across + more * nx * nx, more * nx * ny, more * nx * nz
    yy, yz, zz = across + more * ny * ny, more * ny * nz, across + more * nz * nz
    h00, h01, h02 = ry * xz - rz * xy, ry * yz - rz * yy, ry * zz - rz * yz  # r x
    h10, h11, h12 = rz * xx - rx * xz, rz * xy - rx * yz, rz * xz - rx * zz
    h20, h21, h22 = rx * xy - ry * xx, rx * yy - ry * xy, rx * yz - ry * xz
    out[0, i] += h02 * ry - h01 * rz  # -(r x) M (r x)
    out[1, i] += h00 * rz - h02 * rx
    out[2, i] += h01 * rx - h00 * ry
    out[3, i] += h10 * rz - h12 * rx
    out[4, i] += h11 * rx - h10 * ry
    out[5, i] += h21 * rx - h20 * ry
    out[6, i] += h00
    out[7, i] += h01
    out[8, i] += h02
    out[9, i] += h10
    out[10, i] += h11
    out[11, i] += h12
    out[12, i] += h20
    out[13, i] += h21
    out[14, i] += h22
    out[15, i] += xx
    out[16, i] += xy
    out[17, i] += xz
    out[18, i] += yy
    out[19, i] += yz
    out[20, i] += zz
    cx, cy, cz = drift
    fx, fy, fz = force
    fx, fy, fz = (
        xx * cx + xy * cy + xz * cz - fx,
        xy * cx + yy * cy + yz * cz - fy,
        xz * cx + yz * cy + zz * cz - fz,
    )
    out[21, i] += ry * fz - rz * fy
    out[22, i] += rz * fx - rx * fz
    out[23, i] += rx * fy - ry * fx
    out[24, i] += fx
    out[25, i] += fy
    out[26, i] += fz


def press(g: Array, b: Array, reach: Array, world: Array, points: int, d: float, out: Array) -> None:
    """Compute what contacts add to the inertias and forces of the links in a linearly implicit step.

    Args:
        g: (POSES, N) poses and velocities of the links.
        b: (points, 3, N) tangential displacements of the surfaces [m]; not read without friction.
        reach: (N,) lengths of the links [m].
        world: (O, ENTRIES) obstacles.
        points: number of points of contact of a link.
        d: length of the step [s].
        out: (ADDED, N) overwritten with the additions: at an angular acceleration alpha and an acceleration a of its joint, a
            link requires the moment J alpha + H a + n and the force H' alpha + M a + f.
    """
    out[:] = 0.0
    links = reach.shape[0]
    for o in range(world.shape[0]):
        w = world[o]
        radius = w[RADIUS]
        for i in range(links):
            half = reach[i] / 2
            ex, ey, ez = g[3, i], g[4, i], g[5, i]
            gap = distance(w, g[0, i] + half * ex, g[1, i] + half * ey, g[2, i] + half * ez)[0]
            if gap >= half + radius:  # no point of the link touches
                continue
            ox, oy, oz = g[9, i], g[10, i], g[11, i]
            for m in range(points):
                s = reach[i] * (m + 1) / points
                rx, ry, rz = s * ex, s * ey, s * ez
                gap, nx, ny, nz = distance(w, g[0, i] + rx, g[1, i] + ry, g[2, i] + rz)
                depth = radius - gap
                if depth <= 0.0:
                    continue
                length = reach[i] / points
                if i == links - 1 and m == points - 1:
                    length = length / 2 + w[END]
                tx, ty, tz = oy * rz - oz * ry, oz * rx - ox * rz, ox * ry - oy * rx  # omega x r
                ux, uy, uz = g[6, i] + tx, g[7, i] + ty, g[8, i] + tz
                closing = -(nx * ux + ny * uy + nz * uz)
                stiff = w[STIFFNESS] * length * max(1.0 + w[DISSIPATION] * closing, 0.0)
                normal, tangential = d * (d * stiff + w[STIFFNESS] * length * w[DISSIPATION] * depth), 0.0
                push = stiff * (depth + d * closing)
                fx, fy, fz = push * nx, push * ny, push * nz
                if w[FRICTION] > 0.0:
                    bx, by, bz = along_surface(b[m, 0, i], b[m, 1, i], b[m, 2, i], nx, ny, nz, w[FRICTION] * depth)
                    if bx * bx + by * by + bz * bz < (w[FRICTION] * depth) ** 2 * (1.0 - 1e-9):  # the surfaces stick
                        tangential = d * d * stiff
                        bx, by, bz = bx + d * (ux + closing * nx), by + d * (uy + closing * ny), bz + d * (uz + closing * nz)
                    fx, fy, fz = fx - stiff * bx, fy - stiff * by, fz - stiff * bz
                drift = (oy * tz - oz * ty, oz * tx - ox * tz, ox * ty - oy * tx)
                add_contact(out, i, (rx, ry, rz), (nx, ny, nz), normal, tangential, drift, (fx, fy, fz))


def elastic_energy(g: Array, reach: Array, world: Array, points: int) -> float:
    """Return the elastic energy [J] of the contacts of an arm, normal to the surfaces; arguments as for :func:`press`."""
    total = 0.0
    for w in world:
        for i in range(len(reach)):
            half = reach[i] / 2
            if distance(w, *(g[:3, i] + half * g[3:6, i]))[0] >= half + w[RADIUS]:
                continue
            for m in range(points):
                length = reach[i] / points
                if i == len(reach) - 1 and m == points - 1:
                    length = length / 2 + w[END]
                depth = w[RADIUS] - distance(w, *(g[:3, i] + reach[i] * (m + 1) / points * g[3:6, i]))[0]
                total += w[STIFFNESS] * length * max(depth, 0.0) ** 2 / 2
    return total


def slide(start: Array, end: Array, b: Array, reach: Array, world: Array, points: int, out: Array) -> None:
    """Compute the tangential displacements of the surfaces after a motion.

    Args:
        start: (POSES, N) poses of the links before the motion.
        end: (POSES, N) poses of the links after the motion.
        b: (points, 3, N) displacements before the motion [m].
        reach: as for :func:`press`.
        world: as for :func:`press`.
        points: as for :func:`press`.
        out: (points, 3, N) overwritten with the displacements after the motion [m]; one for all obstacles that a point touches.
    """
    out[:] = 0.0
    for o in range(world.shape[0]):
        w = world[o]
        radius = w[RADIUS]
        if w[FRICTION] == 0.0:
            continue
        for i in range(reach.shape[0]):
            half = reach[i] / 2
            gap = distance(w, end[0, i] + half * end[3, i], end[1, i] + half * end[4, i], end[2, i] + half * end[5, i])[0]
            if gap >= half + radius:
                continue
            for m in range(points):
                s = reach[i] * (m + 1) / points
                x, y, z = end[0, i] + s * end[3, i], end[1, i] + s * end[4, i], end[2, i] + s * end[5, i]
                gap, nx, ny, nz = distance(w, x, y, z)
                depth = radius - gap
                if depth <= 0.0:
                    continue
                ax, ay, az = start[0, i] + s * start[3, i], start[1, i] + s * start[4, i], start[2, i] + s * start[5, i]
                before = radius - distance(w, ax, ay, az)[0]
                part = depth / (depth - before) if before < 0.0 else 1.0  # of the motion, after the surfaces touched
                bx, by, bz = out[m, 0, i], out[m, 1, i], out[m, 2, i]
                if bx == 0.0 and by == 0.0 and bz == 0.0:  # it touches no other obstacle
                    bx, by, bz = b[m, 0, i] + part * (x - ax), b[m, 1, i] + part * (y - ay), b[m, 2, i] + part * (z - az)
                out[m, 0, i], out[m, 1, i], out[m, 2, i] = along_surface(bx, by, bz, nx, ny, nz, w[FRICTION] * depth)


def poses_in_plane(q: Array, v: Array, start: float, reach: Array, g: Array) -> None:
    """Compute the poses (POSES, N) of the links of a planar arm, whose first joint is at ``start`` [m] along the straight arm."""
    angle, rate, x, y, vx, vy = 0.0, 0.0, start, 0.0, 0.0, 0.0
    for i in range(reach.shape[0]):
        angle += q[i]
        rate += v[i]
        ex, ey = cos(angle), sin(angle)
        g[0, i], g[1, i], g[2, i], g[3, i], g[4, i], g[5, i] = x, y, 0.0, ex, ey, 0.0
        g[6, i], g[7, i], g[8, i], g[9, i], g[10, i], g[11, i] = vx, vy, 0.0, 0.0, 0.0, rate
        x, y = x + reach[i] * ex, y + reach[i] * ey
        vx, vy = vx - reach[i] * rate * ey, vy + reach[i] * rate * ex


def poses_in_space(q: Array, v: Array, start: float, reach: Array, g: Array) -> None:
    """Compute the poses (POSES, N) of the links of an arm in space, as :func:`poses_in_plane`."""
    work = np.empty((14, q.shape[0]))
    place_links(q, v, work)
    x, y, z, vx, vy, vz = 0.0, 0.0, start, 0.0, 0.0, 0.0
    for i in range(reach.shape[0]):
        j = 3 * i
        ex, ey, ez = work[11, j], work[11, j + 1], work[11, j + 2]
        ox, oy, oz = work[12, j], work[12, j + 1], work[12, j + 2]
        g[0, i], g[1, i], g[2, i], g[3, i], g[4, i], g[5, i] = x, y, z, ex, ey, ez
        g[6, i], g[7, i], g[8, i], g[9, i], g[10, i], g[11, i] = vx, vy, vz, ox, oy, oz
        x, y, z = x + reach[i] * ex, y + reach[i] * ey, z + reach[i] * ez
        vx += reach[i] * (oy * ez - oz * ey)
        vy += reach[i] * (oz * ex - ox * ez)
        vz += reach[i] * (ox * ey - oy * ex)


#: The loops that the time integration calls by their addresses, with pointers to whole arrays; z are reals in a plane, complex
#: numbers in space.
_LOOPS = """
def press_{name}(q, v, z, reach, world, out, B, b, N, O, points, d):
    g = np.empty((POSES, N))
    lengths, bodies = carray(reach, (N,)), carray(world, (O, ENTRIES))
    poses(carray(q, ({per} * N,)), carray(v, ({per} * N,)), bodies[0, START], lengths, g)
    states = carray(z, (points, COMPONENTS, B, N, {parts}))
    press(g, states[:, :, b, :, 0], lengths, bodies, points, d, carray(out, (ADDED, N)))

def slide_{name}(z, start, end, reach, world, out, B, b, N, O, points):
    before, after, still = np.empty((POSES, N)), np.empty((POSES, N)), np.zeros({per} * N)
    lengths, bodies = carray(reach, (N,)), carray(world, (O, ENTRIES))
    poses(carray(start, ({per} * N,)), still, bodies[0, START], lengths, before)
    poses(carray(end, ({per} * N,)), still, bodies[0, START], lengths, after)
    shape = (points, COMPONENTS, B, N, {parts})
    slide(before, after, carray(z, shape)[:, :, b, :, 0], lengths, bodies, points, carray(out, shape)[:, :, b, :, 0])
"""


@cache
def compiled(space: bool) -> tuple[Any, Any]:
    """Return the machine code of :func:`press` and :func:`slide` for arms in a plane or in space, compiled at the first call."""
    from numba import carray, cfunc, njit
    from numba import types as nb

    name = "in_space" if space else "in_plane"
    scope = {
        **{"np": np, "carray": carray, "POSES": POSES, "ADDED": ADDED, "COMPONENTS": COMPONENTS, "ENTRIES": ENTRIES},
        "START": START,
        "__name__": __name__,
        "poses": njit(with_helpers(poses_in_space if space else poses_in_plane)),
        "press": njit(with_helpers(press), fastmath={"contract"}),
        "slide": njit(with_helpers(slide)),
    }
    exec(_LOOPS.format(name=name, per=3 if space else 1, parts=2 if space else 1), scope)
    pointer, whole, real = nb.CPointer(nb.float64), nb.int64, nb.float64
    found = []
    for loop, signature in (
        (f"press_{name}", nb.void(*[pointer] * 6, *[whole] * 5, real)),
        (f"slide_{name}", nb.void(*[pointer] * 6, *[whole] * 5)),
    ):
        scope[loop].__qualname__ = f"{loop}_{source_hash('contact')}"
        found.append(cached(partial(cfunc, signature), scope[loop], error_model="numpy")[0])
    return found[0], found[1]
