"""Scaling of the size of a law from one stiffness level of the arm to another."""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import EffectError

from ..law import Joints

#: Scalings of a size: constant, in proportion to the declared stiffness, or in proportion to the declared damping.
SCALES = ("stays", "stiffness", "damping")
#: Stiffness [Nm/rad] and damping [Nm s/rad] of the lower level, at which sizes are given.
KEQ, DAMPING = 1.11, 0.05


def check_scale(scale: str) -> None:
    """Raise an error if a scale is none of `SCALES`."""
    if scale not in SCALES:
        raise EffectError("scale", expected=" or ".join(SCALES), received=scale)


def moment_scale(scale: str, joints: Joints) -> float:
    """Return the stiffness by which a size relative to Keq is multiplied [Nm/rad]."""
    return KEQ * {"stays": 1.0, "stiffness": joints.keq / KEQ, "damping": joints.damping / DAMPING}[scale]


def drawn_scale(rng: np.random.Generator, *scales: str) -> str:
    """Return one of the given scales at random, or one of all."""
    return str(rng.choice(scales or SCALES))
