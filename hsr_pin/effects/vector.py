"""Bending as a vector: of one component in the plane (a real number), of two in space (a complex number)."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Lengths below this count as none.
_NOTHING = 1e-300


def limited(vector: Any, longest: Any) -> Any:
    """The vector itself, or shortened to the length ``longest``."""
    return vector * np.minimum(1.0, longest / np.maximum(np.abs(vector), _NOTHING))


def unit(vector: Any) -> Any:
    """The vector over its length; zero stays zero."""
    return vector / np.maximum(np.abs(vector), _NOTHING)


def chosen(condition: Any, one: Any, other: Any) -> Any:
    """One where a condition holds, the other elsewhere; for a single number a branch in machine code, without an array."""
    return np.where(condition, one, other)
