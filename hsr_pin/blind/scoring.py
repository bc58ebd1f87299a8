"""Score of a blind check: verdicts compared with answers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.outcome import GRADES, RIGHT, SEVERAL, Outcome, outcome_of
from hsr_pin.blind.plants.laws import CATALOGUE
from hsr_pin.blind.plants.scaling import SIZES
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.reliability import Reliability, reliability
from hsr_pin.errors import InputError

#: Statuses of verdicts without names, and of failed diagnoses.
NAMELESS = ("parameters", "no_gap", "unexplained", "insufficient", "error")
#: Further facts of a case in a score.
FACTS = ("program", "mount", "plant")
#: Facts of a case that decide whether a verdict is right.
DECIDING = ("own",)
#: Share of the oracle's shrinkage from which a shrinkage counts as equal to it.
NEAR_ORACLE = 0.9


@dataclass(frozen=True)
class Score:
    """Score of a check.

    Attributes:
        outcomes: outcomes of all diagnosed cases.
        missing: names of the cases without a diagnosis.
        rates: rates by their description.
        rows: rows of the confusion matrix.
        columns: columns of the confusion matrix.
        counts: entries of the confusion matrix, [row][column].
    """

    outcomes: tuple[Outcome, ...]
    missing: tuple[str, ...]
    rates: dict[str, Rate]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]

    @property
    def misses(self) -> tuple[Outcome, ...]:
        """Outcomes of all cases that were not answered exactly."""
        return tuple(outcome for outcome in self.outcomes if not outcome.exact)

    @property
    def tiers(self) -> tuple[str, ...]:
        """Names of the tiers with at least one case."""
        return tuple(dict.fromkeys(outcome.answer.tier for outcome in self.outcomes))

    def grades(self, tier: str, kind: str) -> dict[str, int]:
        """Return the number of cases of a tier and kind for each grade."""
        found = Counter(o.grade for o in self.outcomes if (o.answer.tier, o.answer.kind) == (tier, kind))
        return {grade: found[grade] for grade in GRADES}

    def reliability(self) -> Reliability | None:
        """Return the reliability of the stated confidences; None if none was stated."""
        claims = [[(value, outcome.is_true(claim)) for claim, value in outcome.confidence] for outcome in self.outcomes]
        return reliability(claims) if any(claims) else None

    def document(self) -> dict[str, Any]:
        """Return the score as a JSON document."""
        trust = self.reliability()
        more = {} if trust is None else {"reliability": trust.document()}
        return {
            "cases": len(self.outcomes),
            "missing": list(self.missing),
            "rates": {name: rate.document() for name, rate in self.rates.items()},
            "confusion": {"rows": list(self.rows), "columns": list(self.columns), "counts": [list(row) for row in self.counts]},
            **more,
            "outcomes": [document_of(outcome) for outcome in self.outcomes],
        }


def score(answers: Sequence[Answer], verdicts: Mapping[str, dict[str, Any]], oracle: Mapping[str, float] | None = None) -> Score:
    """Compare verdicts with answers.

    Args:
        answers: answers of all cases.
        verdicts: document of ``hsr-diagnose`` for each name of a case.
        oracle: held-out RMS distance of the true law [mm] for each name of a case.

    Raises:
        InputError: a verdict has the wrong format.
    """
    known = oracle or {}
    found = tuple(outcome_of(each, verdicts[each.name], known.get(each.name)) for each in answers if each.name in verdicts)
    return _tally(found, tuple(each.name for each in answers if each.name not in verdicts))


def scored(document: dict[str, Any]) -> Score:
    """Return the score from a document that :meth:`Score.document` returned.

    Raises:
        InputError: the document has the wrong format.
    """
    try:
        return _tally(tuple(map(outcome_from, document["outcomes"])), tuple(document["missing"]))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError("score", expected="a document written by hsr-blind score --json", received=repr(error)) from error


def _tally(found: tuple[Outcome, ...], missing: tuple[str, ...]) -> Score:
    rows = _with_others((*CATALOGUE, "pair", "none", "outside"), (outcome.row for outcome in found))
    columns = _with_others((*CATALOGUE, *SEVERAL, *NAMELESS), (outcome.column for outcome in found))
    cells = Counter((outcome.row, outcome.column) for outcome in found)
    counts = tuple(tuple(cells[row, column] for column in columns) for row in rows)
    return Score(found, missing, _rates(found), rows, columns, counts)


def _with_others(known: Sequence[str], used: Iterable[str]) -> tuple[str, ...]:
    return (*known, *sorted(set(used) - set(known)))


def _rates(found: Sequence[Outcome]) -> dict[str, Rate]:
    clean = [o for o in found if o.answer.tier == "clean"]
    single = [o for o in clean if o.answer.kind == "single"]
    unnamed = [o for o in found if o.answer.kind in RIGHT]
    judged = [o for o in found if o.oracle is not None and o.shrinkage is not None]
    clear = [o for o in single if o.answer.size in ("medium", "large")]
    named = [o for o in found if o.status == "ambiguous"]
    return {
        "exact, single effects of medium and large size": _exact(clear),
        **{f"exact, single effects, {size}": _exact([o for o in single if o.answer.size == size]) for size in ("below", *SIZES)},
        **{f"exact, {kind}": _exact([o for o in clean if o.answer.kind == kind]) for kind in ("pair", "none", "outside")},
        **_tier_rates(found),
        "wrong names, all cases": Rate.among(o.wrong_name for o in found),
        "any name, none and outside": Rate.among(bool(o.sets) and not o.exact for o in unnamed),
        "truth among the alternatives, ambiguous verdicts": _exact(named),
        "shrinkage within 10 % of the oracle's": Rate.among(map(_near_oracle, judged)),
    }


def _tier_rates(found: Sequence[Outcome]) -> dict[str, Rate]:
    """Return the rates of the tiers other than the clean one, for tiers with cases."""
    by = {
        tier: [o for o in found if o.answer.tier == tier and o.answer.kind not in RIGHT]
        for tier in ("messy", "forms", "space", "others", "real")
    }
    rates: dict[str, Rate] = {}
    for tier, cases in by.items():
        plants = sorted({o.answer.facts.get("plant", "") for o in cases}) if tier == "others" else ()
        for plant in plants:
            own = [o for o in cases if o.answer.facts.get("plant") == plant]
            rates[f"{plant}: exact or among the alternatives"] = _exact(own)
            rates[f"{plant}: wrong"] = Rate.among(o.grade == "wrong" for o in own)
        if cases:
            rates[f"{tier}: exact or among the alternatives"] = _exact(cases)
            rates[f"{tier}: kind right"] = Rate.among(o.kind_right for o in cases)
            rates[f"{tier}: silent"] = Rate.among(o.grade == "silent" for o in cases)
            rates[f"{tier}: wrong"] = Rate.among(o.grade == "wrong" for o in cases)
    if {o.answer.tier for o in found} - {"clean"}:
        for kind in ("none", "outside"):
            messy = [o for o in found if (o.answer.tier, o.answer.kind) == ("messy", kind)]
            rates[f"messy: no name, {kind}"] = Rate.among(not o.sets or o.exact for o in messy)
        outside = [o for o in found if o.answer.kind == "outside"]
        rates["kind right, outside"] = Rate.among(o.kind_right for o in outside)
    return rates


def _exact(among: Sequence[Outcome]) -> Rate:
    return Rate.among(o.exact for o in among)


def _near_oracle(outcome: Outcome) -> bool:
    return outcome.shrinkage is not None and outcome.oracle is not None and outcome.shrinkage >= NEAR_ORACLE * outcome.oracle


def document_of(outcome: Outcome) -> dict[str, Any]:
    """Return an outcome as a JSON document."""
    answer = outcome.answer
    return {
        "name": answer.name,
        "tier": answer.tier,
        "kind": answer.kind,
        "effects": list(answer.effects),
        "size": answer.size,
        "right_names": [list(names) for names in answer.names],
        "right_kinds": [list(kinds) for kinds in answer.kinds],
        "background": list(answer.background),
        "facts": {name: answer.facts[name] for name in (*FACTS, *DECIDING) if name in answer.facts},
        "status": outcome.status,
        "sets": [sorted(names) for names in outcome.sets],
        "kinds": list(outcome.kinds),
        "confidence": dict(outcome.confidence),
        "grade": outcome.grade,
        "exact": outcome.exact,
        "wrong_name": outcome.wrong_name,
        "shrinkage": outcome.shrinkage,
        "oracle": outcome.oracle,
        "sentence": outcome.sentence,
    }


def outcome_from(document: dict[str, Any]) -> Outcome:
    """Return the outcome from a document that :func:`document_of` returned."""
    answer = Answer(
        document["name"],
        document["kind"],
        tuple(document["effects"]),
        document["size"],
        document["facts"],
        document["tier"],
        tuple(map(tuple, document["right_names"])),
        tuple(map(tuple, document["right_kinds"])),
        tuple(document["background"]),
    )
    reported = {name: document[name] for name in ("status", "sentence", "shrinkage", "oracle")}
    sets = tuple(frozenset(names) for names in document["sets"])
    confidence = tuple(sorted(document["confidence"].items()))
    return Outcome(answer, sets=sets, kinds=tuple(document["kinds"]), confidence=confidence, **reported)
