"""The benchmark problem in hsr_pin, for a batch of arms.

Bodies, springs and the torque after the actuator are set up beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from problem import SAMPLE, TORQUE, times

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.integrator import ORDERS, Integrator
from hsr_pin.simulation.motion import Engine
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.trajectory import Array

#: Plain Euler is not among them: it knows nothing of its error.
METHODS = tuple(name for name in ORDERS if name != "euler")
#: Tolerances of a step [m of the tip], 12 % apart.
TOLERANCES = tuple(0.02 * 10 ** (-k / 20) for k in range(100))


class Ours:
    """A solver by hsr_pin.

    Args:
        arms: arms with equal ``links``.
        method: integrator; each arm has its own steps.
        sample: time between samples [s].
        threads: number of threads that share the arms.
    """

    def __init__(self, arms: Sequence[ArmSpecification], method: Integrator, sample: float = SAMPLE, threads: int = 1) -> None:
        self.method, self.setting = method, f"{method.name}, tolerance {1e3 * method.tolerance:.2g} mm"
        time, start = times(sample), Pose(np.zeros(arms[0].links))
        torque = np.full((len(time), len(arms)), TORQUE)
        batch = ArmBatch.of([Scenario(arm, time, torque[:, 0], start) for arm in arms])
        self._engine = engine = Engine(batch, "compiled")
        command = engine.deliver(torque, torque[0], sample, substeps=method.substeps(sample))
        q, v = np.zeros((2, len(arms), arms[0].links))
        self._given = engine.loaded(q, v), command, len(time), method, np.ones(len(arms), dtype=bool), threads

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        return self._engine.run_separately(*self._given).angles


def tolerant(arms: Sequence[ArmSpecification], name: str, tolerance: float, *, sample: float = SAMPLE, threads: int = 1) -> Ours:
    """Return the solver for a method with adaptive steps at a tolerance [m]."""
    return Ours(arms, Integrator(name, tolerance), sample, threads)
