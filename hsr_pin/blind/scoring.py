"""How often the diagnosis was right: verdicts against answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.plants.laws import CATALOGUE
from hsr_pin.blind.plants.scaling import SIZES
from hsr_pin.errors import InputError

#: Verdicts that name nothing, and one that never came.
NAMELESS = ("parameters", "no_gap", "unexplained", "insufficient", "error")
#: Which of them are right where no effect of the catalogue is at work.
RIGHT = {"none": ("parameters", "no_gap"), "outside": ("unexplained",)}
#: Columns of the confusion matrix for verdicts that name several effects, together or as alternatives.
ALL, SOME, WRONG, IN, NOT_IN = SEVERAL = (
    "all of several",
    "some of several",
    "several, wrong",
    "alternatives, truth in",
    "alternatives, truth not in",
)
#: What else a score tells of a case.
FACTS = ("program", "mount", "plant")
#: A shrinkage this share of the oracle's is as good as it gets.
CLOSE = 0.9


@dataclass(frozen=True)
class Outcome:
    """One case, answered.

    Attributes:
        answer: the truth.
        status: of the verdict; "error" where the diagnosis failed.
        sets: of names that the verdict offers: one if identified, several if ambiguous, none otherwise.
        sentence: the verdict in words.
        shrinkage: share of the RMS distance left by stiffness and damping that is gone, on held-out trials; None if unknown.
        oracle: the same for the true law; None without one.
    """

    answer: Answer
    status: str
    sets: tuple[frozenset[str], ...]
    sentence: str
    shrinkage: float | None
    oracle: float | None

    @property
    def exact(self) -> bool:
        """Whether the truth is what was named, or among the alternatives stated; whether nothing was named where nothing is."""
        if self.answer.kind in RIGHT:
            return self.status in RIGHT[self.answer.kind]
        return frozenset(self.answer.effects) in self.sets

    @property
    def wrong_name(self) -> bool:
        """Whether every set of names on offer has one in it that is not in the truth."""
        truth = set(self.answer.effects) if self.answer.kind not in RIGHT else set()
        return bool(self.sets) and all(names - truth for names in self.sets)

    @property
    def row(self) -> str:
        """In the confusion matrix."""
        return self.answer.effects[0] if self.answer.kind == "single" else self.answer.kind

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
        return next(iter(names))


@dataclass(frozen=True)
class Rate:
    """So many of so many, with the exact 95 % interval of the probability (C. J. Clopper, E. S. Pearson, Biometrika 26, 1934)."""

    hits: int
    of: int

    @property
    def share(self) -> float:
        """0 to 1; nan of nothing."""
        return self.hits / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 %."""
        from scipy.stats import binomtest

        if not self.of:
            return 0.0, 1.0
        low, high = binomtest(self.hits, self.of).proportion_ci()
        return float(low), float(high)

    def __str__(self) -> str:
        if not self.of:
            return "no case"
        low, high = self.interval
        return f"{100 * self.share:.0f} % ({self.hits} of {self.of}; {100 * low:.0f} to {100 * high:.0f} %)"


@dataclass(frozen=True)
class Score:
    """What came of a check.

    Attributes:
        outcomes: of all cases that were diagnosed.
        missing: names of those that were not.
        rates: by what they say.
        rows, columns: of the confusion matrix; counts: [row][column].
    """

    outcomes: tuple[Outcome, ...]
    missing: tuple[str, ...]
    rates: dict[str, Rate]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]

    @property
    def misses(self) -> tuple[Outcome, ...]:
        """Every case that was not answered exactly."""
        return tuple(outcome for outcome in self.outcomes if not outcome.exact)

    def document(self) -> dict[str, Any]:
        """For programs."""
        return {
            "cases": len(self.outcomes),
            "missing": list(self.missing),
            "rates": {name: {"hits": rate.hits, "of": rate.of, "ci95": list(rate.interval)} for name, rate in self.rates.items()},
            "confusion": {"rows": list(self.rows), "columns": list(self.columns), "counts": [list(row) for row in self.counts]},
            "outcomes": [_document(outcome) for outcome in self.outcomes],
        }


def score(answers: Sequence[Answer], verdicts: Mapping[str, dict[str, Any]], oracle: Mapping[str, float] | None = None) -> Score:
    """Hold verdicts against answers.

    Args:
        answers: of all cases.
        verdicts: name of the case -> what ``hsr-diagnose`` wrote.
        oracle: name of the case -> RMS distance [mm] that the true law leaves on held-out trials.
    """
    known = oracle or {}
    found = tuple(_outcome(each, verdicts[each.name], known.get(each.name)) for each in answers if each.name in verdicts)
    return _tally(found, tuple(each.name for each in answers if each.name not in verdicts))


def scored(document: dict[str, Any]) -> Score:
    """The score that :meth:`Score.document` was written from.

    Raises:
        InputError: it is none.
    """
    try:
        return _tally(tuple(map(_read, document["outcomes"])), tuple(document["missing"]))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError("score", expected="what hsr-blind score --json wrote", received=repr(error)) from error


def _tally(found: tuple[Outcome, ...], missing: tuple[str, ...]) -> Score:
    rows = (*CATALOGUE, "pair", "none", "outside")
    columns = (*CATALOGUE, *SEVERAL, *NAMELESS)
    cells = [(outcome.row, outcome.column) for outcome in found]
    counts = tuple(tuple(cells.count((row, column)) for column in columns) for row in rows)
    return Score(found, missing, _rates(found), rows, columns, counts)


def _rates(found: Sequence[Outcome]) -> dict[str, Rate]:
    single = [o for o in found if o.answer.kind == "single"]
    unnamed = [o for o in found if o.answer.kind in RIGHT]
    judged = [o for o in found if o.oracle is not None and o.shrinkage is not None]
    clear = [o for o in single if o.answer.size in ("medium", "large")]
    return {
        "exact, single effects of medium and large size": _exact(clear),
        **{f"exact, single effects, {size}": _exact([o for o in single if o.answer.size == size]) for size in ("below", *SIZES)},
        **{f"exact, {kind}": _exact([o for o in found if o.answer.kind == kind]) for kind in ("pair", "none", "outside")},
        "wrong names, all cases": Rate(sum(o.wrong_name for o in found), len(found)),
        "any name, none and outside": Rate(sum(bool(o.sets) for o in unnamed), len(unnamed)),
        "truth among the alternatives, ambiguous verdicts": _exact([o for o in found if o.status == "ambiguous"]),
        "shrinkage within 10 % of the oracle's": Rate(sum(map(_as_good, judged)), len(judged)),
    }


def _exact(among: Sequence[Outcome]) -> Rate:
    return Rate(sum(o.exact for o in among), len(among))


def _as_good(outcome: Outcome) -> bool:
    return outcome.shrinkage is not None and outcome.oracle is not None and outcome.shrinkage >= CLOSE * outcome.oracle


def _outcome(answer: Answer, verdict: dict[str, Any], oracle_mm: float | None) -> Outcome:
    if "error" in verdict:
        return Outcome(answer, "error", (), verdict["error"], None, None)
    said = verdict["verdict"]
    sets = {"identified": [said["effects"]], "ambiguous": said["alternatives"]}.get(said["status"], [])
    rungs = {rung["rung"]: rung["heldout_rms_mm"] for rung in verdict["ladder"]}
    before, (*_, after, _floor) = rungs.get("stiffness and damping"), rungs.values()  # at the ladder's foot stands the noise
    return Outcome(
        answer,
        said["status"],
        tuple(frozenset(names) for names in sets),
        said["sentence"],
        None if before is None else 1 - after / before,
        None if before is None or oracle_mm is None else 1 - oracle_mm / before,
    )


def _document(outcome: Outcome) -> dict[str, Any]:
    answer = outcome.answer
    return {
        "name": answer.name,
        "kind": answer.kind,
        "effects": list(answer.effects),
        "size": answer.size,
        "facts": {name: answer.facts[name] for name in FACTS if name in answer.facts},
        "status": outcome.status,
        "sets": [sorted(names) for names in outcome.sets],
        "exact": outcome.exact,
        "wrong_name": outcome.wrong_name,
        "shrinkage": outcome.shrinkage,
        "oracle": outcome.oracle,
        "sentence": outcome.sentence,
    }


def _read(document: dict[str, Any]) -> Outcome:
    case = {name: document[name] for name in ("name", "kind", "size", "facts")}
    said = {name: document[name] for name in ("status", "sentence", "shrinkage", "oracle")}
    sets = tuple(frozenset(names) for names in document["sets"])
    return Outcome(Answer(effects=tuple(document["effects"]), **case), sets=sets, **said)
