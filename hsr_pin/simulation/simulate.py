"""One scenario: a batch of one."""

from __future__ import annotations

from hsr_pin.simulation.batch import STEP, simulate_batch
from hsr_pin.simulation.result import SimulationResult
from hsr_pin.simulation.scenario import Scenario


def simulate(
    scenario: Scenario,
    *,
    dynamics: str = "aba",
    integrator: str = "extrapolated4",
    step: float = STEP,
    raise_on_failure: bool = True,
) -> SimulationResult:
    """Simulate one scenario.

    Args:
        scenario: the arm, what drives it, how it starts.
        dynamics: "aba" or "rnea".
        integrator: a name from ``hsr_pin.simulation.integrators``.
        step: largest step [s].
        raise_on_failure: False gives the partial result back with its ``outcome`` instead.

    Raises:
        SimulationFailure: the arm left its bending limit, the motion diverged, or there is no pose to start from.
    """
    (result,) = simulate_batch([scenario], dynamics=dynamics, integrator=integrator, step=step, threads=1)
    return result.raise_on_failure() if raise_on_failure else result
