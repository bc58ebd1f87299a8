"""Friction that opposes the motion of a joint, regularised for integration."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array

#: Speed above which a joint slides [rad/s]; below it the regularised joint creeps instead of sticking.
SLIDING_SPEED = 0.02


def sliding_friction(level: Array, v: Array) -> tuple[Array, Array]:
    """Return the friction torque for a level [N m] at a speed [rad/s], and its decrease per speed [N m s/rad], each (B, n)."""
    share = np.tanh(v / SLIDING_SPEED)  # of the level
    return -level * share, level / SLIDING_SPEED * (1 - share**2)
