"""Bending as a vector: a real number in the plane, a complex number for the two components in space."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Length below which a vector is treated as zero.
_NOTHING = 1e-300


def limited(vector: Any, longest: Any) -> Any:
    """Return a vector shortened to at most the length ``longest``."""
    return vector * np.minimum(1.0, longest / np.maximum(np.abs(vector), _NOTHING))


def unit(vector: Any) -> Any:
    """Return the unit vector of a vector; zero stays zero."""
    return vector / np.maximum(np.abs(vector), _NOTHING)


def chosen(condition: Any, one: Any, other: Any) -> Any:
    """Return ``one`` where a condition holds and ``other`` elsewhere; compiled code uses a branch for single numbers."""
    return np.where(condition, one, other)
