"""Where the markers of arms in a plane are, for as many poses as a fit asks for.

:meth:`hsr_pin.robot.kinematics.MarkerMap.positions` says what is meant; it takes cosine and sine of every link's angle from the
base. Here the angle between two links becomes a rotation, by series as far as links bend in practice, and the rotations are
multiplied along the arm: a fifth of the time.
"""

from __future__ import annotations

import math

import numpy as np

from hsr_pin.trajectory import Array

#: Cosine and sine by powers of the square of the angle, exact to a rounding up to half a radian (0.5^15 / 15! = 2e-17).
COSINE = tuple((-1) ** k / math.factorial(2 * k) for k in range(8))
SINE = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(7))
NEAR = 0.25


def see(q: Array, fixed: Array, spans: Array, direction: Array, normal: Array, out: Array) -> None:
    """Write marker positions of arms side by side.

    Args:
        q: (T, B, N) [rad] joint angles.
        fixed: (C, M) [m] of the marker map, as the three that follow; C is 1 where all arms have one map, else B.
        spans: (C, N, M) [m].
        direction: (C, 3).
        normal: (C, 3).
        out: (T, B, M, 3) [m], in the world frame.
    """
    samples, arms, links = q.shape
    markers, own = fixed.shape[1], len(fixed) > 1
    cosine, sine, along, across = np.empty(links), np.empty(links), np.empty(markers), np.empty(markers)
    for t in range(samples):
        for b in range(arms):
            near, c = True, b if own else 0
            for i in range(links):
                square = q[t, b, i] * q[t, b, i]
                near &= square <= NEAR
                cosine[i], sine[i] = 0.0, 0.0
                for k in range(len(COSINE) - 1, -1, -1):
                    cosine[i] = cosine[i] * square + COSINE[k]
                for k in range(len(SINE) - 1, -1, -1):
                    sine[i] = sine[i] * square + SINE[k]
                sine[i] *= q[t, b, i]
            if not near:
                for i in range(links):
                    cosine[i], sine[i] = math.cos(q[t, b, i]), math.sin(q[t, b, i])
            for m in range(markers):
                along[m], across[m] = fixed[c, m], 0.0
            x, y = 1.0, 0.0  # of the direction of the link
            for i in range(links):
                x, y = x * cosine[i] - y * sine[i], y * cosine[i] + x * sine[i]
                for m in range(markers):
                    along[m] += x * spans[c, i, m]
                    across[m] += y * spans[c, i, m]
            for m in range(markers):
                for axis in range(3):
                    out[t, b, m, axis] = along[m] * direction[c, axis] + across[m] * normal[c, axis]
