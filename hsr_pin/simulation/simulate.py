"""One scenario: a batch of one."""

from __future__ import annotations

from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.integrator import TOLERANCE
from hsr_pin.simulation.motion import Dynamics, usual
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
        scenario: the arm, what drives it, how it starts.
        dynamics: "aba" or "rnea" over Pinocchio, which start at once; or "compiled", a hundred times as fast for many. Default:
            "aba", for an arm in space "rnea", for more than 64 links "compiled".
        integrator: a name from ``hsr_pin.simulation.integrator``.
        tolerance: [m] of the tip, that a step may be in error by.
        step: [s] steps of at most this length in place of a tolerance.
        raise_on_failure: False gives the partial result back with its ``outcome`` instead.

    Raises:
        SimulationFailure: the arm left its bending limit, the motion diverged, or there is no pose to start from.
    """
    dynamics = dynamics or usual(scenario.arm.links, scenario.arm.bending == "space")
    (result,) = simulate_batch([scenario], dynamics=dynamics, integrator=integrator, tolerance=tolerance, step=step)
    return result.raise_on_failure() if raise_on_failure else result
