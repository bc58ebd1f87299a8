"""What to look at: of all that could be added to a model, by what a probe predicts, the little that a quick fit is spent on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from hsr_pin.diagnosis.candidates import Candidate, Guess
from hsr_pin.diagnosis.crew import Crew
from hsr_pin.identification.hypothesis import Part

#: Of all effects, those that a probe predicts to help most get a quick fit, at most this many: beside the arm alone, and beside
#: each of several models ...
GLANCES, BEAM_GLANCES = 12, 5
#: ... more than so many readings of one law only where there is room ...
READINGS = 3
#: ... with at least this share of the best's predicted gain.
PROMISING = 0.03
#: Beside the arm alone also the best of every kind of physics that none of them is of, with at least this share of the best's
#: predicted gain: a kind that is never looked at speaks neither for itself nor against another.
OF_ITS_KIND = 0.25
#: Two readings of one law whose predicted gains differ by less than this are the same on these recordings.
ALIKE = 1e-6
#: A law is tried with a size of its own at each level where that should leave no more than this share of what one size leaves.
SIZES_APART = 0.7


def screened(bases: Sequence[Candidate], parts: Sequence[Part], crew: Crew) -> list[list[Guess]]:
    """For each of some models what to look at, the likeliest first: of the arm alone more than of each of many."""
    enough = GLANCES if len(bases) == 1 else BEAM_GLANCES
    found = []
    for base, guesses in zip(bases, promising(bases, parts, crew), strict=True):
        ranked = _of_many_laws(guesses)
        found.append(ranked[:enough] + (_of_other_kinds(ranked, enough) if not base.names else []))
    return found


def passed_over(base: Candidate, parts: Sequence[Part], looked_at: Sequence[Guess], crew: Crew) -> list[Guess]:
    """The likeliest reading of every law of which none was looked at, the likeliest law first, whatever a probe says of them.

    A probe takes what a law changes as linear in its size. Where a swing is missed by more than that holds for, it may promise
    most of laws that are worth nothing, and nothing of play.
    """
    seen = {guess.hypothesis.parts[-1].name for guess in looked_at}
    guesses = crew.guess(base, [part for part in parts if part.name not in seen and not part.levels])
    best: dict[str, Guess] = {}
    for guess in sorted(guesses, key=lambda guess: -guess.gain):
        best.setdefault(guess.hypothesis.parts[-1].name, guess)
    return list(best.values())


def promising(bases: Sequence[Candidate], parts: Sequence[Part], crew: Crew) -> list[list[Guess]]:
    """What to add to each of some models, what should help most by a probe first; nothing that would help next to none."""
    answers = crew.guess_each([(base, [part for part in parts if part.name not in base.names]) for base in bases])
    ranked = [_told_apart(sorted(guesses, key=lambda guess: -guess.gain)) for guesses in answers]
    if not any(base.names for base in bases):  # damping hides what is late where it was fitted without any law
        ranked = [sorted(_no_less_than_special_cases(guesses), key=lambda guess: -guess.gain) for guesses in ranked]
    return [[guess for guess in guesses if guess.gain >= PROMISING * guesses[0].gain] for guesses in ranked]


def _told_apart(guesses: Sequence[Guess]) -> list[Guess]:
    """The first of each reading of a law; the others make no difference, as where a law differs for torques that never came.

    Sizes of its own at each level are one only where they are to take away much of what one size for all would leave.
    """
    kept: list[Guess] = []
    for guess in guesses:
        part = guess.hypothesis.parts[-1]
        one_size = max((other.gain for other in guesses if part.contains(other.hypothesis.parts[-1])), default=0.0)
        if part.levels and 1 - guess.gain > SIZES_APART * (1 - one_size):
            continue
        if not any(other.hypothesis.parts[-1].name == part.name and abs(other.gain - guess.gain) < ALIKE for other in kept):
            kept.append(guess)
    return kept


def _of_many_laws(guesses: Sequence[Guess]) -> list[Guess]:
    """In their order, but the first few readings of every law before the others: a law of many shall not crowd out others."""
    seen: Counter[str] = Counter()
    later: list[bool] = []
    for guess in guesses:
        name = guess.hypothesis.parts[-1].name
        later.append(seen[name] >= READINGS)
        seen[name] += 1
    return [guess for _, guess in sorted(zip(later, guesses, strict=True), key=lambda each: each[0])]


def _of_other_kinds(guesses: Sequence[Guess], enough: int) -> list[Guess]:
    """Beyond the first so many, the best of every kind that none of those is of, where it is worth a look."""
    seen, found = {guess.hypothesis.parts[-1].kind for guess in guesses[:enough]}, []
    for guess in guesses[enough:]:
        if (kind := guess.hypothesis.parts[-1].kind) not in seen and guess.gain >= OF_ITS_KIND * guesses[0].gain:
            seen.add(kind)
            found.append(guess)
    return found


def _no_less_than_special_cases(guesses: Sequence[Guess]) -> list[Guess]:
    """Of a law that contains others, as a probe may not show where damping hides what is late, at least their gain."""
    gains = {part.name: guess.gain for guess in reversed(guesses) if not (part := guess.hypothesis.parts[-1]).levels}
    laws = ((guess, guess.hypothesis.parts[-1].effect) for guess in guesses)
    inside = [[gains.get(name, 0.0) for name in law.contains] if law else [] for guess, law in laws]
    return [replace(guess, gain=max(guess.gain, *known, 0.0)) for guess, known in zip(guesses, inside, strict=True)]
