"""The projection of joint angles to marker positions of planar arms, for the large number of poses that a fit needs.

:meth:`hsr_pin.robot.kinematics.MarkerMap.positions` defines the result; it computes cosine and sine of the angle of every link.
Here, series give the rotation between neighbouring links, up to the angles that occur in practice, and the rotations are
multiplied along the arm. This takes a fifth of the time.
"""

from __future__ import annotations

import math

import numpy as np

from hsr_pin.trajectory import Array

#: Coefficients of cosine and sine in powers of the squared angle, exact to rounding up to 0.5 rad (0.5^15 / 15! = 2e-17).
COSINE = tuple((-1) ** k / math.factorial(2 * k) for k in range(8))
SINE = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(7))
NEAR = 0.25


def project_markers(q: Array, fixed: Array, spans: Array, direction: Array, normal: Array, out: Array) -> None:
    """Compute the marker positions of several arms for many poses.

    Args:
        q: (T, B, N) joint angles [rad].
        fixed: (C, M) part of the marker map along the base [m]; C is 1 if all arms share one map, otherwise B.
        spans: (C, N, M) part of the marker map along each link [m].
        direction: (C, 3) direction of the straight arm.
        normal: (C, 3) direction of positive bending.
        out: (T, B, M, 3) positions in the world frame [m]; overwritten.
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
