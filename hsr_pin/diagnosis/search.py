"""Which effects: added one at a time, a few of the best sets carried on side by side, judged on held-out trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate, Guess
from hsr_pin.diagnosis.crew import Crew
from hsr_pin.diagnosis.rivals import with_doubles, without_companions
from hsr_pin.diagnosis.screening import BEAM_GLANCES, passed_over, promising, screened
from hsr_pin.diagnosis.thresholds import (
    FACTOR,
    Thresholds,
    clearly_worse,
    doubtful,
    explains,
    left,
    matches,
    mean_square,
    worth_having,
)
from hsr_pin.identification.evaluation import rms
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import ARM, Hypothesis, Part
from hsr_pin.identification.uncertainty import alike
from hsr_pin.trajectory import Array

#: The best of these get a full fit: the first few in any case; more, up to a limit, if their RMS is within this factor of the
#: best, and if they take away at least this share of what would be worth having.
FINISHED, AT_MOST, CLOSE, HOPEFUL = 3, 6, 1.2, 0.5
#: A quick fit farther from the best than that, at another stiffness or damping by this factor, is tried at those of the best.
APART = 1.5
#: Sets carried on to the next rung.
BEAM = 3

#: Of the special cases of a law that is best, so many get a full fit.
SPECIAL = 2
#: Of the models with a law's double in its place, so many.
DOUBLES = 3

#: Of a gap that is explained, this many times what is too small to ask about is no reason to look for more.
CORNER = 2.0
#: Where two effects leave a larger share of the squared gap than this, no third is looked for.
HOPELESS = 0.5
#: Where no law that was fitted is worth having and leaves less than this share, those are looked at that were passed over.
MOST = 0.75

#: What a model has beside stiffness and damping: name, options and size of each.
Key = tuple[tuple[object, ...], ...]


@dataclass(frozen=True, eq=False)
class Search:
    """What the search did.

    Attributes:
        path: the models on the way from the one without effects to the best, each with the effects of the one before.
        tried: every model that was fitted.
    """

    path: tuple[Candidate, ...]
    tried: tuple[Candidate, ...]

    @property
    def best(self) -> Candidate:
        """Where the path ends."""
        return self.path[-1]


def search(
    start: Candidate,
    parts: Sequence[Part],
    thresholds: Thresholds,
    crew: Crew,
    *,
    max_effects: int = 3,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
) -> Search:
    """Add effects to a fitted model as long as one is worth having.

    Args:
        start: the model without effects, K and C fitted.
        parts: the catalogue, each effect with the options it is to be tried with.
        thresholds: what counts.
        crew: who does the fitting.
        max_effects: at most this many.
        seed: of the resampling.
        tell: called at each rung.
    """
    path, beam = [start], [start]
    tried: dict[Key, Candidate] = {(): start}
    for rung in range(1, max_effects + 1):
        if not _is_open(path, thresholds):
            break
        tell(f"effect {rung}: trying {len(parts)} candidates")
        looks = screened(beam, parts, crew)
        new = _extend(beam, looks, crew, tried, thresholds)
        tried |= {key(candidate): candidate for candidate in new}
        if rung == 1 and not any(left(c) <= MOST * left(start) and worth_having(start, c, thresholds, seed) for c in new):
            new += _from_neutral_too(_extend(beam, [passed_over(start, parts, looks[0], crew)], crew, tried, thresholds), crew)
            tried |= {key(candidate): candidate for candidate in new}
        better = sorted((c for c in new if mean_square(c) < mean_square(path[-1])), key=mean_square)
        good = [c for c in better if worth_having(path[-1], c, thresholds, seed)]
        if rung > len(path):  # a pair of which neither was worth having alone: its word counts where it closes the gap
            good = [c for c in good if explains(c, start, thresholds)]
        if good:
            path.append(good[0])
        elif rung > 1 or not better:
            break
        beam = _distinct(better)[:BEAM]  # one whose own gain is not certain may be half of a pair
    best = _pruned(path[-1], start, tried, thresholds, crew, seed)
    if len(best.names) > 1:
        tell("exchange: each effect found against the others")
        other = _exchanged(best, parts, crew, tried, thresholds)
        best = best if other is best else min(best, _pruned(other, start, tried, thresholds, crew, seed), key=mean_square)
    doubled = with_doubles(best, start, list(tried.values()), thresholds, seed)
    tried |= {key(each): each for each in crew.finish([fit for fit in doubled if _key(fit.hypothesis) not in tried][:DOUBLES])}
    best = _leading(best, list(tried.values()), thresholds, seed)
    best = _simplest(best, start, list(tried.values()), thresholds, seed)
    best = _surest(best, start, list(tried.values()), thresholds, seed)
    best = without_companions(best, start, list(tried.values()), thresholds, seed)
    for _ in best.names:  # of one part, then of another
        tried |= {key(candidate): candidate for candidate in _special_cases(best, parts, crew, tried)}
        general, best = best, _simplest(best, start, list(tried.values()), thresholds, seed)
        if best is general:
            break
    if len(best.names) < max_effects:
        best = _in_its_cases(best, start, parts, crew, tried, thresholds, seed)
    return Search(_nested(best, start, list(tried.values())), tuple(tried.values()))


def _special_cases(best: Candidate, parts: Sequence[Part], crew: Crew, tried: dict[Key, Candidate]) -> list[Candidate]:
    """The best with simpler laws in place of one that contains them, the few that come closest: a beam may pass by them."""
    new: list[Candidate] = []
    for part in best.fit.hypothesis.parts:
        free = [other for other in parts if not other.levels and other.name not in set(best.names) - {part.name}]
        inside = [other for other in free if part.contains(other)]
        if not inside:
            continue
        fewer = without(best.fit, part.name)
        base = tried.get(_key(fewer.hypothesis)) or crew.finish([fewer])[0]
        guessed = promising([base], inside, crew)[0][:BEAM_GLANCES]
        quick = _from_one_basin([(base.fit, guess) for guess in guessed if _key(guess.hypothesis) not in tried], crew)
        new += crew.finish(laws_first(quick)[:SPECIAL])
    return new


def _in_its_cases(
    best: Candidate,
    start: Candidate,
    parts: Sequence[Part],
    crew: Crew,
    tried: dict[Key, Candidate],
    thresholds: Thresholds,
    seed: int,
) -> Candidate:
    """In place of the best, where a law's numbers may be no others than its special cases have together, the model with those.

    A lag that is as long one way as the other, and late, is a lag and a delay.
    """
    for law in best.fit.hypothesis.parts:
        names = set(law.effect.contains) - set(best.names) if law.effect and alike(best.fit, law) else set()
        if len(names) < 2:
            continue
        fit = without(best.fit, law.name)
        for name in sorted(names):
            base = tried.get(_key(fit.hypothesis)) or crew.finish([fit])[0]
            guessed = promising([base], [part for part in parts if part.name == name and not part.levels], crew)[0]
            if not guessed:
                break
            fit = min(crew.glance([(base.fit, guess) for guess in guessed]), key=lambda each: each.rms)
        else:
            other = tried.setdefault(_key(fit.hypothesis), crew.finish([fit])[0])
            if matches(other, best, start, thresholds, seed):
                return other
    return best


def _simplest(best: Candidate, start: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int) -> Candidate:
    """In place of the best the best of its special cases with as many parts, if that does as well or leaves next to nothing.

    A worse one that is not clearly worse is so for its scatter from trial to trial.
    """
    alike = [other for other in tried if len(other.names) == len(best.names)]
    inside = [other for other in alike if best.contains(other) and not other.contains(best)]  # each may hold a case of the other
    other = min(inside, key=mean_square, default=best)
    if other is not best and (left(other) <= thresholds.closed**2 or matches(other, best, start, thresholds, seed)):
        return _simplest(other, start, tried, thresholds, seed)
    return best


def _leading(best: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int) -> Candidate:
    """In place of the best, where one of as few parts is clearly better, that: it may have lost what made it the best."""
    few = [each for each in tried if len(each.names) == len(best.names) and each.nameable and not doubtful(each)]
    other = min((each for each in few if each.names), key=mean_square, default=best)
    return other if clearly_worse(best, other, thresholds, seed) else best


def _surest(best: Candidate, start: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int) -> Candidate:
    """In place of a best with a part of doubtful size the best of those as large that does as well and is sure of all."""
    if not doubtful(best):
        return best
    for other in sorted((each for each in tried if len(each.names) == len(best.names)), key=mean_square):
        if not doubtful(other) and matches(other, best, start, thresholds, seed):
            return other
    return best


def _is_open(path: Sequence[Candidate], thresholds: Thresholds) -> bool:
    """Whether to look for another effect: there is hope, and more is left than a corner of the gap or than does not repeat."""
    gap, rest = left(path[0]), left(path[-1])
    if len(path) > 1 and rest <= thresholds.unrepeatable**2:
        return False
    if rest <= thresholds.closed**2 or (rest <= thresholds.explained * gap and rest <= (CORNER * thresholds.closed) ** 2):
        return False
    return len(path) < 3 or rest <= HOPELESS * gap


def key(candidate: Candidate) -> Key:
    """What a candidate has beside stiffness and damping, in which reading."""
    return _key(candidate.fit.hypothesis)


def _key(hypothesis: Hypothesis) -> Key:
    return tuple(sorted((part.reading for part in hypothesis.parts), key=repr))


def _extend(
    beam: Sequence[Candidate], looks: Sequence[Sequence[Guess]], crew: Crew, tried: dict[Key, Candidate], thresholds: Thresholds
) -> list[Candidate]:
    """What is best of models with one law more, of those that were chosen to be looked at beside each."""
    chosen: dict[Key, tuple[Fit, Guess]] = {}
    for base, guesses in zip(beam, looks, strict=True):
        for guess in guesses:
            if (name := _key(guess.hypothesis)) not in tried:
                chosen.setdefault(name, (base.fit, guess))
    quick = laws_first(_from_one_basin(list(chosen.values()), crew))
    so_far = min(rms([base.fit.residuals[k] for k in crew.glanced]) for base in beam)
    hopeful = sqrt(max(0.0, so_far**2 - HOPEFUL * thresholds.worth**2))
    limit = min(CLOSE * quick[0].rms, hopeful) if quick else 0.0
    return crew.finish(quick[:FINISHED] + [fitted for fitted in quick[FINISHED:AT_MOST] if fitted.rms < limit])


def _from_one_basin(tasks: Sequence[tuple[Fit, Guess]], crew: Crew) -> list[Fit]:
    """Quick fits, the best first, of which none is worse for want of the stiffness and damping that the best one found.

    The misfit of a swinging arm has several basins, and a law alone is seldom enough to leave one.
    """
    quick = crew.glance(tasks)
    best = min(quick, key=lambda fitted: fitted.rms, default=None)
    again = [k for k, fitted in enumerate(quick) if best and fitted.rms > CLOSE * best.rms and _elsewhere(fitted, best)]
    moved = [(tasks[k][0], Guess(quick[k].hypothesis, (_with_arm_of(best, quick[k]),), tasks[k][1].gain)) for k in again if best]
    quick += crew.glance(moved) if moved else []
    kept: dict[Key, Fit] = {}
    for fitted in sorted(quick, key=lambda fitted: fitted.rms):
        kept.setdefault(_key(fitted.hypothesis), fitted)
    return list(kept.values())


def _from_neutral_too(candidates: Sequence[Candidate], crew: Crew) -> list[Candidate]:
    """The same models, or as a fit from neutral finds them where that finds better ones."""
    again = crew.finish([replace(each.fit, values=each.fit.hypothesis.start) for each in candidates])
    return [min(pair, key=lambda each: each.fit.rms) for pair in zip(candidates, again, strict=True)]


def _elsewhere(fitted: Fit, best: Fit) -> bool:
    """Whether a fit ended at quite another stiffness or damping than the best."""
    own, other = _arm(fitted), _arm(best)
    return any(max(own[name] / other[name], other[name] / own[name]) > APART for name in own.keys() & other)


def _with_arm_of(best: Fit, fitted: Fit) -> Array:
    """(P,) values of a fit, with the stiffness and damping of another."""
    return np.array(list((fitted.named | {name: value for name, value in _arm(best).items() if name in fitted.named}).values()))


def _arm(fitted: Fit) -> dict[str, float]:
    return {name: value for name, value in fitted.named.items() if name.partition("@")[0] in ARM}


def laws_first(fits: Sequence[Fit]) -> list[Fit]:
    """The best reading of every law in their order, then the other readings: they shall not crowd out other laws."""
    first: dict[frozenset[str], Fit] = {}
    for fitted in fits:
        first.setdefault(frozenset(part.name for part in fitted.hypothesis.parts), fitted)
    chosen = set(map(id, first.values()))
    return [*first.values(), *(fitted for fitted in fits if id(fitted) not in chosen)]


def _exchanged(
    best: Candidate, parts: Sequence[Part], crew: Crew, tried: dict[Key, Candidate], thresholds: Thresholds
) -> Candidate:
    """The best of as many effects after each of them had to stand against all others beside the rest.

    One that was good alone may be a stand-in beside the other, whose partner was never tried with it.
    """
    fewer = [tried[_key(without(best.fit, name).hypothesis)] for name in best.names]
    new = _extend(fewer, screened(fewer, parts, crew), crew, tried, thresholds)
    tried |= {key(candidate): candidate for candidate in new}
    return min((best, *new), key=mean_square)


def _pruned(
    best: Candidate, start: Candidate, tried: dict[Key, Candidate], thresholds: Thresholds, crew: Crew, seed: int
) -> Candidate:
    """The best without the effects that, now that the others are there, are not worth having: stand-ins on the way to them.

    Nor is one of doubtful size without which most is explained, nor one that takes a little of what the others leave: it mends
    what is wrong with another's law; unless the others are the best explanation with it only.
    """
    while len(best.names) > 1:
        smaller = [without(best.fit, name) for name in best.names]
        new = crew.finish([fewer for fewer in smaller if _is_new(fewer, tried, crew)])
        tried |= {key(each): min(each, tried.get(key(each), each), key=mean_square) for each in new}
        unsure = doubtful(best)
        spare = [
            fewer
            for fewer in (tried[_key(each.hypothesis)] for each in smaller)
            if (not set(unsure) <= set(fewer.names) and _keeps(fewer, best, start))
            or not worth_having(fewer, best, thresholds, seed)
            or (_patches(best, fewer, start, thresholds) and _leads(fewer, tried.values()))
        ]
        if not spare:
            break
        best = min(spare, key=mean_square)
    return best


def _is_new(start: Fit, tried: dict[Key, Candidate], crew: Crew) -> bool:
    """Whether a model was not fitted yet, or ended in a lesser optimum: from here it would begin closer than it came."""
    known = tried.get(_key(start.hypothesis))
    return known is None or crew.misfit(start) < known.fit.rms


def _keeps(fewer: Candidate, best: Candidate, start: Candidate) -> bool:
    """Whether most of what the best takes away is taken away with one part less."""
    return left(start) - left(fewer) >= FACTOR * (left(start) - left(best))


def _leads(candidate: Candidate, tried: Iterable[Candidate]) -> bool:
    """Whether no other model of as few causes does better: one that needs its patch to be the best is not known without it."""
    alike = (each for each in tried if each.nameable and len(each.names) == len(candidate.names))
    return all(mean_square(candidate) <= mean_square(each) for each in alike if not each.contains(candidate))


def _patches(best: Candidate, fewer: Candidate, start: Candidate, thresholds: Thresholds) -> bool:
    little = left(fewer) - left(best) < thresholds.substantial * left(start)
    return little and left(best) > max(thresholds.closed**2, thresholds.remnant * left(fewer))


def without(fit: Fit, name: str) -> Fit:
    """A place to start from for the model without one of its parts."""
    fewer, kept = fit.hypothesis.without_part(name)
    return replace(fit, hypothesis=fewer, values=fit.values[kept])


def _nested(best: Candidate, start: Candidate, tried: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """From the model without effects to the best, through the best of the fitted models whose effects the best has too.

    The search may pass through an effect that a better pair replaces; that one has no place on the way to the pair.
    """
    path = [best]
    while len(path[0].names) > 1:
        inside = [c for c in tried if c.names and set(c.names) < set(path[0].names)]
        if not inside:
            break
        largest = max(len(c.names) for c in inside)
        path.insert(0, min((c for c in inside if len(c.names) == largest), key=mean_square))
    return tuple(path) if best is start else (start, *path)


def _distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The first of each set of names: options of one law do not crowd the beam."""
    first: dict[tuple[str, ...], Candidate] = {}
    for candidate in candidates:
        first.setdefault(candidate.names, candidate)
    return list(first.values())
