"""Links, joints and markers as every target needs them: the straight arm along +z of the base, bending towards +x about +y.

In space a joint is two hinges in one place, towards x and towards y, and a third where the arm twists. Hinges one after the other
are not a rotation vector: their order turns what follows by half the product of their angles. So from joint to joint the order is
turned round, and what one does its neighbour takes back (G. Strang, SIAM J. Numer. Anal. 5, 1968): of the error of 1/N is left
one of 1/N^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.robot.appearance import colour, shape
from hsr_pin.robot.chain import GRAVITY, Arms, chain_of
from hsr_pin.robot.rotations import rotations, vectors
from hsr_pin.robot.sections import inputs
from hsr_pin.robot.space import base_rotations
from hsr_pin.trajectory import Array

#: Bending towards x and towards y, and twist: what each hinge turns about.
_AXES = ("0 1 0", "-1 0 0", "0 0 1")
_WAYS = ("x", "y", "twist")
#: Below this cosine of the pitch only the sum of roll and yaw, or their difference, is known: beyond it they are rounding errors.
LOCKED = 1e-9


@dataclass(frozen=True)
class Hinge:
    """One axis of a joint.

    Attributes:
        name: ``joint_1``, in space ``joint_1_x``, ``joint_1_y`` and ``joint_1_twist``.
        way: 0: towards x; 1: towards y; 2: twist.
        parent, child: what it joins; between the hinges of one joint are links that hardly weigh anything.
        start: [m] of the hinge along the parent.
        spring, damper: [Nm/rad], [Nm s/rad].
        slight: the child is one of those.
    """

    name: str
    way: int
    parent: str
    child: str
    start: float
    spring: float
    damper: float
    slight: bool

    @property
    def axis(self) -> str:
        """As XML has it."""
        return _AXES[self.way]


@dataclass(frozen=True)
class Link:
    """A rigid link on its joint.

    Attributes:
        number: from 1, base to tip.
        start: [m] of the joint along the link before it (the base for the first).
        height: [m] of the joint above the base, in the straight arm.
        length, radius: [m] of the cylinder.
        mass: [kg], the payload not included.
        centre: [m] of mass from the joint.
        across, along: [kg m^2] inertia about it.
        spring, damper: [Nm/rad], [Nm s/rad] of the joint against bending.
        share: of the torque that arrives there; (S,) of each section's.
        hinges: that the joint is made of.
        colour: (r, g, b).
    """

    number: int
    start: float
    height: float
    length: float
    radius: float
    mass: float
    centre: float
    across: float
    along: float
    spring: float
    damper: float
    share: Array
    hinges: tuple[Hinge, ...]
    colour: tuple[float, float, float]

    @property
    def name(self) -> str:
        """``link_1`` hangs on ``joint_1``."""
        return f"link_{self.number}"

    @property
    def joint(self) -> str:
        """Its joint."""
        return f"joint_{self.number}"

    @property
    def parent(self) -> str:
        """What it hangs on."""
        return f"link_{self.number - 1}" if self.number > 1 else "base"


@dataclass(frozen=True)
class Site:
    """A marker: ``x``, ``y``, ``z`` [m] in the frame of the link (or base) that carries it."""

    name: str
    parent: str
    x: float
    y: float
    z: float


@dataclass(frozen=True, eq=False)
class Bodies:
    """The arm in its base frame.

    Attributes:
        links: from base to tip.
        base_length: [m] of the half link that is fixed to the base; 0 for joints at the base ends.
        payload: [kg] at the tip, at ``links[-1].length`` along the last link.
        sites: where the markers are.
        rpy: roll, pitch and yaw [rad] of the base in the world frame, in which the markers are seen.
        gravity: (3,) [m/s^2] in that frame.
        shape: how it is drawn.
    """

    links: tuple[Link, ...]
    base_length: float
    payload: float
    sites: tuple[Site, ...]
    rpy: tuple[float, float, float]
    gravity: Array
    shape: dict[str, object]

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """(w, x, y, z) of the base: Rz(yaw) Ry(pitch) Rx(roll)."""
        (a, b), (c, s), (e, f) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in self.rpy)
        return c * a * e + s * b * f, c * b * e - s * a * f, s * a * e + c * b * f, c * a * f - s * b * e

    @property
    def gravity_is_turned(self) -> bool:
        """Whether gravity does not point along -z of the frame in which the markers are seen."""
        return bool(np.abs(self.gravity[:2]).max() > 1e-12)

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        """Of all joints, from the base on, in the order in which they follow one another."""
        return tuple(hinge for link in self.links for hinge in link.hinges)


def bodies_of(model: CorrectedModel) -> Bodies:
    """The bodies of a model; they move as those of :func:`hsr_pin.robot.model.build_model`, in space nearly so."""
    arm, arrays = model.loaded_arm, model.columns.arrays
    chain = chain_of(Arms.of([replace(arm, tip_mass=0.0)]))
    heights = arm.joint_arc_lengths * arm.length
    starts = np.diff(heights, prepend=0.0)
    shares = arrays.share[0][:, None] * inputs(arm.sections, arm.links)
    links = tuple(
        Link(
            number=i + 1,
            start=float(starts[i]),
            height=float(heights[i]),
            length=float(chain.reach[0, i]),
            radius=arm.diameter / 2,
            mass=float(chain.mass[0, i]),
            centre=float(chain.lever[0, i]),
            across=float(chain.inertia[0, i]),
            along=float(chain.axial[0, i]),
            spring=float(arrays.spring[0, i]),
            damper=float(arrays.damper[0, i]),
            share=shares[i],
            hinges=_hinges(model, i, float(starts[i])),
            colour=colour(i / max(arm.links - 1, 1)),
        )
        for i in range(arm.links)
    )
    base, gravity = _frame(model)
    return Bodies(
        links=links,
        base_length=float(heights[0]),
        payload=arm.tip_mass,
        sites=_sites(model, links),
        rpy=base,
        gravity=gravity,
        shape=shape(arm),
    )


def _hinges(model: CorrectedModel, joint: int, start: float) -> tuple[Hinge, ...]:
    """What a joint, counted from 0, is made of."""
    arrays, name, link = model.columns.arrays, f"joint_{joint + 1}", f"link_{joint + 1}"
    before = f"link_{joint}" if joint else "base"
    spring, damper = float(arrays.spring[0, joint]), float(arrays.damper[0, joint])
    if not model.columns.space:
        return (Hinge(name, 0, before, link, start, spring, damper, slight=False),)
    ways = _in_order([0, 1] if math.isinf(arrays.twist[0, joint]) else [0, 1, 2], joint)
    names = [*(f"{link}_{_WAYS[way]}" for way in ways[:-1]), link]
    stiff = {0: (spring, damper), 1: (spring, damper), 2: (float(arrays.twist[0, joint]), float(arrays.twist_damper[0, joint]))}
    return tuple(
        Hinge(f"{name}_{_WAYS[way]}", way, parent, child, 0.0 if k else start, *stiff[way], slight=child != link)
        for k, (way, parent, child) in enumerate(zip(ways, [before, *names[:-1]], names, strict=True))
    )


def _in_order(ways: list[int], joint: int) -> list[int]:
    """Of a joint's hinges, from the base on."""
    return ways[::-1] if joint % 2 else ways


def _frame(model: CorrectedModel) -> tuple[tuple[float, float, float], Array]:
    """Roll, pitch and yaw [rad] of the base in the frame in which the markers are seen, and gravity (3,) [m/s^2] there.

    That frame was turned with the base where the mount's own tilt was (the readings "base").
    """
    arm, turned = model.loaded_arm, _turned_frame(model)
    if arm.bending == "space":
        axes, back = base_rotations(Arms.of([arm]))[0], np.eye(3)
        for turn in turned:
            back = rotations(vectors(np.array([-turn.real, -turn.imag, 0.0]))) @ back
        return angles_of(axes @ back), axes @ back @ axes.T @ np.array([0.0, 0.0, -GRAVITY])
    turn = sum(turned, 0j).real
    sideways = math.sin(turn) * (-1.0 if arm.mount == "hanging" else 1.0)  # its joints turn about -y of the world
    return _rpy(arm.mount, arm.tilt - turn), GRAVITY * np.array([sideways, 0.0, -math.cos(turn)])


def angles_of(turn: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw [rad] of a rotation matrix (3, 3); no yaw where a pitch of a quarter turn leaves roll and yaw open."""
    x, y, z = turn.T
    level = math.hypot(x[0], x[1])
    pitch = math.atan2(-x[2], level)
    if level < LOCKED:
        return math.atan2(-z[1], y[1]), pitch, 0.0
    return math.atan2(y[2], z[2]), pitch, math.atan2(x[1], x[0])


def _rpy(mount: str, tilt: float) -> tuple[float, float, float]:
    """Of the base: the mount, turned by ``tilt`` [rad] towards positive bending."""
    roll = math.pi if mount == "hanging" else 0.0
    return roll, {"upright": tilt, "hanging": -tilt, "horizontal": math.pi / 2 + tilt}[mount], 0.0


def _turned_frame(model: CorrectedModel) -> list[complex]:
    """[rad] by which the frame of the markers was turned, towards x and towards y: with the base, or cameras alone."""
    tilts: list[Any] = [effect for effect in model.effects if effect.name in ("gravity_tilt", "base_tilt")]
    ways = {"world": 0.0, "base": 1.0, "cameras": -1.0}
    return [ways[tilt.frame] * _aside(tilt, "angle") for tilt in tilts if ways[tilt.frame]]


def _aside(effect: Any, name: str) -> complex:
    """An effect's number towards x, or its two towards x and towards y."""
    return complex(getattr(effect, name)) if hasattr(effect, name) else complex(effect.towards_x, effect.towards_y)


def _sites(model: CorrectedModel, links: tuple[Link, ...]) -> tuple[Site, ...]:
    heights = [link.height for link in links]
    found = []
    for marker in model.markers:
        carrier = int(np.searchsorted(heights, marker.arc_length, side="left")) - 1
        parent, start = (links[carrier].name, heights[carrier]) if carrier >= 0 else ("base", 0.0)
        place = marker.beside + _moved(model, at_base=marker.arc_length == 0)
        found.append(Site(marker.name, parent, place.real, place.imag, marker.arc_length - start))
    return tuple(found)


def _moved(model: CorrectedModel, *, at_base: bool) -> complex:
    """[m] by which a marker sits beside where it is declared, towards x and towards y of its link."""
    offsets: list[Any] = [effect for effect in model.effects if effect.name in ("marker_offset", "markers_beside")]
    return sum((_aside(each, "offset") for each in offsets if not (at_base and each.base == "kept")), 0j)
