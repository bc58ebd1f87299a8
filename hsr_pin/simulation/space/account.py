"""The energies of an arm in space, as :mod:`hsr_pin.simulation.energy` has those in the plane."""

from __future__ import annotations

import numpy as np

from hsr_pin.robot.chain import GRAVITY
from hsr_pin.robot.space_kinematics import angular_velocities, space_marker_map
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


def kinetic_and_height(columns: Columns, q: Array, v: Array) -> tuple[Array, Array]:
    """(T,) [J] each of the first arm's links: kinetic energy, and energy in gravity.

    Args:
        columns: the arm.
        q: (T, N, 3) coordinates [rad].
        v: (T, N, 3) rates [rad/s].
    """
    arrays = columns.arrays
    frames = space_marker_map(columns.arms, [0.0]).frames(q)
    axes, omega = frames[:, 1:, :, 2], angular_velocities(frames, q, v)
    turning = np.cross(omega, axes)
    reach, lever = arrays.reach[0][:, None], arrays.lever[0][:, None]
    places, speeds = ((part * reach).cumsum(axis=1) + part * (lever - reach) for part in (axes, turning))
    spin = (omega * axes).sum(axis=2)
    across = (omega**2).sum(axis=2) - spin**2
    moving = arrays.mass[0] * (speeds**2).sum(axis=2) + arrays.inertia[0] * across + arrays.axial[0] * spin**2
    return moving.sum(axis=1) / 2, GRAVITY * (arrays.mass[0] * places[:, :, 2]).sum(axis=1)


def twisting(columns: Columns, q: Array) -> Array:
    """(T,) [J] held by twist, for coordinates (T, N, 3)."""
    twist = columns.arrays.twist[0]
    return np.asarray((np.where(np.isfinite(twist), twist, 0.0) * q[:, :, 2] ** 2).sum(axis=1) / 2)


def work_of_loads(scenario: Scenario, columns: Columns, q: Array) -> Array:
    """(T - 1,) [J] brought in from sample to sample by the forces of the loads, which are held between samples."""
    brought = np.zeros(len(q) - 1)
    if scenario.loads:
        ways = np.diff(space_marker_map(columns.arms, scenario.points).positions(q.reshape(len(q), -1)), axis=0)
        for k, load in enumerate(scenario.loads):
            forces = load.wrenches(len(scenario.time))[: len(brought), :3]
            brought += (forces * ways[:, k]).sum(axis=1)
    return brought
