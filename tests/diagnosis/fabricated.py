"""Fitted models and a fit pool without simulation: the remaining gaps are given."""

from dataclasses import dataclass, field

import numpy as np

from hsr_pin.effects import effect_named
from hsr_pin.effects.effect import neutral, with_values
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import PLAIN, Part
from hsr_pin.identification.supply import Supply
from hsr_pin.inference import Cause, Data, Model
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.estimates import Estimate
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.proposals import Proposal
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.inference.verdict import Limits

#: Noise floor and arm length [m] of every fabricated recording: 0.3 mm a coordinate.
NOISE, LENGTH = 3e-4, 0.24
LIMITS = Limits.of(np.sqrt(2) * NOISE, 5e-4 * LENGTH)
TRIALS, SAMPLES = 6, 60
DATA = Data.of_one_group(noise=NOISE**2, count=TRIALS * SAMPLES * 2)

_generator = np.random.default_rng(0)
_noise = NOISE * _generator.standard_normal((TRIALS, SAMPLES, 1, 2))
_noise -= _noise.mean(axis=1, keepdims=True)  # so that what lasts is the gap alone


def heldout(*gaps):
    """Return residuals of each trial: the same noise plus a constant distance [m]; one number stands for all trials."""
    sizes = gaps * TRIALS if len(gaps) == 1 else gaps
    return tuple(noise + np.array([size, 0.0]) for noise, size in zip(_noise, sizes, strict=True))


def fitted(parts, gap=0.0):
    """Return a fit of a model with parts (names of effects or of the arm's parameters, effects with options, or parts)."""
    hypothesis = Hypothesis()
    for part in map(_part, parts):
        hypothesis = hypothesis.with_part(part)
    facts = hypothesis.parameters
    slopes = np.random.default_rng(1).standard_normal((TRIALS, SAMPLES, 1, 2, len(facts))) * 1e-2
    slopes /= [fact.scale for fact in facts]
    values = np.array([fact.neutral + fact.scale * (fact.name in PLAIN) for fact in facts])
    values = np.where([fact.amplitude and fact.name not in PLAIN for fact in facts], hypothesis.start, values)
    residuals = heldout(gap)
    weights = tuple(np.full(part.shape, 1 / NOISE) for part in residuals)
    nuisance = tuple(np.zeros((*part.shape, 0)) for part in residuals)
    return Fit(hypothesis, values, residuals, residuals, tuple(slopes), weights, nuisance, np.ones(3), True, 1)


def _part(given):
    """Return a part of a model; the amplitudes of an effect are one scale away from neutral."""
    if given in PLAIN:
        return Part(given)
    part = given if isinstance(given, Part) else None
    law = part.effect if part else neutral(effect_named(given)) if isinstance(given, str) else given
    if law is None:
        return part
    law = with_values(law, **{p.name: p.neutral + p.scale for p in law.parameters() if p.amplitude})
    return Part(law.name, law, part.resized, part.opens, part.levels) if part else Part(law.name, law)


def candidate(*parts, gap=0.0):
    """Return a fitted model that leaves this distance [m] (one for all trials, or one for each)."""
    gaps = gap if isinstance(gap, tuple) else (gap,)
    fit = fitted(parts, float(np.sqrt(np.mean(np.square(gaps)))))
    causes = tuple(Cause(part.name, part.kind, part.flexible) for part in fit.hypothesis.parts)
    count = len(fit.values)
    left = heldout(*gaps)
    return Candidate(fit, left, Model(causes, np.array([lasting_square(left) / 2]), 1e-3 * np.eye(count)[None], np.zeros(count)))


@dataclass
class FakePool:
    """Fit pool that answers from a table instead of simulating."""

    gaps: dict
    quick_gaps: dict | None = None
    unseen: tuple = ()
    fitted: list = field(default_factory=list)

    def __post_init__(self):
        self.gaps, self.quick_gaps = map(_by_names, (self.gaps, self.quick_gaps or self.gaps))

    def gap(self, parts, quick=False):
        names, gaps = frozenset(map(_called, parts)), self.quick_gaps if quick else self.gaps
        known = [(len(key), -gap, key) for key, gap in gaps.items() if key <= names]
        return gaps[max(known, key=lambda item: item[:2])[2]]

    def propose(self, asked):
        return [self._proposals(*each) for each in asked]

    def _proposals(self, base, parts):
        before = self.gap(base.fit.hypothesis.parts) ** 2
        found = []
        for part in parts:
            hypothesis = base.fit.hypothesis.with_part(part)
            other = (part.effect is not None and part.effect.variants().index(dict(part.effect.options))) + 0.5 * part.resized
            gain = max(0.0, 1 - self.gap(hypothesis.parts) ** 2 / before) * 0.999**other  # no two variants do quite the same
            found.append(Proposal(hypothesis, (hypothesis.start,), 0.0 if part.name in self.unseen else gain))
        return found

    def quick(self, tasks):
        return [fitted(each.hypothesis.parts, self.gap(each.hypothesis.parts, quick=True)) for _, each in tasks]

    def full(self, starts):
        self.fitted += ["+".join(sorted(map(_called, fit.hypothesis.parts))) for fit in starts]
        return [candidate(*fit.hypothesis.parts, gap=self.gap(fit.hypothesis.parts)) for fit in starts]


def _called(part):
    return part.name + "@each" * bool(part.levels)


def _by_names(table):
    return {frozenset(filter(None, key.split("+"))): gap for key, gap in table.items()}


def supply(name, *times):
    """Return a supply with a delay and two time constants [s], and a gain of one."""
    facts = zip(("delay", "rise", "fall", "gain", "offset"), ("s", "s", "s", "1", "bar"), (*times, 1.0, 0.0), strict=True)
    return Supply(
        name, "bar", *(Estimate(*each, (each[-1] - 0.01, each[-1] + 0.01), "", False) for each in facts), 0.01, 0.001, 0.02
    )


#: A supply that is late, and one that is not.
SLOW, PROMPT = supply("P1", 0.24, 0.57, 1.08), supply("P2", 0.0, 0.002, 0.002)
