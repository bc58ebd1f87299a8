"""What drives arms in space over time: two components of torque, and loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.robot.space import base_rotations
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


def with_loads(columns: Columns, scenarios: Sequence[Scenario], command: Delivered) -> Delivered:
    """The torques that arrive (complex) as two numbers, and beside them the scenarios' loads in the axes of the bases."""
    samples, per_sample = len(scenarios[0].time), command.per_sample
    axes = base_rotations(columns.arms)
    loads, before = np.zeros((2, len(columns), samples, len(scenarios[0].loads), 2, 3))
    for b, scenario in enumerate(scenarios):
        for k, load in enumerate(scenario.loads):
            wrenches = load.wrenches(samples)
            loads[b, :, k] = (wrenches.reshape(-1, 2, 3)) @ axes[b]
            first = wrenches[0] if load.before is None else np.asarray(load.before)
            before[b, 0, k] = first.reshape(2, 3) @ axes[b]
    held = np.repeat(loads[:, :-1], per_sample, axis=1).reshape(len(columns), (samples - 1) * per_sample, -1)
    impulse = np.concatenate([np.zeros((len(columns), 1, held.shape[2])), held.cumsum(axis=1)], axis=1)
    whole = np.concatenate([_parts(command.impulse), impulse], axis=2)
    start = np.concatenate([_parts(command.initial), before[:, 0].reshape(len(columns), -1)], axis=1)
    return replace(command, impulse=np.ascontiguousarray(whole), initial=np.ascontiguousarray(start))


def _parts(torque: Array) -> Array:
    """(..., 2) of complex numbers (...)."""
    return np.stack([torque.real, torque.imag], axis=-1)
