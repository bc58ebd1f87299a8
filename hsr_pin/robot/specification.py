"""The specification of an arm: Table I of the paper, and further properties that the paper does not define."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from hsr_pin.errors import SpecificationError, quoted
from hsr_pin.obstacles import Obstacle
from hsr_pin.robot.sections import whole
from hsr_pin.trajectory import Array, Dataset, Section, Trial

Placement = Literal["base", "mid", "shifted"]
Mount = Literal["hanging", "upright", "horizontal", "flat"]
Bends = Literal["plane", "space"]

#: Largest accepted number of links; more links do not improve the accuracy, and rounding errors become visible.
MAX_LINKS = 1000

#: Displacement of the first and the last joint, in elements, for the placement "shifted". Joints in the middle of elements are
#: the midpoint rule for the arm's curvature. Its leading error is h^2/24 times the slopes at the ends (Euler and Maclaurin); this
#: displacement cancels it, so that shapes and frequencies converge as N^-3 instead of N^-2.
SHIFT = 1 / 24

#: Quantity -> its unit, and the smallest and the largest accepted value.
RANGES: dict[str, tuple[str, float, float]] = {
    "keq": ("Nm/rad", 1e-9, 1e9),
    "damping": ("Nm s/rad", 0.0, 1e9),
    "length": ("m", 1e-4, 1e3),
    "mass": ("kg", 1e-12, 1e6),
    "diameter": ("m", 1e-6, 1e3),
    "tip_mass": ("kg", 0.0, 1e6),
    "bending_limit": ("rad", 1e-9, 1e6),
}
#: Quantities that may be zero.
_MAY_BE_ZERO = ("damping", "tip_mass")


@dataclass(frozen=True)
class ArmSpecification:
    """One hybrid soft robot, approximated by ``links`` rigid links; the defaults are Table I of the paper, N = 4 and Keq = 1.11.

    Attributes:
        links: number N of joints (and of uniform links).
        keq: bending stiffness Keq of the whole arm [Nm/rad].
        damping: damping C of the whole arm [Nm s/rad].
        placement: "base": a joint at the base end of each link (the paper's Fig. 2); "mid": a joint in the middle of each of the
            N elements, with half links at both ends; "shifted": as "mid", with the first and the last joint closer to the ends by
            :data:`SHIFT` of an element.
        mount: direction of the straight arm: "hanging" (down), "upright" (up), "horizontal" (along +x), "flat" (along +x, and the
            plane of bending, x-z, is horizontal, so that gravity does not act in it).
        length: arc length L of the backbone [m].
        mass: mass m of the arm [kg], distributed uniformly.
        diameter: outer diameter [m].
        tip_mass: point mass at the tip [kg].
        tilt: rotation of the base from its mount, in the plane, towards positive bending [rad].
        bending_limit: largest bending angle of the whole arm, in both directions [rad].
        bending: "plane": every joint is a hinge; "space": every joint bends about two axes and twists.
        torsion: torsional stiffness of the whole arm [Nm/rad]; infinite: it does not twist; 0: it twists freely. For arms in
            space only. Its damping is C torsion / Keq, which gives the time constant of bending.
        cross_tilt: rotation of the base towards its side, for arms in space only [rad]; together with ``tilt`` a rotation vector.
        sections: sections of an arm in space, from the base to the tip; empty for a uniform arm. They define the distribution of
            the numbers along the arm: the arm's own numbers are those of all sections in series (see :meth:`in_sections`), and
            changing one of them changes all sections in proportion.
        obstacles: rigid bodies that the arm may touch.
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
    obstacles: tuple[Obstacle, ...] = ()

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
        object.__setattr__(self, "obstacles", tuple(self.obstacles))
        if self.mount == "flat" and self.bending == "space":
            hint = 'an arm in space that lies has mount="horizontal"'
            raise SpecificationError("mount", expected="not flat for an arm in space", received=self.mount, hint=hint)
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
        """Return the arm as declared by a recording (the paper's placement and 4 links, unless ``changes`` differ)."""
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
            obstacles=dataset.obstacles,
        )
        return replace(declared, **changes)

    @classmethod
    def in_sections(cls, sections: Sequence[Section], **more: Any) -> ArmSpecification:
        """Return the arm in space that consists of these sections, base first; ``more`` are its other numbers."""
        return cls(**{"bending": "space", **whole(sections), "sections": tuple(sections), **more})

    @property
    def coordinates(self) -> int:
        """Number of coordinates of all joints: N in the plane; in space 3 N (towards x, towards y, twist)."""
        return self.links if self.bending == "plane" else 3 * self.links

    @property
    def link_length(self) -> float:
        """Length L / N of a link [m]."""
        return self.length / self.links

    @property
    def joint_stiffness(self) -> float:
        """Stiffness k_i = N Keq of a joint [Nm/rad]: N equal springs in series give Keq."""
        return self.links * self.keq

    @property
    def joint_damping(self) -> float:
        """Damping c_i = N C of a joint [Nm s/rad]."""
        return self.links * self.damping

    @property
    def joint_arc_lengths(self) -> Array:
        """Relative arc lengths (N,) of the joints, from 0 (base) to 1 (tip)."""
        return joint_arc_lengths(self.links, self.placement)

    @property
    def element_arc_lengths(self) -> Array:
        """Relative arc lengths (N,) of the middles of the elements that the joints represent (the same for all placements)."""
        return (np.arange(self.links) + 0.5) / self.links


def joint_arc_lengths(links: int, placement: str) -> Array:
    """Return the relative arc lengths (N,) of the joints, from 0 (base) to 1 (tip)."""
    places = np.arange(links) + (0.0 if placement == "base" else 0.5)
    if placement == "shifted" and links > 1:
        places[[0, -1]] += -SHIFT, SHIFT
    return np.asarray(places / links)


def link_shares(links: int, placement: str) -> Array:
    """Return the lengths (N + 1,) of the fixed part and of the moving links, relative to an element."""
    shares = np.ones(links + 1)
    shares[0] = 0.0
    if placement != "base":
        shares[[0, -1]] = 0.5
    if placement == "shifted" and links > 1:
        for link, change in ((0, -SHIFT), (1, SHIFT), (-2, SHIFT), (-1, -SHIFT)):
            shares[link] += change
    return shares


def mount_frame(mount: str) -> tuple[Array, Array]:
    """Return the directions (3,) of a straight arm on this mount and of positive bending, unit vectors in the world frame."""
    down, forward = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    lying = (forward, down)
    return {"hanging": (down, forward), "upright": (-down, forward), "horizontal": lying, "flat": lying}[mount]


def gravity_direction(mount: str) -> Array:
    """Return the direction (3,) of gravity, a unit vector: along -z, or across the plane of bending of a flat arm."""
    return np.array([0.0, -1.0, 0.0] if mount == "flat" else [0.0, 0.0, -1.0])


def in_plane(arm: ArmSpecification, what: str) -> ArmSpecification:
    """Return a planar arm unchanged, and raise an error for an arm in space.

    Args:
        arm: the arm.
        what: the operation that requires a planar arm, for the message.

    Raises:
        SpecificationError: the arm bends in space.
    """
    if arm.bending == "space":
        raise SpecificationError("bending", expected=f"plane for {what}", received="space")
    return arm


def default_damping(keq: float) -> float:
    """Return the default damping C [Nm s/rad] of an arm with a given stiffness [Nm/rad].

    It is on the line through the two values of the paper, 0.05 at 1.11 and 0.1 at 2.33.
    """
    return 0.05 + (keq - 1.11) * (0.1 - 0.05) / (2.33 - 1.11)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that is too large for a float
        return False


def _check_number(name: str, value: Any) -> None:
    unit, low, high = RANGES[name]
    zero = name in _MAY_BE_ZERO
    if not _is_number(value) or value < 0 or (value == 0 and not zero):
        bound = "zero or more" if zero else "more than zero"
        raise SpecificationError(name, expected=f"a number, {bound} [{unit}]", received=quoted(value))
    if value != 0 and not low <= value <= high:
        raise SpecificationError(name, expected=f"a number from {low:g} to {high:g} [{unit}]", received=quoted(value))
