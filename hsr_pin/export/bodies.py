"""Links, joints and markers as every target needs them: the straight arm along +z of the base, bending towards +x about +y."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.robot.appearance import colour, shape
from hsr_pin.robot.chain import GRAVITY, Arms, chain_of
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Link:
    """A rigid link on its joint.

    Attributes:
        number: from 1, base to tip.
        start: [m] of the joint along the link before it (the base for the first).
        height: [m] of the joint above the base, in the straight arm.
        length, radius: [m] of the cylinder.
        mass: [kg], the payload not included.
        across, along: [kg m^2] inertia about its middle.
        spring, damper: [Nm/rad], [Nm s/rad] of the joint.
        share: of the torque that arrives there.
        colour: (r, g, b).
    """

    number: int
    start: float
    height: float
    length: float
    radius: float
    mass: float
    across: float
    along: float
    spring: float
    damper: float
    share: float
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
    """A marker: ``x``, ``z`` [m] in the frame of the link (or base) that carries it."""

    name: str
    parent: str
    x: float
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
        """(w, x, y, z) of the base: Ry(pitch) Rx(roll)."""
        roll, pitch, _ = self.rpy
        (c, s), (a, b) = (math.cos(pitch / 2), math.sin(pitch / 2)), (math.cos(roll / 2), math.sin(roll / 2))
        return c * a, c * b, s * a, -s * b

    @property
    def gravity_is_turned(self) -> bool:
        """Whether gravity does not point along -z of the frame in which the markers are seen."""
        return bool(abs(self.gravity[0]) > 1e-12)


def bodies_of(model: CorrectedModel) -> Bodies:
    """The bodies of a model; they move as those of :func:`hsr_pin.robot.model.build_model`."""
    arm, arrays = model.loaded_arm, model.columns.arrays
    chain = chain_of(Arms.of([replace(arm, tip_mass=0.0)]))
    lengths, heights = chain.reach[0], arm.joint_arc_lengths * arm.length
    starts = np.diff(heights, prepend=0.0)
    links = tuple(
        Link(
            number=i + 1,
            start=float(starts[i]),
            height=float(heights[i]),
            length=float(lengths[i]),
            radius=arm.diameter / 2,
            mass=float(chain.mass[0, i]),
            across=float(chain.inertia[0, i]),
            along=float(chain.mass[0, i]) * (arm.diameter / 2) ** 2 / 2,
            spring=float(arrays.spring[0, i]),
            damper=float(arrays.damper[0, i]),
            share=float(arrays.share[0, i]),
            colour=colour(i / max(arm.links - 1, 1)),
        )
        for i in range(arm.links)
    )
    turned = _turned_frame(model)
    sideways = math.sin(turned) * (-1.0 if arm.mount == "hanging" else 1.0)  # its joints turn about -y of the world
    return Bodies(
        links=links,
        base_length=float(heights[0]),
        payload=arm.tip_mass,
        sites=_sites(model, links),
        rpy=_rpy(arm.mount, arm.tilt - turned),
        gravity=GRAVITY * np.array([sideways, 0.0, -math.cos(turned)]),
        shape=shape(arm),
    )


def _rpy(mount: str, tilt: float) -> tuple[float, float, float]:
    """Of the base: the mount, turned by ``tilt`` [rad] towards positive bending."""
    roll = math.pi if mount == "hanging" else 0.0
    return roll, {"upright": tilt, "hanging": -tilt, "horizontal": math.pi / 2 + tilt}[mount], 0.0


def _turned_frame(model: CorrectedModel) -> float:
    """[rad] by which the frame of the markers was turned towards positive bending: with the base, or cameras alone."""
    tilt = model.effect("gravity_tilt")
    way = {"world": 0.0, "base": 1.0, "cameras": -1.0}[dict(tilt.options)["frame"]] if tilt is not None else 0.0
    return way * float(tilt.angle) if way else 0.0  # type: ignore[union-attr]


def _sites(model: CorrectedModel, links: tuple[Link, ...]) -> tuple[Site, ...]:
    offset = model.effect("marker_offset")
    heights = [link.height for link in links]
    found = []
    for marker in model.markers:
        carrier = int(np.searchsorted(heights, marker.arc_length, side="left")) - 1
        parent, start = (links[carrier].name, heights[carrier]) if carrier >= 0 else ("base", 0.0)
        moved = offset is not None and (marker.arc_length > 0 or dict(offset.options)["base"] != "kept")
        x = float(offset.offset) if offset is not None and moved else 0.0  # type: ignore[attr-defined]
        found.append(Site(marker.name, parent, x, marker.arc_length - start))
    return tuple(found)
