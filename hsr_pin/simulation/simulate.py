"""The simulation of a single scenario."""

from __future__ import annotations

from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.integrator import TOLERANCE
from hsr_pin.simulation.motion import Dynamics, default_dynamics
from hsr_pin.simulation.result import SimulationResult
from hsr_pin.simulation.scenario import Scenario


def simulate(
    scenario: Scenario,
    *,
    dynamics: Dynamics | None = None,
    integrator: str | None = None,
    tolerance: float = TOLERANCE,
    step: float | None = None,
    raise_on_failure: bool = True,
) -> SimulationResult:
    """Simulate one scenario.

    Args:
        scenario: the arm, its command and its initial state.
        dynamics: "aba" or "rnea" with Pinocchio, which start immediately, or "compiled", which is a hundred times as fast for
            many scenarios. Default: "aba", for an arm in space "rnea", for more than 64 links or among obstacles
            "compiled".
        integrator: a name from ``hsr_pin.simulation.integrator``.
        tolerance: largest error of a step, at the tip [m].
        step: largest step length [s], used instead of a tolerance.
        raise_on_failure: whether a failure raises an error; otherwise the partial result is returned with its ``outcome``.

    Raises:
        SimulationFailure: the arm exceeded its bending limit, the motion diverged, or there is no initial equilibrium.
    """
    dynamics = dynamics or default_dynamics(scenario.arm, scenario.effects)
    (result,) = simulate_batch([scenario], dynamics=dynamics, integrator=integrator, tolerance=tolerance, step=step)
    return result.raise_on_failure() if raise_on_failure else result
