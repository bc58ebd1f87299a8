"""Fitted models and a crew that never simulated: what they leave of a gap is set by hand."""

from dataclasses import dataclass, field, replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate, Guess
from hsr_pin.diagnosis.support import Support
from hsr_pin.diagnosis.thresholds import Thresholds
from hsr_pin.effects import effect_named
from hsr_pin.effects.effect import neutral, with_values
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import PLAIN, Hypothesis, Part

#: Noise floor and arm length [m] of every fabricated recording: 0.3 mm a coordinate.
NOISE, LENGTH = 3e-4, 0.24
THRESHOLDS = Thresholds.of(np.sqrt(2) * NOISE, LENGTH)
TRIALS, SAMPLES = 6, 60

_generator = np.random.default_rng(0)
_noise = NOISE * _generator.standard_normal((TRIALS, SAMPLES, 1, 2))
_noise -= _noise.mean(axis=1, keepdims=True)  # so that what lasts is the gap alone


def heldout(*gaps):
    """For each trial the same noise, and a constant distance [m] beside it; one number stands for all trials."""
    sizes = gaps * TRIALS if len(gaps) == 1 else gaps
    return tuple(noise + np.array([size, 0.0]) for noise, size in zip(_noise, sizes, strict=True))


def fitted(parts, gap=0.0, errors=None):
    """A fit of a model with parts (names of effects or of the arm's numbers, effects with options, or parts).

    ``errors``: name -> about how many standard errors its amplitude is away from neutral; default: a thousand.
    """
    hypothesis = Hypothesis()
    for part in map(_part, parts):
        hypothesis = hypothesis.with_part(part)
    facts = hypothesis.parameters
    slopes = np.random.default_rng(1).standard_normal((TRIALS, SAMPLES, 1, 2, len(facts))) * 1e-2
    slopes /= [fact.scale for fact in facts]
    for place, fact in enumerate(facts):
        slopes[..., place] *= (errors or {}).get(fact.name.split(".")[0], 1e3) / 1e3
    values = np.array([fact.neutral + fact.scale * (fact.name in PLAIN) for fact in facts])
    values = np.where([fact.amplitude and fact.name not in PLAIN for fact in facts], hypothesis.start, values)
    residuals = heldout(gap)
    weights = tuple(np.full(part.shape, 1 / NOISE) for part in residuals)
    nuisance = tuple(np.zeros((*part.shape, 0)) for part in residuals)
    return Fit(hypothesis, values, residuals, residuals, tuple(slopes), weights, nuisance, np.ones(3), True, 1)


def _part(given):
    """As a part of a model, an effect's amplitudes one scale away from neutral."""
    if given in PLAIN:
        return Part(given)
    part = given if isinstance(given, Part) else None
    law = part.effect if part else neutral(effect_named(given)) if isinstance(given, str) else given
    if law is None:
        return part
    law = with_values(law, **{p.name: p.neutral + p.scale for p in law.parameters() if p.amplitude})
    return Part(law.name, law, part.resized, part.opens, part.levels) if part else Part(law.name, law)


def candidate(*parts, gap=0.0, errors=None):
    """A fitted model that leaves this distance [m] (one for all trials, or one for each) on held-out trials."""
    gaps = gap if isinstance(gap, tuple) else (gap,)
    return Candidate(fitted(parts, float(np.sqrt(np.mean(np.square(gaps)))), errors), heldout(*gaps))


def supported(best, weak=(), clear=1e3):
    """Support for each part of a model, and for each of its kinds: all that there can be, or for the ``weak`` next to none."""

    def one(name, kind):
        strength = (
            {"lead": 0.05, "margin": 0.2, "frequency": 0.6, "drift": 1.0, "clear": 5.0, "rest": 0.6} if name in weak else {}
        )
        whole = {"share": 0.9, "lead": 1.0, "margin": 50.0, "frequency": 1.0, "drift": 0.05, "clear": clear, "rest": 0.02}
        return Support(name, kind, **(whole | strength))

    parts = best.fit.hypothesis.parts
    told = tuple(one(part.name, part.kind) for part in parts)
    return told, tuple(one(kind, kind) for kind in best.kinds), lambda sets: one("", "")


@dataclass
class FakeCrew:
    """Answers from a table instead of simulating.

    Attributes:
        gaps: what is left [m] with each set of effects (names joined by "+", with "@each" behind one that has a size for each
            level), in all trials or in each; a set that is not in the table leaves what its largest subset leaves.
        quick: what quick fits leave, in the same form; default: the same.
        alike: gain that is predicted for another reading of a law, over that for the first.
        unseen: names of laws that a probe shows nothing of.
        errors: name -> standard errors that its amplitude is away from neutral, in every fit.
        stuck: what a model leaves that was fitted once, where a second fit, from a larger model, gets to what ``gaps`` says.
        finished: keys of the models that were fitted, in the order in which they were asked for.
    """

    gaps: dict
    quick: dict | None = None
    errors: dict | None = None
    alike: float = 0.999
    unseen: tuple = ()
    stuck: dict = field(default_factory=dict)
    finished: list = field(default_factory=list)

    def __post_init__(self):
        self.gaps, self.quick = map(_by_names, (self.gaps, self.quick or self.gaps))

    def gap(self, parts, quick=False):
        names, gaps = frozenset(map(_called, parts)), self.quick if quick else self.gaps
        known = [(len(key), -np.mean(np.square(gap)), key) for key, gap in gaps.items() if key <= names]
        return gaps[max(known, key=lambda item: item[:2])[2]]

    @property
    def glanced(self):
        return list(range(TRIALS))

    def misfit(self, start):
        return self.gap(start.hypothesis.parts) if _joined(start) in self.stuck else float("inf")

    def guess_each(self, asked):
        return [self.guess(*each) for each in asked]

    def guess(self, base, parts):
        before = np.mean(np.square(self.gap(base.fit.hypothesis.parts)))
        guesses = []
        for part in parts:
            hypothesis = base.fit.hypothesis.with_part(part)
            after = np.mean(np.square(self.gap(hypothesis.parts)))
            readings = [
                (options, resized) for options in (part.effect.variants() if part.effect else ({},)) for resized in (False, True)
            ]
            own = (dict(part.effect.options) if part.effect else {}, part.resized)
            less = self.alike ** readings.index(own)  # no two readings of a law do quite the same
            gain = 0.0 if part.name in self.unseen else less * max(0.0, 1 - after / before)
            guesses.append(Guess(hypothesis, (hypothesis.start,), gain))
        return guesses

    def glance(self, tasks):
        return [self._fit(guess.hypothesis, quick=True) for _, guess in tasks]

    def finish(self, starts):
        answers = []
        for fit in starts:
            first = _joined(fit) not in self.finished and _joined(fit) in self.stuck
            gap = self.stuck[_joined(fit)] if first else self.gap(fit.hypothesis.parts)
            self.finished.append(_joined(fit))
            answers.append(replace(candidate(*fit.hypothesis.parts, gap=gap), fit=self._fit(fit.hypothesis, gap)))
        return answers

    def _fit(self, hypothesis, gap=None, quick=False):
        left = self.gap(hypothesis.parts, quick) if gap is None else gap
        return fitted(hypothesis.parts, float(np.sqrt(np.mean(np.square(left)))), self.errors)


def _joined(fit):
    return "+".join(sorted(map(_called, fit.hypothesis.parts)))


def _called(part):
    return part.name + "@each" * bool(part.levels)


def _by_names(table):
    return {frozenset(filter(None, key.split("+"))): gap for key, gap in table.items()}
