"""Which models explain the recordings as well as the best, and which parts of the best do not matter then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.thresholds import Thresholds, doubtful, explains, left, matches, mean_square
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Part

#: An amplitude closer to neutral than so many standard errors may as well be neutral (95 %).
AWAY = 1.96
#: Of which law a small companion is, is not asked where it takes away no more than this share of what the whole model does.
COMPANION = 0.05


def rivals(
    best: Candidate, base: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int, closes: bool
) -> list[tuple[str, ...]]:
    """Other sets of effects, no larger than the best, that explain the recordings as well; the best of them first."""
    answers: list[tuple[str, ...]] = []
    for rival in sorted(tried, key=mean_square):
        names = rival.names
        if not names or names == best.names or len(names) > len(best.names) or names in answers or not rival.nameable:
            continue
        if rival.contains(best) or rival.bends_more(best):
            continue
        if idle(rival, base, tried, thresholds):
            continue
        simpler = closes and len(rival.fit.values) < len(best.fit.values) and left(rival) <= thresholds.closed**2
        if simpler or matches(rival, best, base, thresholds, seed):
            answers.append(names)
    return answers


def idle(candidate: Candidate, base: Candidate, tried: Sequence[Candidate], thresholds: Thresholds) -> bool:
    """Whether a part of no clear size does nothing in a model: without it as much is explained, or that was not tried."""
    for name in doubtful(candidate, AWAY):
        fewer = tuple(other for other in candidate.names if other != name)
        without = [mean_square(other) for other in (base, *tried) if other.names == fewer]
        if not without or min(without) - mean_square(candidate) < thresholds.worth**2:
            return True
    return False


def without_companions(
    best: Candidate, base: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int
) -> Candidate:
    """In place of the best some of its parts, where they do nearly as much and a rival does as well without each of the others.

    They have to explain the recordings themselves, or to be what all rivals share, or a rival.

    Beside a law that is plainly there an arm has many small ones. Where several may be the next one, and it hardly matters which,
    none of them is worth a name. Nor shall a flexible law that takes away little tell a name from another of its kind that does
    as well without it: it bends to what is wrong with one law more than to what is wrong with the other.
    """

    def rivals_of(model: Candidate) -> list[tuple[str, ...]]:
        return rivals(model, base, tried, thresholds, seed, explains(model, base, thresholds) and not doubtful(model))

    kinds = {each.names: each.kinds for each in tried}
    whole, others = set(best.names), [set(names) for names in rivals_of(best)]
    flexible = {part.name for part in best.fit.hypothesis.parts if part.flexible}
    most = left(best) + COMPANION * (left(base) - left(best))
    shared = whole.intersection(*others)

    def enough(some: Candidate) -> bool:  # by itself, or for all rivals
        return explains(some, base, thresholds) or set(some.names) in (shared, *others)

    def spared(part: str, some: Candidate) -> bool:
        alike = part in flexible and any(kinds[names] == some.kinds for names in rivals_of(some))
        return alike or any(part not in names for names in others)

    smaller = (each for each in tried if each.names and each.nameable and set(each.names) < whole and left(each) <= most)
    fewer = [each for each in smaller if enough(each) and all(spared(part, each) for part in whole - set(each.names))]
    return min(fewer, key=lambda each: (len(each.names), mean_square(each)), default=best)


def with_doubles(best: Candidate, base: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int) -> list[Fit]:
    """Where to start from with a law's double in its place: one that did as well there in another model; the likest first.

    What recordings do not tell apart beside one law they seldom do beside another; none is certain for want of a rival.
    """
    found: dict[tuple[object, ...], tuple[float, Fit]] = {}
    for part in best.fit.hypothesis.parts if len(best.names) > 1 else ():
        for model in (each for each in tried if part.name in each.names):
            rest = set(model.names) - {part.name}
            for other in tried:
                new = [each for each in other.fit.hypothesis.parts if each.name not in rest]
                if len(other.names) != len(model.names) or len(new) != 1 or new[0].name in best.names:
                    continue
                double = new[0]
                if not double.flexible and matches(other, model, base, thresholds, seed):
                    likeness = mean_square(other) / mean_square(model)
                    if likeness < found.get(swap := (part.name, *double.reading), (np.inf, best.fit))[0]:
                        found[swap] = likeness, _in_place(best.fit, part.name, double, other.fit)
    return [fit for _, fit in sorted(found.values(), key=lambda each: each[0])]


def _in_place(fit: Fit, name: str, part: Part, model: Fit) -> Fit:
    """A fit with a part of another model in place of one of its own, at the other's values."""
    fewer, kept = fit.hypothesis.without_part(name)
    whole = fewer.with_part(part)
    new = [model.named[other] for other in whole.free[len(kept) :]]
    return replace(fit, hypothesis=whole, values=np.append(fit.values[kept], new))
