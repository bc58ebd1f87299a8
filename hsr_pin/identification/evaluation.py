"""What a hypothesis predicts for an experiment, and how far that is from what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.sensitivity import sensitivities
from hsr_pin.trajectory import Array

#: Difference for derivatives over a parameter's scale: wide enough to average over the corners of sticking and stopping laws.
FRACTION = 0.02


@dataclass(frozen=True, eq=False)
class Prediction:
    """Marker positions of one run.

    Attributes:
        positions: (T, M, 3) [m] at the measured times; NaN where the simulation failed.
        slopes: (T, M, 3, P) [m per unit] derivatives to the open parameters; None if not asked for.
    """

    positions: Array
    slopes: Array | None = None

    @property
    def failed(self) -> bool:
        """Whether the simulation ended early."""
        return not bool(np.isfinite(self.positions).all())


def predict(experiment: Experiment, hypothesis: Hypothesis, cases: Sequence[tuple[Run, Array]]) -> list[Prediction]:
    """Simulate runs, each with its own values (P,) of the open parameters, in one batch."""
    scenarios = [hypothesis.scenario(experiment, run, values) for run, values in cases]
    results = simulate_batch(scenarios, integrator=hypothesis.integrator, step=hypothesis.step)
    return [
        Prediction(at_samples(run, _padded(result.trajectory.positions, len(result.scenario.time))))
        for (run, _), result in zip(cases, results, strict=True)
    ]


def predict_with_slopes(
    experiment: Experiment, hypothesis: Hypothesis, values: Array, *, central: bool = False
) -> list[Prediction]:
    """Simulate every run at ``values`` (P,), with the derivatives to the open parameters, in one batch.

    Forward differences, or ``central`` ones at twice the price.
    """
    scenarios = [hypothesis.scenario(experiment, run, values) for run in experiment.runs]
    names: dict[str, None] = {}
    for run in experiment.runs:
        for name in hypothesis.free:
            counterpart = hypothesis.counterpart(name, experiment, run)
            if counterpart:
                names[counterpart[0]] = None
    results, slopes = sensitivities(
        scenarios, list(names), fraction=FRACTION, central=central, integrator=hypothesis.integrator, step=hypothesis.step
    )
    predictions = []
    for run, result, slope in zip(experiment.runs, results, slopes, strict=True):
        positions = _padded(result.trajectory.positions, len(result.scenario.time))
        chained = np.zeros((*positions.shape, len(hypothesis.free)))
        for p, name in enumerate(hypothesis.free):
            counterpart = hypothesis.counterpart(name, experiment, run)
            if counterpart:
                chained[..., p] = counterpart[1] * slope[..., list(names).index(counterpart[0])]
        predictions.append(Prediction(at_samples(run, positions), at_samples(run, np.nan_to_num(chained))))
    return predictions


def residuals(experiment: Experiment, predictions: Sequence[Prediction]) -> list[Array]:
    """For each run (T, M, 3) [m] predicted minus measured; NaN in gaps, the arm's length where a simulation failed."""
    worst = experiment.dataset.length
    return [
        np.where(np.isfinite(run.measured), np.nan_to_num(p.positions - run.measured, nan=worst), np.nan)
        for run, p in zip(experiment.runs, predictions, strict=True)
    ]


def rms(residual: Sequence[Array]) -> float:
    """RMS distance [m] over all runs, samples and markers."""
    return float(np.sqrt(np.concatenate([squared_distance(r) for r in residual]).mean()))


def squared_distance(residual: Array) -> Array:
    """(n,) [m^2] of every marker at every sample at which it was seen."""
    squares = (residual**2).sum(axis=-1).ravel()
    return np.asarray(squares[np.isfinite(squares)])


def _padded(positions: Array, samples: int) -> Array:
    missing = samples - len(positions)
    return np.concatenate([positions, np.full((missing, *positions.shape[1:]), np.nan)]) if missing else positions


def at_samples(run: Run, values: Array) -> Array:
    """Values (T + 1, ...) on a grid that leads the samples by ``run.lead`` steps, interpolated (cubic) to the T samples."""
    f = run.lead
    if f == 0:
        return values
    nodes = np.arange(-1, 3)
    weights = [np.prod([(f - m) / (n - m) for m in nodes if m != n]) for n in nodes]
    # before the start the arm rests: the sample there equals the first
    padded = np.concatenate([values[:1], values, 2 * values[-1:] - values[-2:-1]])
    count = len(run.time)
    return np.asarray(sum(w * padded[k : k + count] for k, w in enumerate(weights)))
