"""What the size of a law goes with, from one stiffness level of the arm to another."""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import EffectError

from ..law import Joints

#: Sizes that stay, that grow with the declared stiffness, that grow with the declared damping.
SCALES = ("stays", "stiffness", "damping")
#: Stiffness [Nm/rad] and damping [Nm s/rad] of the level at which sizes are told: the lower one.
KEQ, DAMPING = 1.11, 0.05


def check_scale(scale: str) -> None:
    """Refuse what is none of `SCALES`."""
    if scale not in SCALES:
        raise EffectError("scale", expected=" or ".join(SCALES), received=scale)


def unit(scale: str, joints: Joints) -> float:
    """The stiffness that a size over Keq is multiplied by [Nm/rad]."""
    return KEQ * {"stays": 1.0, "stiffness": joints.keq / KEQ, "damping": joints.damping / DAMPING}[scale]


def drawn(rng: np.random.Generator, *scales: str) -> str:
    """One of these, or of all."""
    return str(rng.choice(scales or SCALES))
