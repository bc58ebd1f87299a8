"""The kinematics of one joint in space, with plain numbers and tuples of three for Python and the compiler.

With the rotation vector w, x = |w|, t = x^2 and [w] the matrix of w x, the rotation is cos x + A [w] + B w w'. Its left Jacobian,
which maps the rate of w to the angular velocity, is A + B [w] + C w w', where A = sin x / x, B = (1 - cos x) / t, C = (1 - A) / t
(T. D. Barfoot, State Estimation for Robotics, Cambridge 2017, sec. 7.1).
"""

from __future__ import annotations

from math import cos, factorial, sin, sqrt

import numpy as np

Vector = tuple[float, float, float]

#: Below this squared angle [rad^2] the functions are power series with this number of terms, exact to rounding; above it they are
#: in closed form.
_NEAR, _TERMS = 4.0, 12
#: Below this squared angle, this smaller number of terms is sufficient.
_TINY, _FEW = 0.06, 6
#: (4, _TERMS) of B, C, dB/dt * 2 and dC/dt * 2, in powers of t.
_SERIES = np.array(
    [
        [(-1) ** k / factorial(2 * k + 2) for k in range(_TERMS)],
        [(-1) ** k / factorial(2 * k + 3) for k in range(_TERMS)],
        [(-1) ** (k + 1) * 2 * (k + 1) / factorial(2 * k + 4) for k in range(_TERMS)],
        [(-1) ** (k + 1) * 2 * (k + 1) / factorial(2 * k + 5) for k in range(_TERMS)],
    ]
)


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def plus(a: Vector, weight: float, b: Vector) -> Vector:
    """Return a + weight * b."""
    return a[0] + weight * b[0], a[1] + weight * b[1], a[2] + weight * b[2]


def factors(t: float) -> tuple[float, float, float, float]:
    """Return B, C and twice their derivatives with respect to t, for the square t of an angle."""
    if t < _NEAR:
        b, c, db, dc = 0.0, 0.0, 0.0, 0.0
        terms = _TERMS if t > _TINY else _FEW
        for n in range(terms):
            k = terms - 1 - n
            b, c = b * t + _SERIES[0, k], c * t + _SERIES[1, k]
            db, dc = db * t + _SERIES[2, k], dc * t + _SERIES[3, k]
        return b, c, db, dc
    x = sqrt(t)
    a, b = sin(x) / x, (1.0 - cos(x)) / t
    c = (1.0 - a) / t
    return b, c, (a - 2.0 * b) / t, (b - 3.0 * c) / t


def turned(w: Vector, same: float, across: float, along: float, v: Vector) -> Vector:
    """Return (same + across [w] + along w w') v."""
    return plus(plus((same * v[0], same * v[1], same * v[2]), across, cross(w, v)), along * dot(w, v), w)


def drift(w: Vector, rate: Vector, db: float, c: float, dc: float) -> Vector:
    """Return the angular acceleration of a joint whose rotation vector w changes at a constant rate.

    It is expressed in the frame that the joint is attached to.
    """
    once, grows = cross(w, rate), dot(w, rate)
    out = plus((0.0, 0.0, 0.0), db * grows, once)
    return plus(plus(out, dc * grows, cross(w, once)), c, cross(rate, once))


def combined(x: Vector, y: Vector, z: Vector, v: Vector) -> Vector:
    """Return the vector with components v along the axes x, y, z."""
    return plus(plus((v[0] * x[0], v[0] * x[1], v[0] * x[2]), v[1], y), v[2], z)
