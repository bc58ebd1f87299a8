"""The energies of an arm in space, for the energy balance of :mod:`hsr_pin.simulation.energy`."""

from __future__ import annotations

import numpy as np

from hsr_pin.robot.chain import GRAVITY
from hsr_pin.robot.space_kinematics import angular_velocities, space_marker_map
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


def kinetic_and_height(batch: ArmBatch, q: Array, v: Array) -> tuple[Array, Array]:
    """Return the kinetic energy and the gravitational energy of the first arm, (T,) [J] each.

    Args:
        batch: the arm.
        q: (T, N, 3) joint coordinates [rad].
        v: (T, N, 3) joint rates [rad/s].
    """
    arrays = batch.arrays
    frames = space_marker_map(batch.arms, [0.0]).frames(q)
    axes, omega = frames[:, 1:, :, 2], angular_velocities(frames, q, v)
    turning = np.cross(omega, axes)
    reach, lever = arrays.reach[0][:, None], arrays.lever[0][:, None]
    places, speeds = ((part * reach).cumsum(axis=1) + part * (lever - reach) for part in (axes, turning))
    spin = (omega * axes).sum(axis=2)
    across = (omega**2).sum(axis=2) - spin**2
    moving = arrays.mass[0] * (speeds**2).sum(axis=2) + arrays.inertia[0] * across + arrays.axial[0] * spin**2
    return moving.sum(axis=1) / 2, GRAVITY * (arrays.mass[0] * places[:, :, 2]).sum(axis=1)


def twisting(batch: ArmBatch, q: Array) -> Array:
    """Return the energy (T,) [J] of the twisted joints, for coordinates (T, N, 3)."""
    twist = batch.arrays.twist[0]
    return np.asarray((np.where(np.isfinite(twist), twist, 0.0) * q[:, :, 2] ** 2).sum(axis=1) / 2)


def work_of_loads(scenario: Scenario, batch: ArmBatch, q: Array) -> Array:
    """Return the work (T - 1,) [J] of the forces of the loads, which are held between samples, in each sampling interval."""
    brought = np.zeros(len(q) - 1)
    if scenario.loads:
        ways = np.diff(space_marker_map(batch.arms, scenario.points).positions(q.reshape(len(q), -1)), axis=0)
        for k, load in enumerate(scenario.loads):
            forces = load.wrenches(len(scenario.time))[: len(brought), :3]
            brought += (forces * ways[:, k]).sum(axis=1)
    return brought
