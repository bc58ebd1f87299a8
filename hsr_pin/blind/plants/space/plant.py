"""Base class of the plants in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ..arm import Array
from ..laws.law import Law
from ..plant import Plant
from ..writing import Marker
from .arm import SpaceArm, SpaceMotion, moving
from .writing import observe


@dataclass(frozen=True)
class SpacePlant(Plant):
    """An arm that bends about two axes, with markers that may be at a distance from the backbone."""

    bare: SpaceArm = field(default_factory=SpaceArm)

    def motion(self, t: Array, s: Array, nodes: Sequence[Any]) -> SpaceMotion:
        return moving(t, s, nodes)

    def observed(self, motion: Any, arm: Any, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
        return observe(motion, arm, laws, markers, error)
