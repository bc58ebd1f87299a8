"""What gets a quick fit: of all proposals those that promise most, so chosen that no law crowds out others."""

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

#: The most promising proposals that get a quick fit beside the model without causes, and beside each of several models.
_ALONE, _BESIDE = 12, 5
#: Variants of one law that come before the variants of others.
_VARIANTS = 3
#: Two variants of one law whose predicted gains differ by less than this are the same on these recordings.
_EQUAL = 1e-6
#: A quick fit that ended at factors on declared numbers which differ by more than the first ratio from those of the best, and
#: leaves more than the second times its error, is made once more from there: the misfit of what swings has several basins.
_ELSEWHERE, _WORSE = 1.5, 1.2


def screened(proposals: Sequence[Proposal], *, alone: bool) -> list[Proposal]:
    """What gets a quick fit, the most promising first.

    Args:
        proposals: for adding a part to one model.
        alone: whether that model has no causes: then every law is among them, in its most promising variant.
    """
    ranked = _distinct(sorted(proposals, key=lambda each: -each.gain))
    if alone:  # damping hides what is late where it was fitted without any law
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
    """The first of each variant of a law; the others make no difference, as where a law differs for torques that never came."""
    kept: list[Proposal] = []
    for each in proposals:
        name = each.hypothesis.parts[-1].name
        if not any(other.hypothesis.parts[-1].name == name and abs(other.gain - each.gain) < _EQUAL for other in kept):
            kept.append(each)
    return kept


def _of_many_laws(proposals: Sequence[Proposal]) -> list[Proposal]:
    """In their order, but the first few variants of every law before the others."""
    seen: Counter[str] = Counter()
    later: list[bool] = []
    for each in proposals:
        name = each.hypothesis.parts[-1].name
        later.append(seen[name] >= _VARIANTS)
        seen[name] += 1
    return [each for _, each in sorted(zip(later, proposals, strict=True), key=lambda pair: pair[0])]


def _no_less_than_special_cases(proposals: Sequence[Proposal]) -> list[Proposal]:
    """A law that contains others, as a probe may not show where damping hides what is late, promises at least what they do."""
    parts = [each.hypothesis.parts[-1] for each in proposals]
    alone = [k for k, part in enumerate(parts) if part.plain.reading == part.reading]
    gains = {parts[k].name: proposals[k].gain for k in reversed(alone)}
    inside = [[gains.get(name, 0.0) for name in part.special_cases] for part in parts]
    return [replace(each, gain=max(each.gain, *known, 0.0)) for each, known in zip(proposals, inside, strict=True)]


def laws_first(fits: Sequence[Fit]) -> list[Fit]:
    """The best variant of every law in their order, then the other variants: they shall not crowd out other laws."""
    first: dict[frozenset[str], Fit] = {}
    for each in fits:
        first.setdefault(frozenset(part.name for part in each.hypothesis.parts), each)
    chosen = set(map(id, first.values()))
    return [*first.values(), *(each for each in fits if id(each) not in chosen)]


def from_one_basin(tasks: Sequence[tuple[Fit, Proposal]], pool: FitPool) -> list[Fit]:
    """Quick fits, the best first, of which none is worse for want of the factors on declared numbers that the best one found."""
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
    """Whether a fit ended at quite other factors on declared numbers than the best."""
    own, other = _factors(fitted), _factors(best)
    return any(max(own[name] / other[name], other[name] / own[name]) > _ELSEWHERE for name in own.keys() & other)


def _with_factors_of(best: Fit, fitted: Fit) -> Array:
    """(P,) values of a fit, with the factors on declared numbers of another."""
    return np.array(list((fitted.named | {k: value for k, value in _factors(best).items() if k in fitted.named}).values()))


def _factors(fitted: Fit) -> dict[str, float]:
    facts = zip(fitted.hypothesis.parameters, fitted.values, strict=True)
    return {fact.name: float(value) for fact, value in facts if fact.ratio_width is not None}
