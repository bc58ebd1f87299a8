"""How far a hypothesis is from an experiment, as a function of its open parameters over their scales."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.identification.evaluation import Prediction, predict, predict_with_slopes, residuals
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.trajectory import Array

#: The chain and step that stand for the continuous arm: against them the fitted, coarser chain is corrected.
FINE_LINKS, FINE_STEP = 20, 0.005


class Misfit:
    """Weighted residuals and their derivatives, for least squares; what was simulated last is kept.

    Args:
        experiment: what to fit to.
        hypothesis: the model and what is open in it.
        defects: for each run (T, M, 3) [m] what the hypothesis' coarse chain is known to get wrong; default: nothing.
        weights: for each run (T, M, 3) [1/m], zero in gaps; default: one over the noise floor.
    """

    def __init__(
        self,
        experiment: Experiment,
        hypothesis: Hypothesis,
        defects: Sequence[Array] | None = None,
        weights: Sequence[Array] | None = None,
    ) -> None:
        self.experiment, self.hypothesis = experiment, hypothesis
        facts = hypothesis.parameters
        self.scale = np.array([fact.scale for fact in facts])
        self.lower = np.array([fact.lower for fact in facts]) / self.scale
        self.upper = np.array([fact.upper for fact in facts]) / self.scale
        self.defects = [np.zeros(run.measured.shape) for run in experiment.runs] if defects is None else list(defects)
        known = [np.where(np.isfinite(run.measured), 1 / experiment.noise[:, None], 0.0) for run in experiment.runs]
        self.weights = known if weights is None else list(weights)
        self.evaluations = 0
        self._seen = [weight > 0 for weight in self.weights]
        self._at: Array | None = None

    def predictions(self, x: Array) -> list[Prediction]:
        """Of the coarse chain, with forward differences."""
        if self._at is None or not np.array_equal(self._at, x):
            self._predictions = predict_with_slopes(self.experiment, self.hypothesis, x * self.scale)
            self._at = np.array(x)
            self.evaluations += 1
        return self._predictions

    def missed(self, x: Array) -> list[Array]:
        """For each run (T, M, 3) [m] predicted, with the defects added, minus measured."""
        plain = residuals(self.experiment, self.predictions(x))
        return [residual + defect for residual, defect in zip(plain, self.defects, strict=True)]

    def residual(self, x: Array) -> Array:
        """(n,) weighted, without gaps."""
        parts = zip(self.missed(x), self.weights, self._seen, strict=True)
        return np.concatenate([(residual * weight)[seen] for residual, weight, seen in parts])

    def jacobian(self, x: Array) -> Array:
        """(n, P) derivatives of :meth:`residual`."""
        parts = zip(self.predictions(x), self.weights, self._seen, strict=True)
        rows = [(p.slopes * w[..., None])[seen] for p, w, seen in parts if p.slopes is not None]
        return np.asarray(np.concatenate(rows) * self.scale)

    def correct(self, x: Array) -> None:
        """Take fine minus coarse prediction at ``x`` as the coarse chain's defect, where both can be simulated."""
        fine = self.hypothesis.finer(FINE_LINKS, FINE_STEP)
        exact = predict(self.experiment, fine, [(run, x * self.scale) for run in self.experiment.runs])
        self.defects = [
            old if f.failed or c.failed else f.positions - c.positions
            for old, f, c in zip(self.defects, exact, self.predictions(x), strict=True)
        ]
