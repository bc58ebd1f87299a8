"""An arm that bends in space: its base in the world, its bodies, and its Pinocchio model with one spherical joint per element."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pinocchio as pin

from hsr_pin.robot.chain import Arms, chain_of
from hsr_pin.robot.rotations import rotations, vectors
from hsr_pin.robot.specification import ArmSpecification, joint_arc_lengths, mount_frame
from hsr_pin.trajectory import Array


def base_rotations(arms: Arms) -> Array:
    """Return the axes (B, 3, 3) of the bases in the world: towards positive bending, sideways, along the straight arm."""
    along, across = mount_frame(arms.mount)
    mounted = np.column_stack([across, np.cross(along, across), along])
    turned = rotations(vectors(np.stack([arms.tilt, arms.cross_tilt, np.zeros(len(arms))], axis=-1)))
    return np.asarray(mounted @ turned)


@lru_cache(maxsize=256)
def space_model(specification: ArmSpecification) -> pin.Model:
    """Return the Pinocchio model of an arm in space, with gravity along -z of the world; copy it before changing it."""
    arms = Arms.of([specification])
    chain = chain_of(arms)
    starts = np.diff(joint_arc_lengths(arms.links, arms.placement) * specification.length, prepend=0.0)
    model, parent = pin.Model(), 0
    place = pin.SE3(base_rotations(arms)[0], np.zeros(3))
    for i in range(arms.links):
        along = pin.SE3(np.eye(3), np.array([0.0, 0.0, starts[i]]))
        parent = model.addJoint(parent, pin.JointModelSpherical(), place * along, f"joint_{i + 1}")
        across = chain.inertia[0, i]
        inertia = np.diag([across, across, chain.axial[0, i]])
        body = pin.Inertia(chain.mass[0, i], np.array([0.0, 0.0, chain.lever[0, i]]), inertia)
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
        place = pin.SE3.Identity()
    return model
