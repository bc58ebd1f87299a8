"""How far a model is from recordings, as a function of its open parameters over their scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.inference.own_numbers import Eliminated, believed, prices, taken_out
from hsr_pin.inference.problem import Hypothesis, Prediction, Problem
from hsr_pin.inference.residuals import residuals
from hsr_pin.trajectory import Array


def scaled(hypothesis: Hypothesis) -> tuple[Array, Array, Array]:
    """(P,) each: the scales of the open parameters, and their bounds over these."""
    facts = hypothesis.parameters
    scale = np.array([fact.scale for fact in facts])
    return scale, np.array([fact.lower for fact in facts]) / scale, np.array([fact.upper for fact in facts]) / scale


class Misfit:
    """Weighted residuals and their derivatives, for least squares; what was simulated last is kept.

    Args:
        problem: recordings, and who simulates them.
        hypothesis: the model and what is open in it.
        weights: for each run (T, M, A), zero in gaps; default: one over what noise and the truest of
            models leave.
    """

    def __init__(self, problem: Problem, hypothesis: Hypothesis, weights: Sequence[Array] | None = None) -> None:
        self.problem, self.hypothesis = problem, hypothesis
        self.scale, self.lower, self.upper = scaled(hypothesis)
        known = [np.where(np.isfinite(run.compared), 1 / problem.floor[:, None], 0.0) for run in problem.runs]
        self.weights = known if weights is None else list(weights)
        self.evaluations = 0
        self._seen = [weight > 0 for weight in self.weights]
        self._at: tuple[bytes, tuple[bool, ...]] | None = None
        self._own = False
        self._eliminated: list[Eliminated] = []
        self._shown = (False,) * len(problem.runs)

    @property
    def shown(self) -> tuple[bool, ...]:
        """For each run whether it shows the numbers that it may have, as :meth:`hold` found it last."""
        return self._shown

    def predictions(self, x: Array, *, own: bool = False) -> list[Prediction]:
        """With one-sided differences, and with what the numbers of the trials make of them where that is asked for."""
        if self._at != (x.tobytes(), self._shown) or (own and not self._own):
            self._predictions = self.problem.predict_with_slopes(self.hypothesis, x * self.scale, shown=self._shown, own=own)
            self._at, self._own = (x.tobytes(), self._shown), own
            self.evaluations += 1
        return self._predictions

    def missed(self, x: Array) -> list[Array]:
        """For each run (T, M, A) predicted minus measured."""
        return residuals(self.problem, self.predictions(x))

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
        if any(map(self.problem.shown, self.problem.runs)):
            self._shown = self._shows(x)
        price = prices(self.left(x), self.weights, self.problem.doubted)
        parts = zip(self.nuisance(x), self.weights, self._seen, strict=True)
        bases = [(nuisance * w[..., None])[seen] / price[: nuisance.shape[-1]] for nuisance, w, seen in parts]
        self._eliminated = [Eliminated.of(basis) for basis in bases]
        return any(basis.shape[1] for basis in bases)

    def _shows(self, x: Array) -> tuple[bool, ...]:
        """For each run whether it shows the numbers that count only then; what was simulated for it serves on."""
        self._shown = (True,) * len(self.problem.runs)
        whole, seen = self.nuisance(x), self.problem.seen
        left = taken_out(self.missed(x), self.weights, [each[..., :seen] for each in whole], self.problem)
        price = float(prices(left, self.weights, self.problem.doubted)[seen])
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
        """For each run (T, M, A) predicted minus measured, without what belongs to the trial."""
        return taken_out(self.missed(x), self.weights, self.nuisance(x), self.problem)

    def nuisance(self, x: Array) -> list[Array]:
        """For each run (T, M, A, K) what one standard deviation of each number of the trial's own makes."""
        return [p.nuisance for p in self.predictions(x, own=True) if p.nuisance is not None]
