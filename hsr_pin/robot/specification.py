"""The arm as a set of numbers: Table I of the paper, and what the paper leaves open."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from hsr_pin.errors import SpecificationError
from hsr_pin.trajectory import Array, Dataset, Trial

Placement = Literal["base", "mid"]
Mount = Literal["hanging", "upright", "horizontal"]

#: Largest number of links accepted; beyond it nothing is gained and rounding starts to show.
MAX_LINKS = 1000


@dataclass(frozen=True)
class ArmSpecification:
    """One hybrid soft robot, approximated by ``links`` rigid links. Defaults: Table I of the paper, its N = 4 and Keq = 1.11.

    Attributes:
        links: number N of joints (and of uniform links).
        keq: bending stiffness Keq of the whole arm [Nm/rad].
        damping: damping C of the whole arm [Nm s/rad].
        placement: "base": a joint at the base end of each link (the paper's Fig. 2); "mid": a joint in the middle of each of
            the N elements, half links at both ends.
        mount: where the straight arm points: "hanging" (down), "upright" (up), "horizontal" (along +x).
        length: arc length L of the backbone [m].
        mass: m of the arm [kg], spread evenly.
        diameter: outer diameter [m].
        tip_mass: point mass at the tip [kg].
        tilt: turn of the base from its mount, in the plane, towards positive bending [rad].
        bending_limit: largest bending angle of the whole arm, either way [rad].
    """

    links: int = 4
    keq: float = 1.11
    damping: float = 0.05
    placement: Placement = "base"
    mount: Mount = "hanging"
    length: float = 0.24
    mass: float = 0.15
    diameter: float = 0.04
    tip_mass: float = 0.0
    tilt: float = 0.0
    bending_limit: float = math.pi

    def __post_init__(self) -> None:
        if isinstance(self.links, bool) or not isinstance(self.links, (int, np.integer)) or not 1 <= self.links <= MAX_LINKS:
            raise SpecificationError("links", expected=f"a whole number from 1 to {MAX_LINKS}", received=repr(self.links))
        for name, unit, zero in (
            ("keq", "Nm/rad", False),
            ("damping", "Nm s/rad", True),
            ("length", "m", False),
            ("mass", "kg", False),
            ("diameter", "m", False),
            ("tip_mass", "kg", True),
            ("bending_limit", "rad", False),
        ):
            _check_number(name, getattr(self, name), unit, zero_allowed=zero)
        if not _is_number(self.tilt) or abs(self.tilt) > math.pi:
            raise SpecificationError("tilt", expected="an angle from -pi to pi rad", received=repr(self.tilt))
        for name, choices in (("placement", get_args(Placement)), ("mount", get_args(Mount))):
            if getattr(self, name) not in choices:
                raise SpecificationError(name, expected=" or ".join(choices), received=repr(getattr(self, name)))

    @classmethod
    def from_trial(cls, dataset: Dataset, trial: Trial, **changes: Any) -> ArmSpecification:
        """The arm as a recording declares it (the paper's placement, 4 links, unless ``changes`` say otherwise)."""
        declared = cls(
            keq=trial.keq,
            damping=default_damping(trial.keq) if trial.damping is None else trial.damping,
            mount=dataset.mount,  # type: ignore[arg-type]  # checked in __post_init__
            length=dataset.length,
            mass=dataset.mass,
            diameter=dataset.diameter,
            tip_mass=trial.tip_mass,
        )
        return replace(declared, **changes)

    @property
    def link_length(self) -> float:
        """L / N [m]."""
        return self.length / self.links

    @property
    def joint_stiffness(self) -> float:
        """k_i = N Keq [Nm/rad]: N equal springs in series make Keq."""
        return self.links * self.keq

    @property
    def joint_damping(self) -> float:
        """c_i = N C [Nm s/rad]."""
        return self.links * self.damping

    @property
    def joint_arc_lengths(self) -> Array:
        """(N,) arc length of each joint over L, from 0 (base) to 1 (tip)."""
        first = 0.5 if self.placement == "mid" else 0.0
        return (np.arange(self.links) + first) / self.links

    @property
    def element_arc_lengths(self) -> Array:
        """(N,) centre of the stretch of arm that each joint stands for, over L (the same for both placements)."""
        return (np.arange(self.links) + 0.5) / self.links


def default_damping(keq: float) -> float:
    """C [Nm s/rad] for a stiffness the paper does not tabulate: the line through its two values (0.05 at 1.11, 0.1 at 2.33)."""
    return 0.05 + (keq - 1.11) * (0.1 - 0.05) / (2.33 - 1.11)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, bool) and math.isfinite(value)


def _check_number(name: str, value: Any, unit: str, *, zero_allowed: bool) -> None:
    if not _is_number(value) or value < 0 or (value == 0 and not zero_allowed):
        bound = "zero or more" if zero_allowed else "more than zero"
        raise SpecificationError(name, expected=f"a number, {bound} [{unit}]", received=repr(value))
