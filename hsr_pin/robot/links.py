"""The cylinders and hinges of an arm's URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hsr_pin.robot.appearance import colour
from hsr_pin.robot.specification import ArmSpecification, link_shares


@dataclass(frozen=True)
class Hinge:
    """A revolute joint between two links; ``slight`` if the second link has no length and a negligible mass."""

    name: str
    parent: str
    child: str
    start: float  # [m] along the parent
    axis: str
    slight: bool = False


@dataclass(frozen=True)
class Link:
    """A uniform solid cylinder on its joint; an empty ``joint`` means that it is fixed."""

    name: str
    parent: str
    joint: str
    start: float  # [m] along the parent
    length: float  # [m]
    mass: float  # [kg]
    radius: float  # [m]
    colour: tuple[float, float, float]

    @property
    def inertia_across(self) -> float:
        """Moment of inertia about a transverse axis through the middle of the link [kg m^2]."""
        return self.mass * (3 * self.radius**2 + self.length**2) / 12

    @property
    def inertia_along(self) -> float:
        """Moment of inertia about the link's own axis [kg m^2]."""
        return self.mass * self.radius**2 / 2

    def hinges(self, spec: ArmSpecification) -> list[Hinge]:
        """Return the hinges that connect the link to its parent."""
        if spec.bending == "plane":
            return [Hinge(self.joint, self.parent, self.name, self.start, "0 1 0")]
        turns = [("x", "0 1 0"), ("y", "-1 0 0"), *([("twist", "0 0 1")] if spec.torsion < math.inf else [])]
        children = [*(f"{self.name}_{turn}" for turn, _ in turns[:-1]), self.name]
        parents = [self.parent, *children[:-1]]
        return [
            Hinge(f"{self.joint}_{turn}", parent, child, 0.0 if k else self.start, axis, child != self.name)
            for k, ((turn, axis), parent, child) in enumerate(zip(turns, parents, children, strict=True))
        ]


def links_of(spec: ArmSpecification) -> list[Link]:
    """Return the links from base to tip: N whole links, or for "mid" a fixed half link, N - 1 whole links and a half link."""
    mid = spec.placement != "base"
    shares = link_shares(spec.links, spec.placement).tolist()[0 if mid else 1 :]
    links: list[Link] = []
    for i, share in enumerate(shares):
        number = i if mid else i + 1
        links.append(
            Link(
                name=f"link_{number}",
                parent=links[-1].name if links else "base",
                joint=f"joint_{number}" if number else "",
                start=links[-1].length if links else 0.0,
                length=share * spec.length / spec.links,
                mass=share * spec.mass / spec.links,
                radius=spec.diameter / 2,
                colour=colour(i / max(len(shares) - 1, 1)),
            )
        )
    return links


def base_rpy(spec: ArmSpecification) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of the base [rad]: R_mount Ry(tilt). For hanging, Rx(pi) Ry(tilt) = Ry(-tilt) Rx(pi)."""
    if spec.bending == "space":
        from hsr_pin.robot.chain import Arms
        from hsr_pin.robot.space import base_rotations  # late import: it loads Pinocchio

        x, y, z = base_rotations(Arms.of([spec]))[0].T
        return math.atan2(y[2], z[2]), math.atan2(-x[2], math.hypot(x[0], x[1])), math.atan2(x[1], x[0])
    return planar_rpy(spec.mount, spec.tilt)


def planar_rpy(mount: str, tilt: float) -> tuple[float, float, float]:
    """Return roll, pitch and yaw [rad] of a base with the mount and a ``tilt`` [rad] towards positive bending."""
    lying = math.pi / 2 + tilt
    pitch = {"upright": tilt, "hanging": -tilt, "horizontal": lying, "flat": lying}[mount]
    return math.pi if mount == "hanging" else 0.0, pitch, 0.0
