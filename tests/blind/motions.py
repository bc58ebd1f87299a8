"""Comparison of motions of planar plants."""

import numpy as np


def tip_rms(a, b) -> float:
    """Return the RMS distance of the tips [mm]."""
    return 1e3 * float(np.sqrt(np.mean((a.x[:, -1] - b.x[:, -1]) ** 2 + (a.z[:, -1] - b.z[:, -1]) ** 2)))
