"""Rotation vectors of many joints at once, and the bending of an arm in space as two or three numbers of each joint.

A joint's coordinates are (towards x, towards y, twist) of the frame that it hangs on, whose z runs along the straight arm: the
rotation vector (-y, x, twist). Exponential map and its left Jacobian: T. D. Barfoot, State Estimation for Robotics, Cambridge
2017, sec. 7.1.
"""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array


def vectors(coordinates: Array) -> Array:
    """(..., 3) rotation vectors [rad] of coordinates (..., 3) [rad]."""
    return np.stack([-coordinates[..., 1], coordinates[..., 0], coordinates[..., 2]], axis=-1)


def rotations(w: Array) -> Array:
    """(..., 3, 3) matrices of rotation vectors (..., 3) [rad]."""
    a, b, _ = _factors(w)
    return np.asarray(a * _skew(w) + b * w[..., :, None] * w[..., None, :] + (1 - b * _square(w)) * np.eye(3))


def left_jacobians(w: Array) -> Array:
    """(..., 3, 3) J with angular velocity J w' in the frame that the joint hangs on, for rotation vectors w (..., 3)."""
    a, b, c = _factors(w)
    return np.asarray(b * _skew(w) + c * w[..., :, None] * w[..., None, :] + a * np.eye(3))


def _factors(w: Array) -> tuple[Array, Array, Array]:
    """Sin x / x, (1 - cos x) / x^2 and (x - sin x) / x^3 of the lengths x, (..., 1, 1) each."""
    x = np.sqrt(_square(w))
    a, half = np.sinc(x / np.pi), np.sinc(x / (2 * np.pi))
    near = x < 0.02
    c = np.where(near, 1 / 6 - x**2 / 120, (1 - a) / np.where(near, 1.0, x) ** 2)
    return a, half**2 / 2, c


def _square(w: Array) -> Array:
    return np.asarray((w**2).sum(axis=-1)[..., None, None])


def _skew(w: Array) -> Array:
    return np.cross(w[..., None, :], np.eye(3)).swapaxes(-1, -2)
