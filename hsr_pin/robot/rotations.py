"""Rotation vectors of many joints at once, and the bending of joints in space as two or three coordinates.

The coordinates of a joint are (towards x, towards y, twist) in the frame that it is attached to, whose z axis is along the
straight arm: the rotation vector (-y, x, twist). Exponential map and its left Jacobian: T. D. Barfoot, State Estimation for
Robotics, Cambridge 2017, sec. 7.1.
"""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array


def vectors(coordinates: Array) -> Array:
    """Return the rotation vectors (..., 3) [rad] of coordinates (..., 3) [rad]."""
    return np.stack([-coordinates[..., 1], coordinates[..., 0], coordinates[..., 2]], axis=-1)


def rotations(w: Array) -> Array:
    """Return the rotation matrices (..., 3, 3) of rotation vectors (..., 3) [rad]."""
    a, b, _ = _factors(w)
    return _matrices(w, 1 - b * _square(w), a, b)


def left_jacobians(w: Array) -> Array:
    """Return the left Jacobians J (..., 3, 3) of rotation vectors w (..., 3) [rad].

    The angular velocity in the frame that the joint is attached to is J w'.
    """
    a, b, c = _factors(w)
    return _matrices(w, a, b, c)


def _matrices(w: Array, same: Array, across: Array, along: Array) -> Array:
    """Return the matrices (..., 3, 3) same + across [w] + along w w' for numbers (...); [w] is the matrix of w x."""
    x, y, z = w[..., 0], w[..., 1], w[..., 2]
    ax, ay, az, bx, by, bz = across * x, across * y, across * z, along * x, along * y, along * z
    out = np.empty((*w.shape, 3))
    out[..., 0, 0], out[..., 1, 1], out[..., 2, 2] = same + bx * x, same + by * y, same + bz * z
    out[..., 0, 1], out[..., 1, 0] = bx * y - az, bx * y + az
    out[..., 0, 2], out[..., 2, 0] = bx * z + ay, bx * z - ay
    out[..., 1, 2], out[..., 2, 1] = by * z - ax, by * z + ax
    return out


def _factors(w: Array) -> tuple[Array, Array, Array]:
    """Return sin x / x, (1 - cos x) / x^2 and (x - sin x) / x^3 of the lengths x, (...) each."""
    t = _square(w)
    near = t < 4e-4  # the third would be a difference of nearly equal numbers
    x = np.sqrt(np.where(near, 1.0, t))
    s, c = np.sin(x / 2), np.cos(x / 2)
    a = np.where(near, 1 - t / 6 * (1 - t / 20 * (1 - t / 42)), 2 * s * c / x)
    b = np.where(near, 0.5 - t / 24 * (1 - t / 30 * (1 - t / 56)), 2 * (s / x) ** 2)
    return a, b, np.where(near, (1 - t / 20 * (1 - t / 42)) / 6, (1 - a) / x**2)


def _square(w: Array) -> Array:
    return np.asarray(w[..., 0] ** 2 + w[..., 1] ** 2 + w[..., 2] ** 2)
