"""How far a hypothesis is from an experiment, as a function of its open parameters over their scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.identification.evaluation import Prediction, predict_with_slopes, residuals
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.nuisance import Eliminated, believed, prices, taken_out
from hsr_pin.trajectory import Array

#: No model of an arm is truer than this share of its length: markers that are seen with less noise than that weigh the same.
TRUEST = 5e-4


def floor(experiment: Experiment) -> Array:
    """(M,) [m] what noise and the truest of models leave of a coordinate of each marker."""
    return np.hypot(experiment.noise, TRUEST * experiment.dataset.length)


class Misfit:
    """Weighted residuals and their derivatives, for least squares; what was simulated last is kept.

    Args:
        experiment: what to fit to.
        hypothesis: the model and what is open in it.
        weights: for each run (T, M, A) [1/m], zero in gaps; default: one over what noise and the truest of
            models leave.
    """

    def __init__(self, experiment: Experiment, hypothesis: Hypothesis, weights: Sequence[Array] | None = None) -> None:
        self.experiment, self.hypothesis = experiment, hypothesis
        self.scale = hypothesis.scale
        self.lower, self.upper = (bound / self.scale for bound in hypothesis.bounds)
        known = [np.where(np.isfinite(run.compared), 1 / floor(experiment)[:, None], 0.0) for run in experiment.runs]
        self.weights = known if weights is None else list(weights)
        self.evaluations = 0
        self._lasting = experiment.lasting
        self._seen = [weight > 0 for weight in self.weights]
        self._at: tuple[bytes, tuple[bool, ...]] | None = None
        self._eliminated: list[Eliminated] = []
        self._gripped = (False,) * len(experiment.runs)

    @property
    def gripped(self) -> tuple[bool, ...]:
        """For each run whether a hand's hold is among the numbers that belong to it, as :meth:`hold` found it last."""
        return self._gripped

    def predictions(self, x: Array) -> list[Prediction]:
        """With one-sided differences."""
        if self._at != (x.tobytes(), self._gripped):
            self._predictions = predict_with_slopes(self.experiment, self.hypothesis, x * self.scale, gripped=self._gripped)
            self._at = x.tobytes(), self._gripped
            self.evaluations += 1
        return self._predictions

    def missed(self, x: Array) -> list[Array]:
        """For each run (T, M, A) [m] predicted minus measured."""
        return residuals(self.experiment, self.predictions(x))

    def residual(self, x: Array) -> Array:
        """(n,) weighted, without gaps, what belongs to the trials eliminated."""
        parts = zip(self.missed(x), self.weights, self._eliminated_at(x), self._seen, strict=True)
        return np.concatenate([without((residual * weight)[seen]) for residual, weight, without, seen in parts])

    def jacobian(self, x: Array) -> Array:
        """(n, P) derivatives of :meth:`residual`."""
        parts = zip(self.predictions(x), self.weights, self._eliminated_at(x), self._seen, strict=True)
        rows = [without((p.slopes * w[..., None])[seen]) for p, w, without, seen in parts if p.slopes is not None]
        return np.asarray(np.concatenate(rows) * self.scale)

    def hold(self, x: Array) -> bool:
        """Take what the numbers of the trials make of the residuals, and their prices, from here; whether there are any.

        Were it to change from point to point, the derivatives would lack that.
        """
        if self.experiment.hand and any(run.start_pose is not None for run in self.experiment.runs):
            self._gripped = self._held_on(x)
        price = prices(self.left(x), self.weights, self._lasting)
        parts = zip(self.nuisance(x), self.weights, self._seen, strict=True)
        bases = [(nuisance * w[..., None])[seen] / price[: nuisance.shape[-1]] for nuisance, w, seen in parts]
        self._eliminated = [Eliminated.of(basis) for basis in bases]
        return any(basis.shape[1] for basis in bases)

    def _held_on(self, x: Array) -> tuple[bool, ...]:
        """For each run whether it shows that a hand still held the arm after its release; what was simulated for it serves on."""
        self._gripped = (True,) * len(self.experiment.runs)
        whole, seen = self.nuisance(x), self._lasting + len(self.experiment.axes)
        left = taken_out(self.missed(x), self.weights, [each[..., :seen] for each in whole], self._lasting)
        price = float(prices(left, self.weights, self._lasting)[seen])
        answers = []
        for residual, weight, known, nuisance in zip(left, self.weights, self._seen, whole, strict=True):
            hold = (nuisance[..., seen:] * weight[..., None])[known] / price
            answers.append(hold.shape[1] > 0 and believed((residual * weight)[known], hold, price))
        self._predictions = [
            prediction if held else replace(prediction, nuisance=nuisance[..., :seen])
            for prediction, nuisance, held in zip(self._predictions, whole, answers, strict=True)
        ]
        self._at = x.tobytes(), tuple(answers)
        return tuple(answers)

    def _eliminated_at(self, x: Array) -> list[Eliminated]:
        """For each run how its own numbers are taken out, as :meth:`hold` found it last; found here if it never was."""
        if not self._eliminated:
            self.hold(x)
        return self._eliminated

    def left(self, x: Array) -> list[Array]:
        """For each run (T, M, A) [m] predicted minus measured, without what belongs to the trial."""
        return taken_out(self.missed(x), self.weights, self.nuisance(x), self._lasting)

    def nuisance(self, x: Array) -> list[Array]:
        """For each run (T, M, A, K) [m] what one standard deviation of each number of the trial's own makes."""
        return [p.nuisance for p in self.predictions(x) if p.nuisance is not None]
