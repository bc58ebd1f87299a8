"""The paper's own procedure for its parameters, for comparison with the fit: five steps, and C by a grid search.

Choose the number of links n; map the pressures to a torque; simulate; change the joints' k and c according to the deviation
between simulated and measured motion; iterate. The paper does not define the size of the changes. Here, k follows the deviations
at three stiffnesses, and c is the best value of a grid ("brute force").
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hsr_pin.identification.evaluation import predict
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.inference.residuals import residuals, rms
from hsr_pin.robot.specification import Placement
from hsr_pin.trajectory import Array

#: Number of grid points, which are factors on the best C so far; the grid shrinks from pass to pass.
GRID = 9
_WIDEST, _SHRINK = 8.0, 0.5
#: The procedure ends after a pass that changes k and c by less than this share.
_DONE = 0.005
_PASSES = 8


@dataclass(frozen=True)
class Pass:
    """The result of one pass through the steps.

    Attributes:
        keq_scale, damping_scale: the values at its end.
        rms: RMS distance of all markers with these values [m].
    """

    keq_scale: float
    damping_scale: float
    rms: float


@dataclass(frozen=True, eq=False)
class PaperProcedure:
    """The result of the paper's procedure.

    Attributes:
        links, placement: the chain; its discretisation error is not corrected, so the values are specific to it.
        passes: the passes, starting with the declared values.
        grid: (2, G) the last grid: factors on the declared C, and RMS distances [m].
        simulations: number of simulations of the dataset.
    """

    links: int
    placement: Placement
    passes: tuple[Pass, ...]
    grid: Array
    simulations: int

    @property
    def last(self) -> Pass:
        """The last pass."""
        return self.passes[-1]


def paper_procedure(
    experiment: Experiment,
    *,
    links: int = 4,
    placement: Placement = "base",
    tell: Callable[[str], None] = lambda line: None,
) -> PaperProcedure:
    """Carry out the paper's procedure.

    Args:
        experiment: the recordings.
        links: number of links; default: the paper's.
        placement: placement of the joints; default: the paper's.
        tell: function that is called with a line at each pass.
    """
    trials = _Trials(experiment, Hypothesis((), ("keq_scale", "damping_scale"), links, placement))
    keq, damping, width = 1.0, 1.0, _WIDEST
    passes = [Pass(keq, damping, trials.errors([(keq, damping)])[0])]
    grid = np.empty((2, 0))
    for number in range(_PASSES):
        tell(f"pass {number + 1}: Keq times {keq:.4g}, C times {damping:.4g}")
        before = (keq, damping)
        keq = _by_deviation(trials, keq, damping, step=0.1 * _SHRINK**number)
        factors = damping * np.geomspace(1 / width, width, GRID)
        grid = np.array([factors, trials.errors([(keq, factor) for factor in factors])])
        damping, width = float(factors[np.argmin(grid[1])]), width**_SHRINK
        passes.append(Pass(keq, damping, float(grid[1].min())))
        settled = width ** (2 / (GRID - 1)) - 1 < _DONE  # the grid is fine enough
        if settled and max(abs(keq / before[0] - 1), abs(damping / before[1] - 1)) < _DONE:
            break
    return PaperProcedure(links, placement, tuple(passes), grid, trials.simulations)


class _Trials:
    """Simulates all trials with given factors on Keq and C, and counts the simulations."""

    def __init__(self, experiment: Experiment, hypothesis: Hypothesis) -> None:
        self._experiment, self._hypothesis = experiment, hypothesis
        self.simulations = 0

    def errors(self, pairs: list[tuple[float, float]]) -> list[float]:
        """Return the RMS distance [m] for each pair of factors; the arm's length if a simulation fails."""
        runs = self._experiment.runs
        predictions = predict(self._experiment, self._hypothesis, [(run, np.array(pair)) for pair in pairs for run in runs])
        self.simulations += len(pairs)
        parts = [predictions[k * len(runs) : (k + 1) * len(runs)] for k in range(len(pairs))]
        return [rms(residuals(self._experiment, part)) for part in parts]


def _by_deviation(trials: _Trials, keq: float, damping: float, step: float) -> float:
    """Return the stiffness at the minimum of the parabola through the deviations at three stiffnesses."""
    factors = keq * np.array([1 - step, 1.0, 1 + step])
    left, middle, right = np.square(trials.errors([(factor, damping) for factor in factors]))
    bend = left - 2 * middle + right
    if bend <= 0:
        return float(factors[np.argmin([left, middle, right])])
    return float(keq * (1 + step * np.clip((left - right) / (2 * bend), -2.0, 2.0)))
