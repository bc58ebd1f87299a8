"""Outcome of one case: what the verdict reports, and whether it is right.

A verdict offers sets of names: one if it is identified, several if it is ambiguous. It may report a kind of physics without a
name. A verdict that identifies in part claims only its reported names and kinds. If these are not the truth, but one of its
alternatives is, its alternatives are what it offers, as in an ambiguous verdict. The flexible law of a kind stands for that kind.
What is right depends on the tier:

- A set is right if it has a right name for every effect, and no further names except small effects that are truly present and
  may be noticed. Kinds are compared with the main effect only.
- ``forms``: a name of the right kind is neither wrong nor the right name: friction in another form may resemble hysteresis more
  than the catalogue's friction.
- ``real``: further names besides the right one do not count (`hsr_pin.blind.real.recipes` gives the reason).
- No effect: to name nothing is right; for a messy arm it is also right to report an unexplained gap, because there is one.
- ``outside``: laws that the catalogue did not contain when the plants were written. To name nothing is right; so is an equivalent
  name, if the catalogue now contains one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import FLEXIBLE, KINDS, PLAIN_PARAMETERS, kinds_of
from hsr_pin.errors import InputError

#: Kind of case -> statuses that are right if no effect of the catalogue is present.
RIGHT = {"none": ("parameters", "no_gap"), "outside": ("unexplained",), "nothing": ("unchanged",)}
#: Grades of an outcome, the best first: right where nothing is to be named; the truth alone; the truth among alternatives; its
#: kind only; a part of it; nothing reported; something untrue.
GRADES = ("right", "exact", "alternatives", "kind", "part", "silent", "wrong")
#: Columns of the confusion matrix for verdicts that name several effects, together or as alternatives.
ALL, SOME, WRONG, IN, NOT_IN = SEVERAL = (
    "all of several",
    "some of several",
    "several, wrong",
    "alternatives, truth in",
    "alternatives, truth not in",
)

#: Beginnings of the names of the last stages of the error budget, which are no models.
FLOORS = ("not repeatable", "noise floor")


@dataclass(frozen=True)
class Outcome:
    """Outcome of one case.

    Attributes:
        answer: the truth.
        status: status of the verdict; "error" if the diagnosis failed.
        sets: sets of names that the verdict offers: one if identified, several if ambiguous, one, several or none if partly
            identified, otherwise none.
        sentence: the verdict in words.
        shrinkage: relative reduction of the RMS distance that stiffness and damping leave on held-out trials; None if unknown.
        oracle: the same for the true law; None without one.
        kinds: kinds of physics that the verdict reports, including those of reported names.
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
        """Whether the truth was named, alone or among the alternatives; where there is no effect, whether none was named."""
        answer = self.answer
        if answer.kind in RIGHT and not (answer.kind == "outside" and self.sets):
            left = answer.tier == "messy" and answer.kind == "none" and self.status == "unexplained"
            return (left or self.status in RIGHT[answer.kind]) and all(map(self.is_true, self.kinds))
        return any(_is_truth(answer, names) for names in self.sets)

    @property
    def wrong_name(self) -> bool:
        """Whether every offered set of names contains a name that is not true."""
        return (
            bool(self.sets)
            and all(any(not self.is_true(name) for name in names) for names in self.sets)
            and not self._names_cause_or_kind
        )

    @property
    def wrong_kind(self) -> bool:
        """Whether no name is given, and every given kind is not true."""
        return not self.sets and bool(self.kinds) and not any(self.is_true(kind) for kind in self.kinds)

    @property
    def kind_right(self) -> bool:
        """Whether the kind of each effect is reported: by a name, by kinds none of which is false, or in an alternative."""
        if not self.answer.kinds:
            return False
        if self.answer.kind not in RIGHT and self.exact:
            return True
        certain = all(self.is_true(kind) for kind in self.kinds) or self.answer.tier == "real"
        return (certain and self._covers(self.kinds)) or (
            len(self.sets) > 1 and any(self._covers(main_kind(name) for name in names) for names in self.sets)
        )

    @property
    def grade(self) -> str:
        """Grade of the outcome, one of `GRADES`."""
        if self.exact:
            return "right" if self.answer.kind in RIGHT else "exact" if len(self.sets) == 1 else "alternatives"
        if self.wrong_name or self.wrong_kind:
            return "wrong"
        if self.kind_right:
            return "kind"
        return "part" if self.sets or self.kinds else "silent"

    @property
    def row(self) -> str:
        """Row in the confusion matrix."""
        return self.answer.effects[0] if self.answer.kind in ("single", "form") else self.answer.kind

    @property
    def column(self) -> str:
        """Column in the confusion matrix."""
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

    def is_true(self, claim: str) -> bool:
        """Return whether a name or a kind is true of the case; for a real arm, whether it may be true."""
        answer = self.answer
        own = answer.facts.get("own", ())
        claim = main_kind(claim) if claim in FLEXIBLE else claim
        if claim in KINDS:  # kinds of small effects do not count: among so many effects, nearly every kind would be true
            return claim in own or any(claim in kinds for kinds in answer.kinds)
        if claim in answer.background or any(claim in names for names in answer.names):
            return True
        if answer.tier == "forms":
            return main_kind(claim) in answer.kinds[0]
        return answer.tier == "real" and (main_kind(claim) in own or main_kind(claim) in answer.kinds[0])

    @property
    def _names_cause_or_kind(self) -> bool:
        """Whether the withheld cause of a real case, or its kind, is reported; further names then do not count."""
        return self.answer.tier == "real" and (self.exact or self._covers(self.kinds))

    def _covers(self, kinds: Iterable[str]) -> bool:
        reported = set(kinds)
        return bool(self.answer.kinds) and all(reported & set(right) for right in self.answer.kinds)


def outcome_of(answer: Answer, verdict: dict[str, Any], oracle_mm: float | None) -> Outcome:
    """Return the outcome from a document of ``hsr-diagnose``; older documents have neither kinds nor confidence.

    Raises:
        InputError: the document has the wrong format.
    """
    with readable(answer):
        return _outcome(answer, verdict, oracle_mm)


@contextmanager
def readable(answer: Answer) -> Iterator[None]:
    """Convert errors from reading a verdict into one line that names the verdict.

    Raises:
        InputError: the verdict has the wrong format.
    """
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        wanted, hint = "a document written by hsr-blind run", "delete it, and hsr-blind run diagnoses this case again"
        raise InputError(f"verdict of {answer.name}", expected=wanted, received=repr(error), hint=hint) from error


def _outcome(answer: Answer, verdict: dict[str, Any], oracle_mm: float | None) -> Outcome:
    if "error" in verdict:
        return Outcome(answer, "error", (), verdict["error"], None, None)
    reported = verdict["verdict"]
    sets = _sets(answer, reported)
    before, after = _remaining_rms(verdict.get("ladder", ()))
    return Outcome(
        answer,
        reported["status"],
        sets,
        reported.get("sentence", ""),
        None if before is None or after is None else 1 - after / before,
        None if before is None or oracle_mm is None else 1 - oracle_mm / before,
        _kinds(reported.get("kinds") or (), sets),
        _confidence(answer, reported.get("confidence") or {}),
    )


def main_kind(name: str) -> str:
    """Return the main kind of physics of a name; for an unknown name, the name itself."""
    return next(iter(kinds_of(name)), name)


def _sets(answer: Answer, reported: dict[str, Any]) -> tuple[frozenset[str], ...]:
    status, certain = reported["status"], frozenset(reported.get("effects") or ())
    alternatives = tuple(frozenset(names) for names in reported.get("alternatives") or ())
    if status == "ambiguous" and alternatives:
        return alternatives
    truth_in = any(certain <= names and _is_truth(answer, names) for names in alternatives)
    if status == "partly_identified" and alternatives and (truth_in or not certain) and not _is_truth(answer, certain):
        return alternatives  # names are offered, although only a kind is reported
    named = status in ("identified", "partly_identified", "ambiguous") and certain
    return (certain,) if named else ()


def _is_truth(answer: Answer, names: frozenset[str]) -> bool:
    found = bool(answer.names) and all(names & set(right) for right in answer.names)
    known = {name for right in answer.names for name in right} | set(answer.background)
    return found and (answer.tier == "real" or names <= known)


def _kinds(stated: Iterable[str], sets: tuple[frozenset[str], ...]) -> tuple[str, ...]:
    """Return the stated kinds, and the kinds that all sets of names have in common."""
    implied = set.intersection(*({main_kind(name) for name in names} for names in sets)) if sets else set()
    return tuple(sorted(set(stated) | implied))


def _confidence(answer: Answer, stated: dict[str, Any]) -> tuple[tuple[str, float], ...]:
    for claim, value in stated.items():
        if not (isinstance(value, (int, float)) and 0 <= value <= 1):
            raise InputError(f"{answer.name}: confidence in {claim}", expected="a number from 0 to 1", received=value)
    counted = {claim: float(value) for claim, value in stated.items() if claim not in PLAIN_PARAMETERS or answer.tier == "change"}
    return tuple(sorted(counted.items()))


def _remaining_rms(ladder: Iterable[dict[str, Any]]) -> tuple[float | None, float | None]:
    """Return the held-out RMS distance [mm] with stiffness and damping, and with all that was found."""
    rungs = {rung["rung"]: rung["heldout_rms_mm"] for rung in ladder if not rung["rung"].startswith(FLOORS)}
    before = rungs.get("stiffness and damping")
    return (None, None) if before is None else (before, list(rungs.values())[-1])
