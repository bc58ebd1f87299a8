"""Friction that opposes the motion of a joint, smooth enough to be integrated."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array

#: Speed [rad/s] from which on a joint slides: below it, it creeps instead of sticking.
SLIDES = 0.02


def sliding(level: Array, v: Array) -> tuple[Array, Array]:
    """(B, n) [N m] of a level at a speed [rad/s], and the slope by which it holds a joint that does not move."""
    share = np.tanh(v / SLIDES)
    return -level * share, level / SLIDES * (1 - share**2)
