"""Fitted models and workers that were never simulated: what they leave of a gap is set by hand."""

from dataclasses import dataclass, field, replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate, Guess
from hsr_pin.diagnosis.search import Thresholds
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral, with_values
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Hypothesis

#: Noise floor and arm length [m] of every fabricated recording: 0.3 mm a coordinate.
NOISE, LENGTH = 3e-4, 0.24
THRESHOLDS = Thresholds.of(np.sqrt(3) * NOISE, LENGTH)
TRIALS, SAMPLES = 6, 60

_generator = np.random.default_rng(0)
_noise = NOISE * _generator.standard_normal((TRIALS, SAMPLES, 1, 3))
_noise -= _noise.mean(axis=1, keepdims=True)  # so that what lasts is the gap alone


def heldout(*gaps):
    """For each trial the same noise, and a constant distance [m] beside it; one number stands for all trials."""
    sizes = gaps * TRIALS if len(gaps) == 1 else gaps
    return tuple(noise + np.array([size, 0.0, 0.0]) for noise, size in zip(_noise, sizes, strict=True))


def fitted(effects, gap=0.0, errors=None):
    """A fit of a model with effects (names, or effects with options).

    ``errors``: name -> about how many standard errors its amplitude is away from neutral; default: a thousand.
    """
    laws = [neutral(EFFECTS[effect]) if isinstance(effect, str) else effect for effect in effects]
    laws = [with_values(law, **{p.name: p.neutral + p.scale for p in law.parameters() if p.amplitude}) for law in laws]
    hypothesis = Hypothesis().with_effects(*laws)
    facts = hypothesis.parameters
    slopes = np.random.default_rng(1).standard_normal((TRIALS, SAMPLES, 1, 3, len(facts))) * 1e-2
    slopes /= [fact.scale for fact in facts]
    for place, fact in enumerate(facts):
        slopes[..., place] *= (errors or {}).get(fact.name.split(".")[0], 1e3) / 1e3
    residuals = heldout(gap)
    weights = tuple(np.full(part.shape, 1 / NOISE) for part in residuals)
    defects = tuple(np.zeros_like(part) for part in residuals)
    return Fit(hypothesis, hypothesis.start, residuals, tuple(slopes), weights, defects, True, 1)


def candidate(*effects, gap=0.0, errors=None):
    """A fitted model that leaves this distance [m] (one for all trials, or one for each) on held-out trials."""
    gaps = gap if isinstance(gap, tuple) else (gap,)
    return Candidate(fitted(effects, float(np.sqrt(np.mean(np.square(gaps)))), errors), heldout(*gaps))


@dataclass
class FakeWorkers:
    """Answers from a table instead of simulating.

    Attributes:
        gaps: what is left [m] with each set of effects (names joined by "+"), in all trials or in each; a set that is not in the
            table leaves what its largest subset leaves.
        quick: what quick fits leave, in the same form; default: the same.
        alike: gain that is predicted for another reading of a law, over that for the first.
        errors: name -> standard errors that its amplitude is away from neutral, in every fit.
        finished: keys of the models that were fitted, in the order in which they were asked for.
    """

    gaps: dict
    quick: dict | None = None
    errors: dict | None = None
    alike: float = 0.999
    finished: list = field(default_factory=list)

    def __post_init__(self):
        self.gaps, self.quick = map(_by_names, (self.gaps, self.quick or self.gaps))

    def gap(self, effects, quick=False):
        names, gaps = frozenset(effect.name for effect in effects), self.quick if quick else self.gaps
        known = [(len(key), -np.mean(np.square(gap)), key) for key, gap in gaps.items() if key <= names]
        return gaps[max(known, key=lambda item: item[:2])[2]]

    def guess(self, base, effects):
        before = np.mean(np.square(self.gap(base.fit.hypothesis.effects)))
        guesses = []
        for effect in effects:
            hypothesis = base.fit.hypothesis.with_effects(effect)
            after = np.mean(np.square(self.gap(hypothesis.effects)))
            reading = effect.variants().index(dict(effect.options))
            less = self.alike if reading else 1.0  # no two readings of a law do quite the same
            guesses.append(Guess(hypothesis, (hypothesis.start,), less * max(0.0, 1 - after / before)))
        return guesses

    def glance(self, tasks):
        return [self._fit(guess.hypothesis, quick=True) for _, guess in tasks]

    def finish(self, quick):
        self.finished += ["+".join(sorted(effect.name for effect in fit.hypothesis.effects)) for _, fit in quick]
        return [
            replace(candidate(*fit.hypothesis.effects, gap=self.gap(fit.hypothesis.effects)), fit=self._fit(fit.hypothesis))
            for _, fit in quick
        ]

    def _fit(self, hypothesis, quick=False):
        return fitted(hypothesis.effects, float(np.sqrt(np.mean(np.square(self.gap(hypothesis.effects, quick))))), self.errors)


def _by_names(table):
    return {frozenset(filter(None, key.split("+"))): gap for key, gap in table.items()}
