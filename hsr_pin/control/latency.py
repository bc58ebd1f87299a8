"""Measurement of the computing time of a step on this machine."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter_ns

import numpy as np

from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.simulation.integrator import STEP


@dataclass(frozen=True)
class Latency:
    """Computing time of one call of :meth:`ArmSimulator.step`.

    Attributes:
        minimum, median, worst: times [s]; ``worst`` is the 99th percentile.
    """

    minimum: float
    median: float
    worst: float


def step_latency(simulator: ArmSimulator, dt: float = STEP, steps: int = 2000) -> Latency:
    """Measure ``steps`` steps of ``dt`` [s] under a changing torque, after a reset and a warm-up step."""
    simulator.reset()
    simulator.step(0.0, dt=dt)
    largest = 0.25 * min(abs(bound) for bound in simulator.torque_range)
    times = []
    for torque in (largest * np.sin(0.05 * np.arange(steps))).tolist():
        start = perf_counter_ns()
        simulator.step(torque, dt=dt)
        times.append(perf_counter_ns() - start)
    return Latency(*(1e-9 * np.percentile(times, [0, 50, 99])).tolist())
