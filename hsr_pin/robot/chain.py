"""The rigid bodies of many planar arms as arrays: what Pinocchio makes of each arm's URDF, in closed form.

A test holds it against ``pin.buildModelFromXML`` for any arm; here there is no text to write and read for each of a thousand.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from hsr_pin.robot.sections import bodies_of
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths, link_shares, mount_frame
from hsr_pin.trajectory import Array, Section

#: Acceleration of gravity [m/s^2], Pinocchio's.
GRAVITY = 9.81
_SAME = ("links", "placement", "mount", "bending", "sections")


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

    #: Names of those that differ.
    NUMBERS: ClassVar[tuple[str, ...]] = (
        *("keq", "damping", "length", "mass", "diameter", "tip_mass", "tilt", "bending_limit", "torsion", "cross_tilt"),
    )

    @classmethod
    def of(cls, specifications: Sequence[ArmSpecification]) -> Arms:
        """The same arms side by side; all must have the same number of links, placement, mount and bending."""
        first = specifications[0]
        assert all(getattr(other, name) == getattr(first, name) for other in specifications for name in _SAME)
        numbers = {n: np.array([getattr(s, n) for s in specifications], dtype=float) for n in cls.NUMBERS}
        return cls(first.links, first.placement, first.mount, bending=first.bending, sections=first.sections, **numbers)

    def __len__(self) -> int:
        return len(self.keq)

    def numbers(self) -> dict[str, Array]:
        """The (B,) arrays by name."""
        return {name: getattr(self, name) for name in self.NUMBERS}

    def specification(self, column: int) -> ArmSpecification:
        """One of them."""
        numbers = {name: float(values[column]) for name, values in self.numbers().items()}
        same = {name: getattr(self, name) for name in _SAME}
        return ArmSpecification(**same, **numbers)  # type: ignore[arg-type]

    def columns(self, members: Any) -> Arms:
        """Some of them (indices or a slice)."""
        return dataclasses.replace(self, **{name: values[members] for name, values in self.numbers().items()})

    def frame(self) -> tuple[Array, Array]:
        """(B, 3) each: unit vectors along the straight arms, and across them towards positive bending, in the world frame."""
        along, across = mount_frame(self.mount)
        c, s = np.cos(self.tilt)[:, None], np.sin(self.tilt)[:, None]
        return c * along + s * across, c * across - s * along


@dataclass(frozen=True, eq=False)
class Chain:
    """The links that move, (B, N) each, and gravity.

    Attributes:
        mass: [kg].
        lever: [m] from a link's joint to its centre of mass.
        inertia: [kg m^2] about the centre of mass.
        reach: [m] from a link's joint to the next one, or to the tip.
        axial: [kg m^2] about the link's own axis.
        gravity: (B, 2) [m/s^2] along the straight arm, and across it towards positive bending.
    """

    mass: Array
    lever: Array
    inertia: Array
    reach: Array
    axial: Array
    gravity: Array


def chain_of(arms: Arms) -> Chain:
    """The links of uniform cylinders that the URDF holds, and the point mass at the tip."""
    links, element = arms.links, (arms.length / arms.links)[:, None]
    share = link_shares(links, arms.placement)[None, 1:]  # what is before the first joint does not move
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
    return Chain(together, centre, inertia, reach, axial, -GRAVITY * np.column_stack([along[:, 2], across[:, 2]]))


def mass_matrix(chain: Chain) -> Array:
    """(N, N) [kg m^2] of the first arm where it is straight: what lies beyond the farther joint of two turns with both.

    In closed form, since Pinocchio's data of a thousand links take 20 GB.
    """
    joint, beyond, (zeroth, first, second) = _beyond(chain)
    moved = np.add.outer(joint, joint) * first[beyond]
    return np.asarray(second[beyond] - moved + np.outer(joint, joint) * zeroth[beyond])


def weight_matrix(chain: Chain) -> Array:
    """(N, N) [N m/rad] what gravity makes stiffer of the first arm where it is straight; softer where it stands upright."""
    joint, beyond, (zeroth, first, _) = _beyond(chain)
    return np.asarray(chain.gravity[0, 0] * (first[beyond] - joint[beyond] * zeroth[beyond]))


def _beyond(chain: Chain) -> tuple[Array, NDArray[np.intp], list[Array]]:
    """(N,) [m] where the joints are, (N, N) the farther of two, and the moments (N,) of the mass beyond each about the base."""
    joint = np.cumsum(chain.reach[0]) - chain.reach[0]
    mass, centre = chain.mass[0], joint + chain.lever[0]
    moments = (mass, mass * centre, mass * centre**2 + chain.inertia[0])
    beyond = np.maximum.outer(np.arange(len(joint)), np.arange(len(joint)))
    return joint, beyond, [np.cumsum(each[::-1])[::-1] for each in moments]
