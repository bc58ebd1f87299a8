"""The rigid bodies of many planar arms as arrays, in closed form, equivalent to Pinocchio's model of each arm's URDF.

A test compares them with ``pin.buildModelFromXML`` for arbitrary arms; here, no text needs to be written and parsed for each of a
thousand arms.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hsr_pin.obstacles import Obstacle
from hsr_pin.robot.sections import bodies_of
from hsr_pin.robot.specification import ArmSpecification, gravity_direction, joint_arc_lengths, link_shares, mount_frame
from hsr_pin.trajectory import Array, Section

#: Acceleration of gravity of Pinocchio [m/s^2].
GRAVITY = 9.81
_SAME = ("links", "placement", "mount", "bending", "sections", "obstacles")


@dataclass(frozen=True, eq=False)
class Arms:
    """B arms that differ in numbers only: an :class:`ArmSpecification` whose numbers are (B,) arrays."""

    links: int
    placement: str
    mount: str
    keq: Array
    damping: Array
    length: Array
    mass: Array
    diameter: Array
    tip_mass: Array
    tilt: Array
    bending_limit: Array
    torsion: Array
    cross_tilt: Array
    bending: str = "plane"
    sections: tuple[Section, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()

    #: Names of the numbers that may differ.
    NUMBERS: ClassVar[tuple[str, ...]] = (
        *("keq", "damping", "length", "mass", "diameter", "tip_mass", "tilt", "bending_limit", "torsion", "cross_tilt"),
    )

    @classmethod
    def of(cls, specifications: Sequence[ArmSpecification]) -> Arms:
        """Combine arms with the same number of links, placement, mount, bending, sections and obstacles."""
        first = specifications[0]
        assert all(getattr(other, name) == getattr(first, name) for other in specifications for name in _SAME)
        numbers = {n: np.array([getattr(s, n) for s in specifications], dtype=float) for n in cls.NUMBERS}
        return cls(
            first.links,
            first.placement,
            first.mount,
            bending=first.bending,
            sections=first.sections,
            obstacles=first.obstacles,
            **numbers,
        )

    def __len__(self) -> int:
        return len(self.keq)

    def numbers(self) -> dict[str, Array]:
        """Return the (B,) arrays by name."""
        return {name: getattr(self, name) for name in self.NUMBERS}

    def specification(self, index: int) -> ArmSpecification:
        """Return the specification of one of the arms."""
        numbers = {name: float(values[index]) for name, values in self.numbers().items()}
        same = {name: getattr(self, name) for name in _SAME}
        return ArmSpecification(**same, **numbers)  # type: ignore[arg-type]

    def subset(self, members: Any) -> Arms:
        """Return some of the arms (indices or a slice)."""
        return dataclasses.replace(self, **{name: values[members] for name, values in self.numbers().items()})

    def frame(self) -> tuple[Array, Array]:
        """Return the directions (B, 3) of the straight arms and of positive bending, unit vectors in the world frame."""
        along, across = mount_frame(self.mount)
        c, s = np.cos(self.tilt)[:, None], np.sin(self.tilt)[:, None]
        return c * along + s * across, c * across - s * along


@dataclass(frozen=True, eq=False)
class Chain:
    """The moving links of the arms, (B, N) each, and gravity.

    Attributes:
        mass: mass [kg].
        lever: distance from a link's joint to its centre of mass [m].
        inertia: moment of inertia about a transverse axis through the centre of mass [kg m^2].
        reach: distance from a link's joint to the next one, or to the tip [m].
        axial: moment of inertia about the link's own axis [kg m^2].
        gravity: (B, 2) acceleration of gravity along the straight arm, and across it towards positive bending [m/s^2].
    """

    mass: Array
    lever: Array
    inertia: Array
    reach: Array
    axial: Array
    gravity: Array


def chain_of(arms: Arms) -> Chain:
    """Return the links of arms as the uniform cylinders of their URDF, with the point mass at the tip."""
    links, element = arms.links, (arms.length / arms.links)[:, None]
    share = link_shares(links, arms.placement)[None, 1:]  # the part before the first joint does not move
    reach = share * element
    mass = share * (arms.mass / links)[:, None]
    lever = reach / 2
    radius = (arms.diameter / 2)[:, None]
    inertia = mass * (3 * radius**2 + reach**2) / 12
    if arms.sections:
        joints = joint_arc_lengths(links, arms.placement)
        part, centre, gyration = bodies_of(arms.sections, joints, np.append(joints[1:], 1.0))
        mass, lever = part * arms.mass[:, None], centre * arms.length[:, None]
        inertia = mass * (radius**2 / 4 + (gyration * arms.length[:, None]) ** 2)
    axial = mass * radius**2 / 2
    tip = np.zeros_like(mass)
    tip[:, -1] = arms.tip_mass
    together = mass + tip
    centre = (mass * lever + tip * reach) / together
    inertia = inertia + mass * (lever - centre) ** 2 + tip * (reach - centre) ** 2
    along, across = arms.frame()
    down = GRAVITY * gravity_direction(arms.mount)
    return Chain(together, centre, inertia, reach, axial, np.column_stack([along @ down, across @ down]))


def mass_matrix(chain: Chain) -> Array:
    """Return the mass matrix (N, N) [kg m^2] of the first arm in the straight pose.

    An entry is the moment of inertia, about both joints, of the bodies beyond the farther joint. It is in closed form, because
    Pinocchio's data of a thousand links take 20 GB.
    """
    joint, beyond, (zeroth, first, second) = _beyond(chain)
    moved = np.add.outer(joint, joint) * first[beyond]
    return np.asarray(second[beyond] - moved + np.outer(joint, joint) * zeroth[beyond])


def weight_matrix(chain: Chain) -> Array:
    """Return the gravitational stiffness (N, N) [N m/rad] of the first arm in the straight pose; negative if upright."""
    joint, beyond, (zeroth, first, _) = _beyond(chain)
    return np.asarray(chain.gravity[0, 0] * (first[beyond] - joint[beyond] * zeroth[beyond]))


def _beyond(chain: Chain) -> tuple[Array, NDArray[np.intp], list[Array]]:
    """Return joint positions (N,) [m], the farther of two joints (N, N), and moments (N,) of the mass beyond each joint.

    The moments are of order 0 to 2, about the base.
    """
    joint = np.cumsum(chain.reach[0]) - chain.reach[0]
    mass, centre = chain.mass[0], joint + chain.lever[0]
    moments = (mass, mass * centre, mass * centre**2 + chain.inertia[0])
    beyond = np.maximum.outer(np.arange(len(joint)), np.arange(len(joint)))
    return joint, beyond, [np.cumsum(each[::-1])[::-1] for each in moments]
