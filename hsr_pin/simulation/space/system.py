"""Arms in space as arrays; :class:`hsr_pin.simulation.kernel.System` is the equivalent for planar arms."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.robot.chain import GRAVITY, Arms, chain_of
from hsr_pin.robot.sections import inputs
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.specification import joint_arc_lengths
from hsr_pin.trajectory import Array


class SpaceSystem(NamedTuple):
    """The arrays of B arms with K loads that the loops need; forces and moments are in the axes of the base.

    Attributes:
        mass, lever, inertia, reach: (B, N) as in :class:`hsr_pin.robot.chain.Chain`.
        axial: (B, N) inertia about the link's own axis [kg m^2].
        spring, damper, stiff, drag, share, profile: (B, N) as for planar arms, the same about both bending axes.
        twist, twist_damper: (B, N) torsional stiffness [Nm/rad] and damping [Nm s/rad]; infinite stiffness means no twist.
        gravity: (B, 3) acceleration of gravity [m/s^2].
        keq: (B,) bending stiffness of the whole arm [Nm/rad].
        laws, numbers, world, touch: as for planar arms.
        link: (B, K) index of the link that each load acts on; -1 for the fixed half link.
        place: (B, K) distance of each load from the joint of its link [m].
        inputs: (N, S) share of each section's torque that drives each joint.
    """

    mass: Array
    lever: Array
    inertia: Array
    reach: Array
    axial: Array
    spring: Array
    damper: Array
    stiff: Array
    drag: Array
    share: Array
    profile: Array
    twist: Array
    twist_damper: Array
    gravity: Array
    keq: Array
    laws: NDArray[np.int64]
    numbers: Array
    world: Array
    touch: NDArray[np.int64]
    link: NDArray[np.int64]
    place: Array
    inputs: Array


def space_system(arms: Arms, joints: dict[str, Array], points: Array, world: Array, touch: NDArray[np.int64]) -> SpaceSystem:
    """Return the arrays of arms in space without their laws.

    Args:
        arms: the arms including the effects on their bodies.
        joints: (B, N) each: spring, damper, stiff, drag, share, profile.
        points: (B, K) arc lengths of the loads [m].
        world: (B, O, ENTRIES) obstacles.
        touch: (4,) as for planar arms.
    """
    chain, links = chain_of(arms), arms.links
    with np.errstate(invalid="ignore"):
        twist_damper = links * (arms.torsion * arms.damping / arms.keq)[:, None] * joints["profile"]
    starts = joint_arc_lengths(links, arms.placement) * arms.length[:, None]
    link = np.count_nonzero(starts[:, None] < points[..., None], axis=2) - 1
    first = np.take_along_axis(starts, np.maximum(link, 0), axis=1)
    bodies = {name: getattr(chain, name) for name in ("mass", "lever", "inertia", "reach", "axial")}
    fields: dict[str, Any] = {
        **bodies,
        **joints,
        "twist": links * arms.torsion[:, None] * joints["profile"],
        "twist_damper": np.nan_to_num(twist_damper),
        "gravity": -GRAVITY * base_rotations(arms)[:, 2],
        "keq": arms.keq,
        "numbers": np.zeros((0, 1, len(arms))),
        "world": world,
        "place": points - first,
        "inputs": inputs(arms.sections, links),
    }
    whole = {"laws": np.zeros((0, 4), dtype=np.int64), "link": link.astype(np.int64), "touch": touch}
    arrays = {name: np.array(value, dtype=float, order="C") for name, value in fields.items()} | whole
    return SpaceSystem(**arrays)
