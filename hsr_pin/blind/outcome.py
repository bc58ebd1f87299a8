"""One case, answered: what was said, and whether it is right.

A verdict offers sets of names: one if it is identified, several if it is ambiguous. It may be certain of kinds without a name.
One that identifies in part claims no more than its certain names and kinds; where they are not the truth but one of its
alternatives is, these are what it offers, as an ambiguous one does. The flexible law of a kind stands for that kind. What is
right, by tier:

- A set is right if it has a right name for every effect, and beside them none but small effects that are truly there and may
  be noticed. Kinds are held against the main effect alone.
- ``forms``: a name of the right kind is no wrong name, though not the right one either: friction in another form may well look
  more like hysteresis than like the catalogue's friction.
- ``real``: other names beside the right one do not count (`hsr_pin.blind.real.recipes` says why).
- Nothing there: to name nothing is right; of a messy arm also to say that something is left, for so it is.
- ``outside``: laws that the catalogue did not hold when the plants were written. To name nothing is right; so is a name
  that says the same, where the catalogue has come to hold one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import FLEXIBLE, KINDS, PLAIN, kinds_of
from hsr_pin.errors import InputError

#: Kind of case -> verdicts that are right where no effect of the catalogue is at work.
RIGHT = {"none": ("parameters", "no_gap"), "outside": ("unexplained",), "nothing": ("unchanged",)}
#: Grades of an outcome, the best first: as it should be where nothing is to be named; the truth alone; among alternatives; its
#: kind only; a part of it; nothing; and what is not so.
GRADES = ("right", "exact", "alternatives", "kind", "part", "silent", "wrong")
#: Columns of the confusion matrix for verdicts that name several effects, together or as alternatives.
ALL, SOME, WRONG, IN, NOT_IN = SEVERAL = (
    "all of several",
    "some of several",
    "several, wrong",
    "alternatives, truth in",
    "alternatives, truth not in",
)

#: Rungs at the ladder's foot, which are no models, begin with these.
FLOORS = ("not repeatable", "noise floor")


@dataclass(frozen=True)
class Outcome:
    """One case, answered.

    Attributes:
        answer: the truth.
        status: of the verdict; "error" where the diagnosis failed.
        sets: of names that the verdict offers: one if identified, several if ambiguous, either or none if partly identified,
            none otherwise.
        sentence: the verdict in words.
        shrinkage: share of the RMS distance left by stiffness and damping that is gone, on held-out trials; None if unknown.
        oracle: the same for the true law; None without one.
        kinds: of which the verdict is certain, those of certain names among them.
        confidence: names and kinds with the probability that the verdict gives them.
    """

    answer: Answer
    status: str
    sets: tuple[frozenset[str], ...]
    sentence: str
    shrinkage: float | None
    oracle: float | None
    kinds: tuple[str, ...] = ()
    confidence: tuple[tuple[str, float], ...] = ()

    @property
    def exact(self) -> bool:
        """Whether the truth is what was named, or among the alternatives stated; whether nothing was named where nothing is."""
        answer = self.answer
        if answer.kind in RIGHT and not (answer.kind == "outside" and self.sets):
            left = answer.tier == "messy" and answer.kind == "none" and self.status == "unexplained"
            return (left or self.status in RIGHT[answer.kind]) and all(map(self.is_so, self.kinds))
        return any(_is_truth(answer, names) for names in self.sets)

    @property
    def wrong_name(self) -> bool:
        """Whether every set of names on offer has one in it that is not so."""
        return bool(self.sets) and all(any(not self.is_so(name) for name in names) for names in self.sets) and not self._at_it

    @property
    def wrong_kind(self) -> bool:
        """Whether no name is given, and every kind that is given is not so."""
        return not self.sets and bool(self.kinds) and not any(self.is_so(kind) for kind in self.kinds)

    @property
    def kind_right(self) -> bool:
        """Whether each effect was named rightly, or its kind is certain (and none that is not so), or is in an alternative."""
        if not self.answer.kinds:
            return False
        if self.answer.kind not in RIGHT and self.exact:
            return True
        certain = all(self.is_so(kind) for kind in self.kinds) or self.answer.tier == "real"
        return (certain and self._covers(self.kinds)) or (
            len(self.sets) > 1 and any(self._covers(main_kind(name) for name in names) for names in self.sets)
        )

    @property
    def grade(self) -> str:
        """One of `GRADES`."""
        if self.exact:
            return "right" if self.answer.kind in RIGHT else "exact" if len(self.sets) == 1 else "alternatives"
        if self.wrong_name or self.wrong_kind:
            return "wrong"
        if self.kind_right:
            return "kind"
        return "part" if self.sets or self.kinds else "silent"

    @property
    def row(self) -> str:
        """In the confusion matrix."""
        return self.answer.effects[0] if self.answer.kind in ("single", "form") else self.answer.kind

    @property
    def column(self) -> str:
        """In the confusion matrix."""
        if not self.sets:
            return self.status
        if len(self.sets) > 1:
            return IN if self.exact else NOT_IN
        names = self.sets[0]
        if names < set(self.answer.effects):
            return SOME
        if len(names) > 1:
            return ALL if self.exact else WRONG
        return next(iter(names), self.status)

    def is_so(self, claim: str) -> bool:
        """Whether a name or a kind is true of the case; of a real arm, whether it may be."""
        answer = self.answer
        own = answer.facts.get("own", ())
        claim = main_kind(claim) if claim in FLEXIBLE else claim
        if claim in KINDS:  # not those of small effects: among so many, nearly every kind would be so
            return claim in own or any(claim in kinds for kinds in answer.kinds)
        if claim in answer.background or any(claim in names for names in answer.names):
            return True
        if answer.tier == "forms":
            return main_kind(claim) in answer.kinds[0]
        return answer.tier == "real" and (main_kind(claim) in own or main_kind(claim) in answer.kinds[0])

    @property
    def _at_it(self) -> bool:
        """Whether a real cause is named, or its kind is: then other names are not counted."""
        return self.answer.tier == "real" and (self.exact or self._covers(self.kinds))

    def _covers(self, kinds: Iterable[str]) -> bool:
        said = set(kinds)
        return bool(self.answer.kinds) and all(said & set(right) for right in self.answer.kinds)


def outcome_of(answer: Answer, verdict: dict[str, Any], oracle_mm: float | None) -> Outcome:
    """From what ``hsr-diagnose`` wrote; older verdicts have neither kinds nor confidence.

    Raises:
        InputError: it wrote something else.
    """
    with readable(answer):
        return _outcome(answer, verdict, oracle_mm)


@contextmanager
def readable(answer: Answer) -> Iterator[None]:
    """Within this what is not as a verdict should be ends in one line.

    Raises:
        InputError: saying which verdict it is.
    """
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        wanted, hint = "what hsr-blind run wrote", "delete it, and hsr-blind run diagnoses this case again"
        raise InputError(f"verdict of {answer.name}", expected=wanted, received=repr(error), hint=hint) from error


def _outcome(answer: Answer, verdict: dict[str, Any], oracle_mm: float | None) -> Outcome:
    if "error" in verdict:
        return Outcome(answer, "error", (), verdict["error"], None, None)
    said = verdict["verdict"]
    sets = _sets(answer, said)
    before, after = _left(verdict.get("ladder", ()))
    return Outcome(
        answer,
        said["status"],
        sets,
        said.get("sentence", ""),
        None if before is None or after is None else 1 - after / before,
        None if before is None or oracle_mm is None else 1 - oracle_mm / before,
        _kinds(said.get("kinds") or (), sets),
        _confidence(answer, said.get("confidence") or {}),
    )


def main_kind(name: str) -> str:
    """What a name says first and foremost; of an unknown one, its name."""
    return next(iter(kinds_of(name)), name)


def _sets(answer: Answer, said: dict[str, Any]) -> tuple[frozenset[str], ...]:
    status, certain = said["status"], frozenset(said.get("effects") or ())
    alternatives = tuple(frozenset(names) for names in said.get("alternatives") or ())
    if status == "ambiguous" and alternatives:
        return alternatives
    truth_in = any(certain <= names and _is_truth(answer, names) for names in alternatives)
    if status == "partly_identified" and alternatives and (truth_in or not certain) and not _is_truth(answer, certain):
        return alternatives  # names on offer, though a kind alone is certain
    named = status in ("identified", "partly_identified", "ambiguous") and certain
    return (certain,) if named else ()


def _is_truth(answer: Answer, names: frozenset[str]) -> bool:
    found = bool(answer.names) and all(names & set(right) for right in answer.names)
    known = {name for right in answer.names for name in right} | set(answer.background)
    return found and (answer.tier == "real" or names <= known)


def _kinds(stated: Iterable[str], sets: tuple[frozenset[str], ...]) -> tuple[str, ...]:
    """Those stated, and those that follow from the names: what all sets have in common."""
    implied = set.intersection(*({main_kind(name) for name in names} for names in sets)) if sets else set()
    return tuple(sorted(set(stated) | implied))


def _confidence(answer: Answer, stated: dict[str, Any]) -> tuple[tuple[str, float], ...]:
    for claim, value in stated.items():
        if not (isinstance(value, (int, float)) and 0 <= value <= 1):
            raise InputError(f"{answer.name}: confidence in {claim}", expected="a number from 0 to 1", received=value)
    counted = {claim: float(value) for claim, value in stated.items() if claim not in PLAIN or answer.tier == "change"}
    return tuple(sorted(counted.items()))


def _left(ladder: Iterable[dict[str, Any]]) -> tuple[float | None, float | None]:
    """Held-out RMS distance [mm] with stiffness and damping, and with all that was found."""
    rungs = {rung["rung"]: rung["heldout_rms_mm"] for rung in ladder if not rung["rung"].startswith(FLOORS)}
    before = rungs.get("stiffness and damping")
    return (None, None) if before is None else (before, list(rungs.values())[-1])
