"""The problem in hsr_pin, any number of arms side by side. Set up beforehand: models, coefficients, Pinocchio's workspaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from problem import SAMPLE, TORQUE, times

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.columns import Columns, shape_of
from hsr_pin.simulation.integrators import INTEGRATORS, integrator
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.simulation.stepper import Stepper, starting_state
from hsr_pin.trajectory import Array

#: Plain Euler is not among them: at 0.1 mm it takes ten times as long as any other.
METHODS = tuple(name for name in INTEGRATORS if name != "euler")


class Ours:
    """A solver.

    Args:
        arms: of equal ``links``.
        method: the integrator.
        substeps: its steps per sample.
        sample: time between samples [s].
        nominal: the arm whose springs and dampers the integrator treats implicitly; default: the first.
    """

    def __init__(
        self,
        arms: Sequence[ArmSpecification],
        method: str,
        substeps: int,
        sample: float = SAMPLE,
        nominal: ArmSpecification | None = None,
    ) -> None:
        self.method, self.substeps, self.setting = method, substeps, f"{method}, {1e3 * sample / substeps:.3g} ms"
        self._times = times(sample)
        command, start = np.full(len(self._times), TORQUE), Pose(np.zeros(arms[0].links))
        shared = Scenario(nominal or arms[0], self._times, command, start)
        scenarios = [Scenario(arm, self._times, command, start, implicit_as=shared) for arm in arms]
        columns = Columns(scenarios, shape_of(scenarios[0], sample / substeps))
        self._torque = np.full(len(arms), TORQUE)
        self._stepper = Stepper(columns, integrator(method), columns.step)
        self._start, _ = starting_state(columns, self._torque)

    def run(self) -> Array:
        """See `Solver`."""
        state = self._start
        angles = np.empty((len(self._times), *state.q.T.shape))
        angles[0] = state.q.T
        for n in range(1, len(angles)):
            for _ in range(self.substeps):
                state = self._stepper.advance(state, self._torque)
            angles[n] = state.q.T
        return angles
