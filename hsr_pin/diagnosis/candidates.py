"""Every effect tried on an experiment: where its fit starts, where it ends, what it is worth on trials that were not fitted."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, with_values
from hsr_pin.identification.evaluation import Prediction, predict
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit, fit, stacked
from hsr_pin.identification.heldout import leave_one_out
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Amplitude with which an effect is probed, over its parameter's scale.
_PROBE = 0.5
#: No first guess goes further than this from neutral, over the parameter's scale.
_FARTHEST = 6.0


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fitted model and its error on held-out trials.

    Attributes:
        fit: of the nominal model with these effects, K and C.
        heldout: for each run (T, M, 3) [m] predicted minus measured by a model fitted to the other runs.
    """

    fit: Fit
    heldout: tuple[Array, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects, sorted."""
        return tuple(sorted(effect.name for effect in self.fit.hypothesis.effects))


@dataclass(frozen=True, eq=False)
class Guess:
    """A place to start a fit from.

    Attributes:
        hypothesis: with the effect in it.
        start: (P,) values.
        gain: share of the squared misfit that this start is predicted to take away, 0 to 1.
    """

    hypothesis: Hypothesis
    start: Array
    gain: float


def guesses(experiment: Experiment, base: Fit, effects: list[Effect]) -> list[Guess]:
    """First guesses for adding one effect to a fitted model, the best of each effect's, in the order of ``effects``.

    Each effect is probed with a small amplitude at several values of its shape parameters, all in one batch. The change it makes
    is taken as linear in the amplitude; the amplitude that fits best, with the open parameters adjusted along their known
    derivatives, and the misfit that it should leave, follow from linear least squares.
    """
    nominal = predict(experiment, base.hypothesis, [(run, base.values) for run in experiment.runs])
    best = []
    for effect in effects:
        tried = [guess for guess in _guesses(experiment, base, effect, nominal) if guess is not None]
        if tried:
            best.append(max(tried, key=lambda guess: guess.gain))
    return best


def _guesses(experiment: Experiment, base: Fit, effect: Effect, nominal: list[Prediction]) -> list[Guess | None]:
    probes = _probes(effect)
    hypothesis = base.hypothesis.with_effects(effect)
    names = [name.split(".")[1] for name in hypothesis.free[len(base.values) :]]
    starts = [np.append(base.values, [getattr(probe, name) for name in names]) for probe in probes]
    predictions = predict(experiment, hypothesis, [(run, start) for start in starts for run in experiment.runs])
    residual, slopes = stacked(base)
    count = len(experiment.runs)
    answers: list[Guess | None] = []
    for k, start in enumerate(starts):
        own = predictions[k * count : (k + 1) * count]
        if any(p.failed for p in own):
            answers.append(None)
            continue
        change = [((p.positions - n.positions) * w)[w > 0] for p, n, w in zip(own, nominal, base.weights, strict=True)]
        answers.append(_linear_guess(base, hypothesis, start, residual, slopes, np.concatenate(change)))
    return answers


def try_candidate(experiment: Experiment, guess: Guess, spread: float | None = None) -> Candidate:
    """Fit from a guess and predict every run from the others."""
    answer = fit(experiment, guess.hypothesis, start=guess.start, spread=spread)
    return Candidate(answer, tuple(leave_one_out(experiment, answer)))


def _probes(effect: Effect) -> list[Effect]:
    """The effect with a small amplitude, at a few values of each shape parameter."""
    facts = effect.parameters()
    amplitudes = {p.name: p.neutral + _PROBE * p.scale for p in facts if p.amplitude}
    shapes = [[(p.name, value) for value in _grid(p)] for p in facts if not p.amplitude]
    return [with_values(effect, **amplitudes, **dict(shape)) for shape in itertools.product(*shapes)]


def _grid(fact: Parameter) -> list[float]:
    """Four values across the bounds, evenly by ratio where they span more than a factor of five."""
    at = (0.125, 0.375, 0.625, 0.875)
    if fact.lower > 0 and fact.upper / fact.lower > 5:
        return [fact.lower * math.pow(fact.upper / fact.lower, f) for f in at]
    return [fact.lower + (fact.upper - fact.lower) * f for f in at]


def _linear_guess(base: Fit, hypothesis: Hypothesis, start: Array, residual: Array, slopes: Array, change: Array) -> Guess:
    facts, old = hypothesis.parameters, len(base.values)
    scale = np.array([fact.scale for fact in facts])
    directions = np.column_stack([slopes * scale[:old], change])
    size = np.maximum(np.linalg.norm(directions, axis=0), 1e-12)
    step = np.linalg.lstsq(directions / size, -residual, rcond=1e-6)[0] / size
    factor = float(step[-1])
    values = start.copy()
    values[:old] += scale[:old] * np.clip(step[:-1], -3.0, 3.0)
    for index in range(old, len(facts)):
        if facts[index].amplitude:
            factor = _allowed(facts[index], factor)
            values[index] = facts[index].neutral + factor * _PROBE * facts[index].scale
    left = residual + directions[:, :-1] @ step[:-1] + directions[:, -1] * factor
    lower, upper = (np.array([getattr(fact, side) for fact in facts]) for side in ("lower", "upper"))
    gain = 1 - float(left @ left) / float(residual @ residual)
    return Guess(hypothesis, np.clip(values, lower, upper), max(0.0, gain))


def _allowed(fact: Parameter, factor: float) -> float:
    """The amplitude, in probes, nearest to the wanted one that is within bounds, not far away, and not neutral itself.

    On the neutral value shape parameters have no derivative, and a fit that starts there cannot move them.
    """
    lowest = max(-_FARTHEST, (fact.lower - fact.neutral) / fact.scale) / _PROBE
    highest = min(_FARTHEST, (fact.upper - fact.neutral) / fact.scale) / _PROBE
    factor = float(np.clip(factor, lowest, highest))
    return factor if abs(factor) > 0.2 else float(np.copysign(0.2, factor if lowest < 0 else 1.0))
