"""The arm as a set of numbers: Table I of the paper, and what the paper leaves open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from hsr_pin.errors import SpecificationError, quoted
from hsr_pin.robot.sections import whole
from hsr_pin.trajectory import Array, Dataset, Section, Trial

Placement = Literal["base", "mid", "shifted"]
Mount = Literal["hanging", "upright", "horizontal"]
Bends = Literal["plane", "space"]

#: Largest number of links accepted; beyond it nothing is gained and rounding starts to show.
MAX_LINKS = 1000

#: Joints in the middle of elements are the midpoint rule for the arm's curvature. Its error is one of the ends, h^2/24 times the
#: slopes there (Euler and Maclaurin), and a joint that is moved by this share of an element takes it away: shapes and
#: frequencies converge as N^-3 in place of N^-2.
SHIFT = 1 / 24

#: Quantity -> its unit, and the smallest and the largest value of it that is taken for an arm's.
RANGES: dict[str, tuple[str, float, float]] = {
    "keq": ("Nm/rad", 1e-9, 1e9),
    "damping": ("Nm s/rad", 0.0, 1e9),
    "length": ("m", 1e-4, 1e3),
    "mass": ("kg", 1e-12, 1e6),
    "diameter": ("m", 1e-6, 1e3),
    "tip_mass": ("kg", 0.0, 1e6),
    "bending_limit": ("rad", 1e-9, 1e6),
}
#: What an arm may be without.
_MAY_BE_ZERO = ("damping", "tip_mass")


@dataclass(frozen=True)
class ArmSpecification:
    """One hybrid soft robot, approximated by ``links`` rigid links. Defaults: Table I of the paper, its N = 4 and Keq = 1.11.

    Attributes:
        links: number N of joints (and of uniform links).
        keq: bending stiffness Keq of the whole arm [Nm/rad].
        damping: damping C of the whole arm [Nm s/rad].
        placement: "base": a joint at the base end of each link (the paper's Fig. 2); "mid": a joint in the middle of each of
            the N elements, half links at both ends; "shifted": as "mid", with the first and the last joint nearer to the ends by
            :data:`SHIFT` of an element.
        mount: where the straight arm points: "hanging" (down), "upright" (up), "horizontal" (along +x).
        length: arc length L of the backbone [m].
        mass: m of the arm [kg], spread evenly.
        diameter: outer diameter [m].
        tip_mass: point mass at the tip [kg].
        tilt: turn of the base from its mount, in the plane, towards positive bending [rad].
        bending_limit: largest bending angle of the whole arm, either way [rad].
        bending: "plane": every joint is a hinge; "space": every joint bends about two axes and twists.
        torsion: stiffness against twisting of the whole arm [Nm/rad]; infinite: it does not twist; 0: it does so freely. In space
            alone. Its damping is C torsion / Keq: the time constant of bending.
        cross_tilt: turn of the base towards the side to which the arm bends in space only [rad]; with ``tilt`` a rotation vector.
        sections: that the arm is made of, in space, from the base on; none: a uniform one. They say how its numbers are spread:
            the arm's own are those of all together (see :meth:`in_sections`), and to change one changes all sections alike.
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
    bending: Bends = "plane"
    torsion: float = math.inf
    cross_tilt: float = 0.0
    sections: tuple[Section, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.links, bool) or not isinstance(self.links, (int, np.integer)) or not 1 <= self.links <= MAX_LINKS:
            raise SpecificationError("links", expected=f"a whole number from 1 to {MAX_LINKS}", received=quoted(self.links))
        for name in RANGES:
            _check_number(name, getattr(self, name))
        for name in ("tilt", "cross_tilt"):
            angle = getattr(self, name)
            if not _is_number(angle) or abs(angle) > math.pi:
                raise SpecificationError(name, expected="an angle from -pi to pi rad", received=quoted(angle))
        for name, choices in (("placement", get_args(Placement)), ("mount", get_args(Mount)), ("bending", get_args(Bends))):
            word = getattr(self, name)
            if not isinstance(word, str) or word not in choices:
                raise SpecificationError(name, expected=" or ".join(choices), received=quoted(word))
        self._check_torsion()
        if self.sections and self.bending == "plane":
            hint = 'an arm in space has bending="space"'
            raise SpecificationError(
                "sections", expected="none where the arm bends in a plane", received=len(self.sections), hint=hint
            )

    def _check_torsion(self) -> None:
        stiff = isinstance(self.torsion, float) and self.torsion == math.inf
        if not stiff and not (_is_number(self.torsion) and 0 <= self.torsion <= RANGES["keq"][2]):
            expected = f"a number, zero or more [Nm/rad], up to {RANGES['keq'][2]:g}, or infinity"
            raise SpecificationError("torsion", expected=expected, received=quoted(self.torsion))
        if self.bending == "plane" and not (stiff and self.cross_tilt == 0):
            name = "cross_tilt" if stiff else "torsion"
            hint = 'an arm in space has bending="space"'
            raise SpecificationError(
                name, expected="none where the arm bends in a plane", received=quoted(getattr(self, name)), hint=hint
            )

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
            bending=dataset.bending,  # type: ignore[arg-type]
            torsion=dataset.torsion,
            sections=dataset.sections,
        )
        return replace(declared, **changes)

    @classmethod
    def in_sections(cls, sections: Sequence[Section], **more: Any) -> ArmSpecification:
        """The arm in space that sections make, base first; ``more`` are its other numbers."""
        return cls(**{"bending": "space", **whole(sections), "sections": tuple(sections), **more})

    @property
    def coordinates(self) -> int:
        """Of all joints: N in the plane; in space 3 N, for each joint (towards x, towards y, twist)."""
        return self.links if self.bending == "plane" else 3 * self.links

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
        return joint_arc_lengths(self.links, self.placement)

    @property
    def element_arc_lengths(self) -> Array:
        """(N,) centre of the stretch of arm that each joint stands for, over L (the same for both placements)."""
        return (np.arange(self.links) + 0.5) / self.links


def joint_arc_lengths(links: int, placement: str) -> Array:
    """(N,) arc length of each joint over L, from 0 (base) to 1 (tip)."""
    places = np.arange(links) + (0.0 if placement == "base" else 0.5)
    if placement == "shifted" and links > 1:
        places[[0, -1]] += -SHIFT, SHIFT
    return np.asarray(places / links)


def link_shares(links: int, placement: str) -> Array:
    """(N + 1,) length of the part that no joint moves, and of the links that move, over an element's."""
    shares = np.ones(links + 1)
    shares[0] = 0.0
    if placement != "base":
        shares[[0, -1]] = 0.5
    if placement == "shifted" and links > 1:
        for link, change in ((0, -SHIFT), (1, SHIFT), (-2, SHIFT), (-1, -SHIFT)):
            shares[link] += change
    return shares


def mount_frame(mount: str) -> tuple[Array, Array]:
    """(3,) each: unit vectors along a straight arm on this mount, and across it towards positive bending, in the world frame."""
    down, forward = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    return {"hanging": (down, forward), "upright": (-down, forward), "horizontal": (forward, down)}[mount]


def in_plane(arm: ArmSpecification, what: str) -> ArmSpecification:
    """The arm itself, for what knows nothing of space.

    Args:
        arm: any.
        what: that is done with it, for the message.

    Raises:
        SpecificationError: it bends in space.
    """
    if arm.bending == "space":
        raise SpecificationError("bending", expected=f"plane for {what}", received="space")
    return arm


def default_damping(keq: float) -> float:
    """C [Nm s/rad] for a stiffness the paper does not tabulate: the line through its two values (0.05 at 1.11, 0.1 at 2.33)."""
    return 0.05 + (keq - 1.11) * (0.1 - 0.05) / (2.33 - 1.11)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that no float holds
        return False


def _check_number(name: str, value: Any) -> None:
    unit, low, high = RANGES[name]
    zero = name in _MAY_BE_ZERO
    if not _is_number(value) or value < 0 or (value == 0 and not zero):
        bound = "zero or more" if zero else "more than zero"
        raise SpecificationError(name, expected=f"a number, {bound} [{unit}]", received=quoted(value))
    if value != 0 and not low <= value <= high:
        raise SpecificationError(name, expected=f"a number from {low:g} to {high:g} [{unit}]", received=quoted(value))
