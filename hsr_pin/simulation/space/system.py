"""Arms in space side by side as arrays; see :class:`hsr_pin.simulation.kernel.System` for those in the plane."""

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
    """What the loops need to know of B arms with K loads; forces and moments are in the axes of the base.

    Attributes:
        mass, lever, inertia, reach: (B, N) as in :class:`hsr_pin.robot.chain.Chain`.
        axial: (B, N) [kg m^2] about the links' own axes.
        spring, damper, stiff, drag, share, profile: (B, N) as in the plane, the same about both axes of bending.
        twist, twist_damper: (B, N) [Nm/rad], [Nm s/rad] against twisting; infinite: it does not twist.
        gravity: (B, 3) [m/s^2].
        keq: (B,) [Nm/rad] of the whole arm.
        laws, numbers: as in the plane.
        link: (B, K) that each load acts on, -1: the fixed half link.
        place: (B, K) [m] where, from the link's joint.
        inputs: (N, S) share of each section's torque that drives a joint.
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
    link: NDArray[np.int64]
    place: Array
    inputs: Array


def space_system(arms: Arms, joints: dict[str, Array], points: Array) -> SpaceSystem:
    """The arms without their laws.

    Args:
        arms: with what the effects make of them.
        joints: (B, N) each: spring, damper, stiff, drag, share, profile.
        points: (B, K) [m] arc lengths of the loads.
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
        "place": points - first,
        "inputs": inputs(arms.sections, links),
    }
    whole = {"laws": np.zeros((0, 4), dtype=np.int64), "link": link.astype(np.int64)}
    arrays = {name: np.array(value, dtype=float, order="C") for name, value in fields.items()} | whole
    return SpaceSystem(**arrays)
