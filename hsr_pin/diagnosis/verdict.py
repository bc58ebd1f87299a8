"""From what the search found to what may be said."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from math import sqrt

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.confidence import KIND, NAME, probability
from hsr_pin.diagnosis.rivals import idle, rivals
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.support import Support, Together
from hsr_pin.diagnosis.thresholds import (
    FACTOR,
    Thresholds,
    clearly_worse,
    doubtful,
    explains,
    left,
    matches,
    mean_square,
    open_share,
)
from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.hypothesis import PLAIN, SESSION

#: A name, or a kind, is certain from this probability on.
CERTAIN, CERTAIN_KIND = 0.85, 0.75
#: ... a kind that takes away less than this share beside others from as much on as a name: of such claims with less 3 of 15 were
#: right (tenth to twelfth sealed run); most were what was wrong with the form of the main law.
BESIDE = 0.15
#: ... if every model without it is worse by this many times what is tolerated in a model that is not exact: no law is led by less
#: than that, however clear its size is, where another does the same.
LED = 1.0
#: Where more of the squared gap than this is left, beyond what does not repeat, an effect may stand in for that: none is certain.
HALF = 0.5
#: Where something else is left, alternatives are told if a name of the best has this probability, or a kind this, and no more
#: than this share of the squared gap is left: of 12 such verdicts in which more was left one had the truth (third sealed run). So
#: is the best alone, where nothing comes near it.
POSSIBLE, LIKELY, LITTLE = 0.75, 0.65, 0.25
#: Causes that do half as much as the best are told beside those that do as much, up to so many in all.
FEW = 3
#: Of the laws of a kind that is certain, those are told that leave no more than this many times the square of what the best
#: of them leaves.
NEAR = 4.0
#: Models that leave most of the gap are not worth a word: the least share of the squared gap that one must take away.
WORTH_A_WORD = 0.2
#: A gap that no effect is worth having for is called structure only when it is this much larger than one too small to ask about.
STRUCTURE = 2.0

STATUSES = ("identified", "partly_identified", "ambiguous", "parameters", "no_gap", "unexplained", "insufficient", "unchanged")


#: Numbers of the arm in words.
_PLAINLY = {
    "torque_gain": "another gain of the torque (torque_gain)",
    "mass_scale": "another mass (mass_scale)",
    "keq_drift": "a stiffness that changes over the session (keq_drift)",
}


@dataclass(frozen=True)
class Left:
    """What the best model leaves on held-out trials, beyond noise.

    Attributes:
        rms: [m].
        share: of the squared gap that stiffness and damping left.
        length: [m] of the arm.
        not_repeatable: [m] how far the arm is from itself in trials that repeat one another; None where none do.
    """

    rms: float
    share: float
    length: float
    not_repeatable: float | None = None


@dataclass(frozen=True)
class Verdict:
    """What the recordings say.

    Attributes:
        status: one of :data:`STATUSES`.
        effects: the names that are certain, sorted (those that all alternatives share).
        alternatives: sets of names that these recordings cannot tell apart, the best first.
        sentence: the verdict as a person would say it.
        kinds: of physics that are certain, sorted.
        confidence: name or kind -> probability that it is right.
        left: what is left; None where nothing was fitted.
        support: what speaks for each part of the best model, then for each kind.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str
    kinds: tuple[str, ...] = ()
    confidence: Mapping[str, float] = field(default_factory=dict)
    left: Left | None = None
    support: tuple[Support, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """What a verdict rests on beside the models.

    Attributes:
        nominal: [m^2] mean square beyond noise of the declared model, finely discretised.
        parts, kinds: support for each part of the best model, and for each kind in it.
        together: the same for sets of names of which one may be right.
        length: [m] of the arm.
        not_repeatable: [m] as in :class:`Left`.
        by_level: without effects, but a stiffness and a damping for each declared Keq; None if one is declared.
        seed: of the resampling.
    """

    nominal: float
    parts: tuple[Support, ...]
    kinds: tuple[Support, ...]
    together: Together
    length: float
    not_repeatable: float | None
    by_level: Candidate | None
    seed: int


def judge(found: Search, thresholds: Thresholds, evidence: Evidence) -> Verdict:
    """The verdict on what a search found."""
    base, best, closed = found.path[0], found.best, thresholds.closed
    gap, rest = sqrt(left(base)), sqrt(left(best))
    remains = Left(rest, left(best) / max(left(base), 1e-300), evidence.length, evidence.not_repeatable)
    if sqrt(evidence.nominal) <= closed:
        return Verdict(
            "no_gap",
            (),
            (),
            f"The declared model reproduces these recordings to within {_mm(closed)} of their noise.",
            left=remains,
        )
    if gap <= closed or (best is base and gap <= STRUCTURE * closed):
        return Verdict("parameters", (), (), _parameters(base, sqrt(evidence.nominal), gap), left=remains)
    levels = evidence.by_level if evidence.by_level is not None and sqrt(left(evidence.by_level)) <= closed else None
    closes = explains(best, base, thresholds) and not doubtful(best)
    if levels is not None and (not closes or clearly_worse(best, levels, thresholds, evidence.seed)):
        return Verdict("parameters", (), (), _parameters(levels, sqrt(evidence.nominal), sqrt(left(levels))), left=remains)
    if best is base:
        return Verdict(
            "unexplained", (), (), f"A gap of {_mm(gap)} beyond noise is left, and no effect of the catalogue is worth having.",
            left=remains,
        )  # fmt: skip
    sets = [best.names, *rivals(best, base, found.tried, thresholds, evidence.seed, closes)]
    if levels is not None and closes and not clearly_worse(levels, best, thresholds, evidence.seed):
        sets.append(())
    return _graded(found, sets, closes, remains, gap, thresholds, evidence)


def _graded(
    found: Search,
    sets: list[tuple[str, ...]],
    closes: bool,
    remains: Left,
    gap: float,
    thresholds: Thresholds,
    evidence: Evidence,
) -> Verdict:
    """What of the best model may be named."""
    best = found.best
    names = {each.name: probability(each, NAME) for each in evidence.parts}
    kinds = {each.name: probability(each, KIND) for each in evidence.kinds}
    several = len(evidence.kinds) > 1
    needed = {each.name: CERTAIN if several and each.lead < BESIDE else CERTAIN_KIND for each in evidence.kinds}
    every, plain = sets, {name for name, value in (names | kinds).items() if value >= needed.get(name, CERTAIN)}
    if closes and len(sets) > 1:
        sets = _plainly_there(sets, plain, found)
    common = set.intersection(*map(set, sets))
    flexible = {part.name for part in best.fit.hypothesis.parts if part.flexible}
    rest = open_share(best, found.path[0], thresholds)
    led = {each.name for each in (*evidence.parts, *evidence.kinds) if each.margin >= LED}
    sure = tuple(sorted(name for name in common & led - flexible if rest <= HALF and names[name] >= CERTAIN))
    of_kind = tuple(sorted({k for k in led & plain & kinds.keys() if _in_all(k, sets, found)} | {_kinds(found)[n] for n in sure}))
    confidence = {name: round(value, 3) for name, value in (names | kinds).items() if name not in flexible}

    def said(status: str, sentence: str, alternatives: Sequence[tuple[str, ...]] = (), named: tuple[str, ...] = ()) -> Verdict:
        certain = () if status == "unexplained" else of_kind
        support = (*evidence.parts, *evidence.kinds)
        return Verdict(status, named, tuple(alternatives), sentence, certain, confidence, remains, support)

    effects = tuple(name for name in sure if name not in PLAIN)
    share = 100 * (1 - remains.share)
    goes = f"{share:.0f} % of the squared gap is gone, {_mm(remains.rms)} beyond noise is left"
    if closes and len(sets) == 1 and sure == best.names:
        are, them = ("is", "it") if len(sure) == 1 else ("are", "them")
        if not effects:
            told = _listed([_PLAINLY[name] for name in sure])
            explain = "explains" if len(sure) == 1 else "explain"
            status = "partly_identified" if set(sure) & set(SESSION) else "parameters"  # the one is no number of the arm
            return said(status, f"{told[0].upper()}{told[1:]} {explain} it: with {them} {goes}.")
        return said("identified", f"{_listed(sure)} {are} missing from the model: with {them} {goes}.", named=effects)
    if closes and len(sets) > 1:
        known = f"{_listed(effects)} {'is' if len(effects) == 1 else 'are'} certain; " if effects else ""
        listed = ", or ".join(" with ".join(each) or "another stiffness and damping at each level" for each in sets)
        small = "" if sets == every else "; beside it is something smaller, of no certain kind"
        return said("ambiguous", f"{known}these recordings cannot tell apart: {listed}{small}.", sets, effects)
    if sure or of_kind:
        beside = [k for k in of_kind if k not in {part.kind for part in best.fit.hypothesis.parts if part.name in sure}]
        near = _nearest(beside, sure, found, thresholds) if beside else []
        others = _told(_nameable(sets, found), of_kind, common, sure, found) if len(sets) > 1 else near
        kind = f"something of the kind {_listed(beside)} ({'; '.join(KINDS[k] for k in beside)})" if beside else ""
        what = ", and ".join(filter(None, (_listed(sure) if sure else "", kind)))
        verb = "are" if len(sure) + bool(beside) > 1 else "is"
        tail = f": {goes}" if sure == best.names else f"; with {_listed(best.names)} {goes}"
        nameless = any(part.flexible and part.kind in beside for part in best.fit.hypothesis.parts)
        but = ", though something else is left" if not closes else ", in a form that has no name here" if nameless else ""
        if others and beside:
            tail += f". Of the laws that have a name {_or(others)} {'come' if len(others) > 1 else 'comes'} closest"
        return said("partly_identified", f"{what} {verb} certain{but}{tail}.", others, effects)
    sets = _nameable(_wider(sets, found, thresholds), found)
    sets += _of_other_kinds(sets, found, thresholds, evidence.seed)
    one_of_them = probability(evidence.together(sets), NAME) >= CERTAIN  # though none of them is sure
    likely = one_of_them or max(names.values()) >= POSSIBLE or max(kinds.values()) >= LIKELY
    if likely and rest <= LITTLE and len(sets) > 1 and all(sets):
        return said("ambiguous", f"These recordings cannot tell apart: {_or(sets)}; {_mm(remains.rms)} is left.", sets)
    if rest <= LITTLE and len(sets) == 1 and not flexible and min(names.values()) >= POSSIBLE:
        does = "nothing else that was tried does as much, but it is not certain"
        return said("ambiguous", f"{_listed(best.names)} may be missing from the model: {does}; with it {goes}.", sets)
    hint = "no effect of the catalogue takes away a fifth of it"
    if 1 - remains.share >= WORTH_A_WORD:
        hint = f"the best that the catalogue offers ({_listed(best.names)}) is not certain"
    return said("unexplained", f"Of the gap of {_mm(gap)} beyond noise, {_mm(remains.rms)} is left, and {hint}.")


def _plainly_there(sets: list[tuple[str, ...]], certain: Collection[str], found: Search) -> list[tuple[str, ...]]:
    """Of sets that close the gap what is certain in each by name or kind; the sets as they are, where that is nothing in one.

    Or is part of what it is in another: of what is open there, some is of a kind that is certain for another's sake.
    Where nothing is left a second law that is there shows as plainly as the first. One of which neither name nor kind does is
    what is wrong with the form of the first, or one of the small things that every arm has.
    """
    kind_of = _kinds(found)
    plain = [tuple(name for name in each if name in certain or kind_of[name] in certain) for each in sets]
    nested = any(set(one) < set(other) for one in plain for other in plain)
    return list(dict.fromkeys(plain)) if all(plain) and not nested else sets


def _nameable(sets: Sequence[tuple[str, ...]], found: Search) -> list[tuple[str, ...]]:
    """Those of the sets in which all are causes; all of them where none is."""
    causes = {candidate.names for candidate in (*found.path, *found.tried) if candidate.nameable}
    return [names for names in sets if names in causes] or list(sets)


def _of_other_kinds(sets: Sequence[tuple[str, ...]], found: Search, thresholds: Thresholds, seed: int) -> list[tuple[str, ...]]:
    """The best flexible law, if any, that does what the best model does and is of a kind that none of the sets has.

    However many the sets are: that the cause is one of them is not to be said where it may be that.
    """
    base, best = found.path[0], found.best
    known = {kind for each in found.tried if each.names in sets for kind in each.kinds}

    def fits(each: Candidate) -> bool:
        as_small = len(each.names) <= len(best.names) and not each.contains(best)
        return as_small and matches(each, best, base, thresholds, seed) and not idle(each, base, found.tried, thresholds)

    new = (each for each in sorted(found.tried, key=mean_square) if not each.nameable and not known.issuperset(each.kinds))
    return list(islice((each.names for each in new if fits(each)), 1))


def _nearest(kinds: Sequence[str], sure: Sequence[str], found: Search, thresholds: Thresholds) -> list[tuple[str, ...]]:
    """What is sure, with a cause of each of these kinds: of the models that have one the few that come closest to the best."""
    base, best = found.path[0], found.best
    near: list[Candidate] = []
    for each in sorted(found.tried, key=mean_square):
        fits = each.nameable and set(sure) <= set(each.names) and set(kinds) <= set(each.kinds)
        enough = left(base) - left(each) >= FACTOR * (left(base) - left(best)) and len(each.names) <= len(best.names)
        told = any(set(other.names) <= set(each.names) for other in near)
        if fits and enough and not told and not idle(each, base, found.tried, thresholds):
            near.append(each)
    closest = [each.names for each in near if left(each) <= NEAR * max(left(near[0]), thresholds.closed**2)]
    return _parts_of(closest, kinds, sure, found)[:FEW]


def _told(
    sets: Sequence[tuple[str, ...]], kinds: Sequence[str], common: Collection[str], sure: tuple[str, ...], found: Search
) -> list[tuple[str, ...]]:
    """Of each of some sets what is of a certain kind or common to all that do as well; nothing where that is but what is sure."""
    own = _parts_of(sets, kinds, common, found)
    return [names for names in own if names != sure and not any(set(other) < set(names) for other in own)]


def _parts_of(
    sets: Iterable[tuple[str, ...]], kinds: Sequence[str], names: Collection[str], found: Search
) -> list[tuple[str, ...]]:
    """Of each of some sets what is of these kinds, or one of these names; each once."""
    kind_of = _kinds(found)
    own = (tuple(name for name in each if name in names or kind_of[name] in kinds) for each in sets)
    return list(dict.fromkeys(filter(None, own)))


def _wider(sets: list[tuple[str, ...]], found: Search, thresholds: Thresholds) -> list[tuple[str, ...]]:
    """The sets, and a few of those next to them: what is not clearly worse by much is not out."""
    base, best, wider = found.path[0], found.best, list(sets)
    for rival in sorted(found.tried, key=mean_square):
        enough = left(base) - left(rival) >= FACTOR * (left(base) - left(best))
        known = rival.names in wider or not rival.nameable or rival.contains(best) or len(rival.names) > len(best.names)
        if len(wider) < FEW and enough and not known and not idle(rival, base, found.tried, thresholds):
            wider.append(rival.names)
    return wider


def _in_all(kind: str, sets: Sequence[tuple[str, ...]], found: Search) -> bool:
    kind_of = _kinds(found)
    return all(kind in {kind_of[name] for name in names} for names in sets)


def _kinds(found: Search) -> dict[str, str]:
    """Of every law that was fitted."""
    return {part.name: part.kind for each in (*found.path, *found.tried) for part in each.fit.hypothesis.parts}


def _parameters(base: Candidate, before: float, after: float) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in base.fit.named.items())
    return f"Stiffness and damping explain it ({values}): the gap beyond noise falls from {_mm(before)} to {_mm(after)}."


def _or(sets: Sequence[tuple[str, ...]]) -> str:
    return ", or ".join(" with ".join(each) for each in sets)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm"
