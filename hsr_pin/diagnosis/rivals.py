"""Which models explain the recordings as well as the best, and which parts of the best do not matter then."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.thresholds import Thresholds, doubtful, explains, left, matches, mean_square

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
        if rival.contains(best):
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


def without_companions(found: Search, thresholds: Thresholds, seed: int) -> Search:
    """A search that ends at what all rivals of its best model share, where that does nearly all that the best does.

    Beside a law that is plainly there an arm has many small ones. Where several may be the next one, and it hardly matters which,
    none of them is worth a name.
    """
    base, best = found.path[0], found.best
    closes = explains(best, base, thresholds) and not doubtful(best)
    sets = [best.names, *rivals(best, base, found.tried, thresholds, seed, closes)]
    common = tuple(sorted(set.intersection(*map(set, sets))))
    if not common or common == best.names:
        return found
    fewer = min((each for each in found.tried if each.names == common), key=mean_square, default=None)
    if fewer is None or left(base) - left(fewer) < (1 - COMPANION) * (left(base) - left(best)):
        return found
    return Search((base, fewer), found.tried)
