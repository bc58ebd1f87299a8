"""Selection of the proposals that get a quick fit: the most promising ones, with a limit on the variants of each law."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.inference.candidate import Key
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.proposals import Proposal
from hsr_pin.trajectory import Array

#: Number of proposals that get a quick fit: for the model without causes, and for each of several other models.
_ALONE, _BESIDE = 12, 5
#: Number of variants of each law that come before further variants of any law.
_VARIANTS = 3
#: Variants of one law whose predicted gains differ by less than this are equal on these recordings.
_EQUAL = 1e-6
#: A quick fit whose factors on declared numbers differ from those of the best fit by more than the first ratio, and whose error
#: exceeds that of the best by more than the second, is repeated from there: the misfit of oscillations has several minima.
_ELSEWHERE, _WORSE = 1.5, 1.2


def screened(proposals: Sequence[Proposal], *, alone: bool) -> list[Proposal]:
    """Return the proposals that get a quick fit, the most promising first.

    Args:
        proposals: proposals for adding a part to one model.
        alone: whether the model has no causes; then every law is included, in its most promising variant.
    """
    ranked = _distinct(sorted(proposals, key=lambda each: -each.gain))
    if alone:  # the damping of the model without causes hides delays
        ranked = sorted(_no_less_than_special_cases(ranked), key=lambda each: -each.gain)
    ranked = _of_many_laws(ranked)
    chosen = ranked[: _ALONE if alone else _BESIDE]
    laws = {each.hypothesis.parts[-1].name for each in chosen}
    for each in ranked if alone else ():
        if (name := each.hypothesis.parts[-1].name) not in laws:
            chosen.append(each)
            laws.add(name)
    return chosen


def _distinct(proposals: Sequence[Proposal]) -> list[Proposal]:
    """Return the proposals without variants of one law that have equal gains, because these recordings cannot separate them."""
    kept: list[Proposal] = []
    for each in proposals:
        name = each.hypothesis.parts[-1].name
        if not any(other.hypothesis.parts[-1].name == name and abs(other.gain - each.gain) < _EQUAL for other in kept):
            kept.append(each)
    return kept


def _of_many_laws(proposals: Sequence[Proposal]) -> list[Proposal]:
    """Return the proposals in their order, but with the first few variants of every law before all others."""
    seen: Counter[str] = Counter()
    later: list[bool] = []
    for each in proposals:
        name = each.hypothesis.parts[-1].name
        later.append(seen[name] >= _VARIANTS)
        seen[name] += 1
    return [each for _, each in sorted(zip(later, proposals, strict=True), key=lambda pair: pair[0])]


def _no_less_than_special_cases(proposals: Sequence[Proposal]) -> list[Proposal]:
    """Return the proposals with the gain of each law raised to the gains of its special cases.

    A probe may underestimate a general law, because the fitted damping hides a delay.
    """
    parts = [each.hypothesis.parts[-1] for each in proposals]
    alone = [k for k, part in enumerate(parts) if part.base_variant.variant == part.variant]
    gains = {parts[k].name: proposals[k].gain for k in reversed(alone)}
    inside = [[gains.get(name, 0.0) for name in part.special_cases] for part in parts]
    return [replace(each, gain=max(each.gain, *known, 0.0)) for each, known in zip(proposals, inside, strict=True)]


def laws_first(fits: Sequence[Fit]) -> list[Fit]:
    """Return the best variant of every law in their order, then the other variants, so that they do not displace other laws."""
    first: dict[frozenset[str], Fit] = {}
    for each in fits:
        first.setdefault(frozenset(part.name for part in each.hypothesis.parts), each)
    chosen = set(map(id, first.values()))
    return [*first.values(), *(each for each in fits if id(each) not in chosen)]


def from_one_basin(tasks: Sequence[tuple[Fit, Proposal]], pool: FitPool) -> list[Fit]:
    """Return the quick fits of some proposals, the best first.

    Fits that ended in another minimum are repeated with the factors on declared numbers of the best fit.
    """
    quick = pool.quick(tasks)
    best = min(quick, key=lambda each: each.rms, default=None)
    again = [k for k, each in enumerate(quick) if best and each.rms > _WORSE * best.rms and _elsewhere(each, best)]
    quick += pool.quick(
        [
            (tasks[k][0], Proposal(quick[k].hypothesis, (_with_factors_of(best, quick[k]),), tasks[k][1].gain))
            for k in again
            if best
        ]
    )
    kept: dict[Key, Fit] = {}
    for each in sorted(quick, key=lambda each: each.rms):
        kept.setdefault(each.hypothesis.key, each)
    return list(kept.values())


def _elsewhere(fitted: Fit, best: Fit) -> bool:
    """Return whether a fit ended at factors on declared numbers that differ strongly from those of the best fit."""
    own, other = _factors(fitted), _factors(best)
    return any(max(own[name] / other[name], other[name] / own[name]) > _ELSEWHERE for name in own.keys() & other)


def _with_factors_of(best: Fit, fitted: Fit) -> Array:
    """Return the values (P,) of a fit with the factors on declared numbers of another fit."""
    return np.array(list((fitted.named | {k: value for k, value in _factors(best).items() if k in fitted.named}).values()))


def _factors(fitted: Fit) -> dict[str, float]:
    """Return the factors on declared numbers of a fit by name."""
    facts = zip(fitted.hypothesis.parameters, fitted.values, strict=True)
    return {fact.name: float(value) for fact, value in facts if fact.ratio_width is not None}
