"""Weighted residuals of a model and their derivatives, as functions of the scaled free parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.problem import Hypothesis, Prediction, Problem
from hsr_pin.inference.residuals import residuals
from hsr_pin.inference.tolerances import Tolerances
from hsr_pin.inference.trial_parameters import Eliminated, noise_inflation, supported, trial_inflation, without_trial_parameters
from hsr_pin.trajectory import Array

#: Number of times that errors of initial states and of declared numbers are estimated in turn.
_TURNS = 3


def scaled(hypothesis: Hypothesis) -> tuple[Array, Array, Array]:
    """Return the scales of the free parameters and their lower and upper bounds in these scales, (P,) each."""
    facts = hypothesis.parameters
    scale = np.array([fact.scale for fact in facts])
    return scale, np.array([fact.lower for fact in facts]) / scale, np.array([fact.upper for fact in facts]) / scale


class Misfit:
    """Weighted residuals and derivatives for least squares; the last simulation is cached.

    Args:
        problem: the recordings and their simulation.
        hypothesis: the model and its free parameters.
        weights: for each run (T, M, A), zero in gaps; default: the inverse of the floor that noise and the best model leave.
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
        self._tolerances: Tolerances | None = None
        self._errors = np.zeros(problem.tolerances(problem.runs[0]).shape[-1])
        self._conditional = (False,) * len(problem.runs)

    @property
    def conditional(self) -> tuple[bool, ...]:
        """For each run, whether its conditional trial parameters are used, as :meth:`hold` decided last."""
        return self._conditional

    def predictions(self, x: Array, *, own: bool = False) -> list[Prediction]:
        """Return the predictions with one-sided differences, and with the derivatives to trial parameters on request."""
        if self._at != (x.tobytes(), self._conditional) or (own and not self._own):
            self._predictions = self.problem.predict_with_slopes(
                self.hypothesis, x * self.scale, conditional=self._conditional, own=own
            )
            self._at, self._own = (x.tobytes(), self._conditional), own
            self.evaluations += 1
        return self._predictions

    def raw_residuals(self, x: Array) -> list[Array]:
        """Return for each run (T, M, A) predicted minus measured."""
        return residuals(self.problem, self.predictions(x))

    def residual(self, x: Array) -> Array:
        """Return the weighted residuals (n,), without gaps and with the trial parameters eliminated."""
        rows = self._whitened(x)
        return self._tolerances(rows) if self._tolerances else rows

    def jacobian(self, x: Array) -> Array:
        """Return the derivatives (n, P) of :meth:`residual`."""
        parts = zip(self.predictions(x), self.weights, self._eliminated_at(x), self._seen, strict=True)
        rows = [without((p.slopes * w[..., None])[seen]) for p, w, without, seen in parts if p.slopes is not None]
        slopes = np.asarray(np.concatenate(rows) * self.scale)
        return self._tolerances(slopes) if self._tolerances else slopes

    def errors(self, x: Array) -> Array:
        """Return the most probable errors of declared numbers (K,), in standard deviations."""
        rows = self._whitened(x)
        tolerances = self._tolerated(rows)
        return tolerances.errors(rows) if tolerances else np.zeros(0)

    def _whitened(self, x: Array) -> Array:
        """Return the weighted residuals (n,), without gaps and with the parameters of trials eliminated."""
        parts = zip(self.raw_residuals(x), self.weights, self._eliminated_at(x), self._seen, strict=True)
        return np.concatenate([without((residual * weight)[seen]) for residual, weight, without, seen in parts])

    def _tolerated(self, rows: Array) -> Tolerances | None:
        """Return the elimination of errors of declared numbers at whitened residuals (n,); None if there are none."""
        changes = [self.problem.tolerances(run) for run in self.problem.runs]
        if not changes[0].shape[-1]:
            return None
        columns = zip(changes, self.weights, self._eliminated, self._seen, strict=True)
        basis = np.concatenate([without((each * w[..., None])[known]) for each, w, without, known in columns])
        channels = np.concatenate([np.nonzero(known)[1] for known in self._seen])
        groups = [np.isin(channels, own) for own in self.problem.groups]
        return Tolerances.of(rows, basis, groups, calibrated().samples)

    def hold(self, x: Array) -> bool:
        """Freeze the elimination of trial parameters at ``x``, and return whether there are any.

        It is frozen because the derivatives do not include its change from point to point.
        """
        if any(map(self.problem.has_conditional, self.problem.runs)):
            self._conditional = self._with_conditional(x)
        nuisance, tolerances = self.nuisance(x), [self.problem.tolerances(run) for run in self.problem.runs]
        for _ in range(_TURNS if tolerances[0].shape[-1] else 1):
            raw = [r + each @ self._errors for r, each in zip(self.raw_residuals(x), tolerances, strict=True)]
            inflation = trial_inflation(raw, self.weights, nuisance, self.problem)
            parts = zip(nuisance, self.weights, self._seen, strict=True)
            bases = [(each * w[..., None])[seen] / inflation[: each.shape[-1]] for each, w, seen in parts]
            self._eliminated = [Eliminated.of(basis) for basis in bases]
            self._errors = self.errors(x)
        self._tolerances = self._tolerated(self._whitened(x))
        return any(basis.shape[1] for basis in bases)

    def _with_conditional(self, x: Array) -> tuple[bool, ...]:
        """Return for each run whether the evidence supports its conditional trial parameters; the simulation is reused."""
        self._conditional = (True,) * len(self.problem.runs)
        whole, unconditional = self.nuisance(x), self.problem.unconditional
        bases = [each[..., :unconditional] for each in whole]
        reduced_residuals = without_trial_parameters(self.raw_residuals(x), self.weights, bases, self.problem)
        inflation = float(noise_inflation(reduced_residuals, self.weights, self.problem.confounded)[unconditional])
        answers = []
        for residual, weight, known, nuisance in zip(reduced_residuals, self.weights, self._seen, whole, strict=True):
            hold = (nuisance[..., unconditional:] * weight[..., None])[known] / inflation
            answers.append(hold.shape[1] > 0 and supported((residual * weight)[known], hold, inflation))
        self._predictions = [
            prediction if held else replace(prediction, nuisance=nuisance[..., :unconditional])
            for prediction, nuisance, held in zip(self._predictions, whole, answers, strict=True)
        ]
        self._at = x.tobytes(), tuple(answers)
        return tuple(answers)

    def _eliminated_at(self, x: Array) -> list[Eliminated]:
        """Return the eliminations that :meth:`hold` froze last, or freeze them at ``x`` if there are none yet."""
        if not self._eliminated:
            self.hold(x)
        return self._eliminated

    def reduced_residuals(self, x: Array) -> list[Array]:
        """Return for each run (T, M, A) predicted minus measured, with the trial parameters eliminated."""
        return without_trial_parameters(self.raw_residuals(x), self.weights, self.nuisance(x), self.problem)

    def nuisance(self, x: Array) -> list[Array]:
        """Return for each run (T, M, A, K) the change of the prediction per prior standard deviation of each trial parameter."""
        return [p.nuisance for p in self.predictions(x, own=True) if p.nuisance is not None]
