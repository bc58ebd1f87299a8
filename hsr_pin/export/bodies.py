"""Links, joints and markers for all formats: the straight arm is along +z of the base and bends towards +x about +y.

In space a joint consists of two hinges at one point, towards x and towards y, and a third hinge if the arm twists. Hinges in
series differ from a rotation vector: their order rotates the following links by half the product of their angles. The order
therefore alternates from joint to joint, so that neighbouring joints cancel this rotation (G. Strang, SIAM J. Numer. Anal. 5,
1968). This reduces the error from 1/N to 1/N^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.solids import Solid, angles_of, quaternion, solids_of
from hsr_pin.robot.appearance import colour, shape
from hsr_pin.robot.chain import GRAVITY, Arms, chain_of
from hsr_pin.robot.links import planar_rpy
from hsr_pin.robot.rotations import rotations, vectors
from hsr_pin.robot.sections import inputs
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.specification import gravity_direction
from hsr_pin.trajectory import Array

#: Rotation axes of the hinges for bending towards x, bending towards y, and twist.
_AXES = ("0 1 0", "-1 0 0", "0 0 1")
_WAYS = ("x", "y", "twist")


@dataclass(frozen=True)
class Hinge:
    """Hinge about one axis of a joint.

    Attributes:
        name: ``joint_1``, in space ``joint_1_x``, ``joint_1_y`` and ``joint_1_twist``.
        way: kind of rotation; 0: towards x; 1: towards y; 2: twist.
        parent, child: links that it connects; links of negligible mass connect the hinges of one joint.
        start: position of the hinge along the parent [m].
        spring, damper: stiffness [Nm/rad] and damping [Nm s/rad].
        slight: whether the child is a link of negligible mass.
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
        """Axis of rotation as text for XML."""
        return _AXES[self.way]


@dataclass(frozen=True)
class Link:
    """Rigid link and its joint.

    Attributes:
        number: from 1, base to tip.
        start: position of the joint along the previous link [m] (the base for the first link).
        height: distance of the joint from the base in the straight arm [m].
        length, radius: size of the cylinder [m].
        mass: mass without the payload [kg].
        centre: distance of the centre of mass from the joint [m].
        across, along: moments of inertia about the centre of mass, across and along the link [kg m^2].
        spring, damper: bending stiffness [Nm/rad] and damping [Nm s/rad] of the joint.
        share: (S,) share of the torque of each section that acts at the joint.
        hinges: hinges of the joint.
        colour: colour (r, g, b).
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
        """Name of the link, such as ``link_1``."""
        return f"link_{self.number}"

    @property
    def joint(self) -> str:
        """Name of the joint of the link, such as ``joint_1``."""
        return f"joint_{self.number}"

    @property
    def parent(self) -> str:
        """Name of the previous link, or of the base."""
        return f"link_{self.number - 1}" if self.number > 1 else "base"


@dataclass(frozen=True)
class Site:
    """Marker at ``x``, ``y``, ``z`` [m] in the frame of the link (or base) that carries it."""

    name: str
    parent: str
    x: float
    y: float
    z: float


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies of the arm in its base frame.

    Attributes:
        links: links from base to tip.
        base_length: length of the half link that is fixed to the base [m]; 0 for joints at the base ends.
        payload: payload at the tip [kg], at ``links[-1].length`` along the last link.
        sites: markers.
        rpy: roll, pitch and yaw [rad] of the base in the world frame, in which the markers are seen.
        gravity: (3,) gravity in the world frame [m/s^2].
        shape: dimensions for drawing.
        solids: obstacles that the arm may touch.
    """

    links: tuple[Link, ...]
    base_length: float
    payload: float
    sites: tuple[Site, ...]
    rpy: tuple[float, float, float]
    gravity: Array
    shape: dict[str, object]
    solids: tuple[Solid, ...]

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Quaternion (w, x, y, z) of the base: Rz(yaw) Ry(pitch) Rx(roll)."""
        return quaternion(self.rpy)

    @property
    def gravity_is_turned(self) -> bool:
        """Whether gravity does not point along -z of the frame in which the markers are seen."""
        return bool(np.abs(self.gravity[:2]).max() > 1e-12)

    @property
    def hinges(self) -> tuple[Hinge, ...]:
        """Hinges of all joints in order from base to tip."""
        return tuple(hinge for link in self.links for hinge in link.hinges)


def bodies_of(model: CorrectedModel) -> Bodies:
    """Return the bodies of a model, which move like those of :func:`hsr_pin.robot.model.build_model` (in space approximately)."""
    arm, arrays = model.loaded_arm, model.batch.arrays
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
        solids=solids_of(model),
    )


def _hinges(model: CorrectedModel, joint: int, start: float) -> tuple[Hinge, ...]:
    """Return the hinges of a joint, which is counted from 0."""
    arrays, name, link = model.batch.arrays, f"joint_{joint + 1}", f"link_{joint + 1}"
    before = f"link_{joint}" if joint else "base"
    spring, damper = float(arrays.spring[0, joint]), float(arrays.damper[0, joint])
    if not model.batch.space:
        return (Hinge(name, 0, before, link, start, spring, damper, slight=False),)
    ways = _in_order([0, 1] if math.isinf(arrays.twist[0, joint]) else [0, 1, 2], joint)
    names = [*(f"{link}_{_WAYS[way]}" for way in ways[:-1]), link]
    stiff = {0: (spring, damper), 1: (spring, damper), 2: (float(arrays.twist[0, joint]), float(arrays.twist_damper[0, joint]))}
    return tuple(
        Hinge(f"{name}_{_WAYS[way]}", way, parent, child, 0.0 if k else start, *stiff[way], slight=child != link)
        for k, (way, parent, child) in enumerate(zip(ways, [before, *names[:-1]], names, strict=True))
    )


def _in_order(ways: list[int], joint: int) -> list[int]:
    """Return the order of a joint's hinges from the base."""
    return ways[::-1] if joint % 2 else ways


def _frame(model: CorrectedModel) -> tuple[tuple[float, float, float], Array]:
    """Return roll, pitch and yaw [rad] of the base, and gravity (3,) [m/s^2], in the frame in which the markers are seen.

    That frame is rotated with the base if the mount itself was tilted (the variants "base").
    """
    arm, turned = model.loaded_arm, _turned_frame(model)
    if arm.bending == "space":
        axes, back = base_rotations(Arms.of([arm]))[0], np.eye(3)
        for turn in turned:
            back = rotations(vectors(np.array([-turn.real, -turn.imag, 0.0]))) @ back
        return angles_of(axes @ back), axes @ back @ axes.T @ np.array([0.0, 0.0, -GRAVITY])
    turn = sum(turned, 0j).real
    sense = -1.0 if arm.mount == "hanging" else 1.0  # its joints rotate about -y of the world
    c, s = math.cos(turn), sense * math.sin(turn)
    turned_back = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return planar_rpy(arm.mount, arm.tilt - turn), GRAVITY * turned_back @ gravity_direction(arm.mount)


def _turned_frame(model: CorrectedModel) -> list[complex]:
    """Return the rotations of the markers' frame [rad], towards x and towards y, with the base and of the cameras alone."""
    tilts: list[Any] = [effect for effect in model.effects if effect.name in ("gravity_tilt", "base_tilt")]
    ways = {"world": 0.0, "base": 1.0, "cameras": -1.0}
    return [ways[tilt.frame] * _aside(tilt, "angle") for tilt in tilts if ways[tilt.frame]]


def _aside(effect: Any, name: str) -> complex:
    """Return an effect's parameter towards x, or its two parameters towards x and towards y, as a complex number."""
    return complex(getattr(effect, name)) if hasattr(effect, name) else complex(effect.towards_x, effect.towards_y)


def _sites(model: CorrectedModel, links: tuple[Link, ...]) -> tuple[Site, ...]:
    heights = [link.height for link in links]
    found = []
    for marker in model.markers:
        carrier = int(np.searchsorted(heights, marker.arc_length, side="left")) - 1
        parent, start = (links[carrier].name, heights[carrier]) if carrier >= 0 else ("base", 0.0)
        place = marker.offset + _moved(model, at_base=marker.arc_length == 0)
        found.append(Site(marker.name, parent, place.real, place.imag, marker.arc_length - start))
    return tuple(found)


def _moved(model: CorrectedModel, *, at_base: bool) -> complex:
    """Return the offset of the markers from their declared positions [m], towards x and towards y of the link."""
    offsets: list[Any] = [effect for effect in model.effects if effect.name in ("marker_offset", "markers_beside")]
    return sum((_aside(each, "offset") for each in offsets if not (at_base and each.base == "kept")), 0j)
