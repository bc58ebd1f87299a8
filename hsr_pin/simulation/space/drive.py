"""What drives arms in space over time: two components of torque for each section, and loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.robot.space import base_rotations
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


def delivered(columns: Columns, scenarios: Sequence[Scenario], deliver: Callable[[Array, Array], Delivered]) -> Delivered:
    """What arrives at the arms, (B, C + 1, U): of each section's torque, and the loads in the axes of the bases.

    Args:
        columns: the arms.
        scenarios: theirs, with the same times.
        deliver: passes (S, B) complex torques and (B,) before them through the muscles.
    """
    torque, before = np.array([s.command for s in scenarios]), np.array([s.held_under for s in scenarios])  # (B, T, S), (B, S)
    parts = [deliver(torque[:, :, section].T, before[:, section]) for section in range(torque.shape[2])]
    loads, held = _loads(columns, scenarios, parts[0].per_sample)
    impulse = np.concatenate([part for each in parts for part in (each.impulse.real, each.impulse.imag)])
    impulse = impulse.reshape(2 * len(parts), len(columns), -1).transpose(1, 2, 0)
    initial = np.stack([part for each in parts for part in (each.initial.real, each.initial.imag)], axis=1)
    return replace(
        parts[0],
        impulse=np.ascontiguousarray(np.concatenate([impulse, loads], axis=2)),
        initial=np.ascontiguousarray(np.concatenate([initial, held], axis=1)),
    )


def _loads(columns: Columns, scenarios: Sequence[Scenario], per_sample: int) -> tuple[Array, Array]:
    """(B, C + 1, 6 K) the integral of forces and moments over the cells, and (B, 6 K) what they were before."""
    samples, count = len(scenarios[0].time), len(scenarios[0].loads)
    wrenches, before = np.zeros((len(columns), samples, count, 2, 3)), np.zeros((len(columns), count, 2, 3))
    for b, (scenario, axes) in enumerate(zip(scenarios, base_rotations(columns.arms), strict=True)):
        for k, load in enumerate(scenario.loads):
            given = load.wrenches(samples)
            first = given[0] if load.before is None else np.asarray(load.before)
            wrenches[b, :, k], before[b, k] = given.reshape(-1, 2, 3) @ axes, first.reshape(2, 3) @ axes
    held = np.repeat(wrenches[:, :-1], per_sample, axis=1).reshape(len(columns), (samples - 1) * per_sample, 6 * count)
    return np.concatenate([np.zeros_like(held[:, :1]), held.cumsum(axis=1)], axis=1), before.reshape(len(columns), -1)
