"""The inputs of arms in space over time: two components of torque for each section, and loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.robot.space import base_rotations
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.command import Delivered
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


def in_components(sections: Sequence[Delivered]) -> Delivered:
    """Combine the complex torques of S sections into real components towards x and towards y, (B, C + 1, 2 S)."""
    impulse = np.stack([part for each in sections for part in (each.impulse.real, each.impulse.imag)], axis=2)
    initial = np.stack([part for each in sections for part in (each.initial.real, each.initial.imag)], axis=1)
    return replace(sections[0], impulse=impulse, initial=initial)


def with_loads(batch: ArmBatch, scenarios: Sequence[Scenario], command: Delivered) -> Delivered:
    """Append the loads, in the axes of the bases, to the delivered torques, (B, C + 1, 2 S + 6 K)."""
    loads, held = _loads(batch, scenarios, command.per_sample)
    return replace(
        command,
        impulse=np.ascontiguousarray(np.concatenate([command.impulse, loads], axis=2)),
        initial=np.ascontiguousarray(np.concatenate([command.initial, held], axis=1)),
    )


def _loads(batch: ArmBatch, scenarios: Sequence[Scenario], per_sample: int) -> tuple[Array, Array]:
    """Return the integrals (B, C + 1, 6 K) of the loads over the cells, and the loads (B, 6 K) before the start."""
    samples, count = len(scenarios[0].time), len(scenarios[0].loads)
    wrenches, before = np.zeros((len(batch), samples, count, 2, 3)), np.zeros((len(batch), count, 2, 3))
    for b, (scenario, axes) in enumerate(zip(scenarios, base_rotations(batch.arms), strict=True)):
        for k, load in enumerate(scenario.loads):
            given = load.wrenches(samples)
            first = given[0] if load.before is None else np.asarray(load.before)
            wrenches[b, :, k], before[b, k] = given.reshape(-1, 2, 3) @ axes, first.reshape(2, 3) @ axes
    held = np.repeat(wrenches[:, :-1], per_sample, axis=1).reshape(len(batch), (samples - 1) * per_sample, 6 * count)
    return np.concatenate([np.zeros_like(held[:, :1]), held.cumsum(axis=1)], axis=1), before.reshape(len(batch), -1)
