"""Scaling of the size of a law from one stiffness level of the arm to another."""

from __future__ import annotations

from typing import Any

from ..law import Joints, one_of

#: Scalings of a size: constant, in proportion to the declared stiffness, or in proportion to the declared damping.
SCALES = ("stays", "stiffness", "damping")
#: Stiffness [Nm/rad] and damping [Nm s/rad] of the lower level, at which sizes are given.
KEQ, DAMPING = 1.11, 0.05


def scaling(*among: str, default: str) -> Any:
    """Return the field of a law with one of `SCALES`, of which those of `among` (or all) may be drawn."""
    return one_of(*SCALES, among=among, default=default)


def moment_scale(scale: str, joints: Joints) -> float:
    """Return the stiffness by which a size relative to Keq is multiplied [Nm/rad]."""
    return KEQ * {"stays": 1.0, "stiffness": joints.keq / KEQ, "damping": joints.damping / DAMPING}[scale]
