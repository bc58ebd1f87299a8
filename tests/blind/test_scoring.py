"""The score counts right verdicts, and counts a wrong name against the diagnosis."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.outcome import ALL, GRADES, IN, NOT_IN, SOME, WRONG
from hsr_pin.blind.picture import draw, meaning
from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.scoring import score, scored
from hsr_pin.cli.blind_report import report
from hsr_pin.errors import InputError

SIZES = ("barely", "medium", "large")
SINGLES = [Answer(f"case_{k:03d}", "single", (name,), SIZES[k % 3], {}) for k, name in enumerate(CATALOGUE, 1)]
PAIR = Answer("case_020", "pair", ("backlash", "tip_mass"), "", {})
NONE = Answer("case_021", "none", (), "", {})
OUT = Answer("case_022", "outside", (next(iter(OUTSIDE)),), "medium", {})
ANSWERS = [*SINGLES, PAIR, NONE, OUT]


def verdict(status, *sets, left=1.0):
    """Return a document like those of ``hsr-diagnose``: identified (one set), ambiguous (several), or no set."""
    ladder = [("declared model", 10.0), ("stiffness and damping", 5.0), ("effect", left), ("noise floor", 0.4)]
    return {
        "verdict": {
            "status": status,
            "effects": sorted(set.intersection(*map(set, sets))) if sets else [],
            "alternatives": [sorted(each) for each in sets] if status == "ambiguous" else [],
            "sentence": f"{status}: {sets}",
        },
        "ladder": [{"rung": name, "heldout_rms_mm": rms} for name, rms in ladder],
    }


def perfect():
    said = {a.name: verdict("identified", a.effects) for a in ANSWERS if a.kind in ("single", "pair")}
    return said | {NONE.name: verdict("parameters"), OUT.name: verdict("unexplained")}


def one(answer, said):
    return score([answer], {answer.name: said}).outcomes[0]


def test_perfect_verdicts_score_all_and_miss_nothing():
    found = score(ANSWERS, perfect())
    assert found.misses == ()
    assert found.rates["wrong names, all cases"] == Rate(0, 22)
    assert found.rates["any name, none and outside"] == Rate(0, 2)
    assert found.rates["exact, single effects of medium and large size"] == Rate(13, 13)
    assert sum(map(sum, found.counts)) == 22
    for row, counts in zip(found.rows, found.counts, strict=True):
        right = {"pair": ALL, "none": "parameters", "outside": "unexplained"}.get(row, row)
        assert counts[found.columns.index(right)] == 1


def test_a_wrong_name_raises_the_rate_of_wrong_names():
    for answer in (SINGLES[0], PAIR, NONE, OUT):
        said = perfect() | {answer.name: verdict("identified", ["dry_friction"])}
        found = score(ANSWERS, said)
        assert found.rates["wrong names, all cases"] == Rate(1, 22)
        assert [outcome.answer for outcome in found.misses] == [answer]


@pytest.mark.parametrize(
    ("said", "exact", "wrong", "column"),
    [
        (verdict("identified", ["backlash"]), True, False, "backlash"),
        (verdict("identified", ["tip_mass"]), False, True, "tip_mass"),
        (verdict("identified", ["backlash", "tip_mass"]), False, True, WRONG),
        (verdict("ambiguous", ["tip_mass"], ["backlash"]), True, False, IN),
        (verdict("ambiguous", ["tip_mass"], ["soft_spot"]), False, True, NOT_IN),
        (verdict("ambiguous", ["backlash", "tip_mass"], ["backlash", "soft_spot"]), False, True, NOT_IN),
        (verdict("parameters"), False, False, "parameters"),
        (verdict("insufficient"), False, False, "insufficient"),
        ({"dataset": "case_001", "error": "ValueError: no"}, False, False, "error"),
    ],
)
def test_each_verdict_on_a_single_effect_counts_as_what_it_is(said, exact, wrong, column):
    outcome = one(Answer("case_001", "single", ("backlash",), "large", {}), said)
    assert (outcome.exact, outcome.wrong_name, outcome.column) == (exact, wrong, column)


@pytest.mark.parametrize(
    ("said", "exact", "wrong", "column"),
    [
        (verdict("identified", ["tip_mass", "backlash"]), True, False, ALL),
        (verdict("identified", ["tip_mass"]), False, False, SOME),
        (verdict("identified", ["tip_mass", "soft_spot"]), False, True, WRONG),
        (verdict("ambiguous", ["tip_mass"], ["soft_spot"]), False, False, NOT_IN),
    ],
)
def test_half_of_a_pair_is_a_miss_but_not_a_wrong_name(said, exact, wrong, column):
    outcome = one(PAIR, said)
    assert (outcome.exact, outcome.wrong_name, outcome.column) == (exact, wrong, column)


def test_where_nothing_is_to_be_named_alternatives_are_wrong_names_too():
    for answer in (NONE, OUT):
        outcome = one(answer, verdict("ambiguous", ["tip_mass"], ["soft_spot"]))
        assert outcome.wrong_name and not outcome.exact
    assert one(NONE, verdict("no_gap")).exact
    assert not one(NONE, verdict("unexplained")).exact
    assert not one(OUT, verdict("parameters")).exact


def test_shrinkage_is_compared_with_the_oracle():
    names = [answer.name for answer in SINGLES[:3]]
    said = {name: verdict("identified", ["backlash"], left=left) for name, left in zip(names, (1.0, 1.3, 2.0), strict=True)}
    found = score(SINGLES, said, dict.fromkeys(names[:2], 1.0) | {names[2]: 0.5})
    assert [(o.shrinkage, o.oracle) for o in found.outcomes] == [(0.8, 0.8), (0.74, 0.8), (0.6, 0.9)]
    assert found.rates["shrinkage within 10 % of the oracle's"] == Rate(2, 3)
    assert score(SINGLES, said).rates["shrinkage within 10 % of the oracle's"] == Rate(0, 0)


def test_cases_without_a_verdict_are_listed_and_not_counted():
    found = score(ANSWERS, {"case_001": verdict("parameters")})
    assert len(found.outcomes) == 1
    assert found.missing == tuple(answer.name for answer in ANSWERS[1:])
    assert "1 cases diagnosed, 21 not diagnosed: case_002" in report(found)


def test_an_interval_is_that_of_clopper_and_pearson():
    low, high = Rate(0, 100).interval
    assert (low, high) == (0.0, pytest.approx(1 - 0.025 ** (1 / 100)))
    assert str(Rate(0, 0)) == "no case"


def test_the_report_contains_every_rate_and_every_miss():
    said = perfect() | {"case_005": verdict("identified", ["tip_mass"]), NONE.name: verdict("unexplained")}
    answers = [replace(answer, facts={"program": "steps", "mount": "upright"}) for answer in ANSWERS]
    text = report(score(answers, said))
    assert "2 misses:" in text and "WRONG NAME" in text and "nothing (none, steps, upright)" in text
    rates = score(answers, said).rates
    assert all((name in text) == (rate.of > 0) for name, rate in rates.items()) and "wrong names, all cases" in text
    assert max(map(len, text.splitlines())) < 130


def test_the_document_contains_the_numbers_of_the_report():
    document = score(ANSWERS, perfect()).document()
    assert document["rates"]["exact, pair"] == {"hits": 1, "of": 1, "ci95": [pytest.approx(0.025), 1.0]}
    assert len(document["outcomes"]) == document["cases"] == 22
    assert len(document["confusion"]["counts"]) == len(document["confusion"]["rows"])


def test_the_picture_is_drawn_and_colours_by_what_is_right(tmp_path):
    draw(score(ANSWERS, perfect()), tmp_path / "matrix.png")
    assert (tmp_path / "matrix.png").stat().st_size > 10_000
    assert {grade: meaning(grade) for grade in GRADES} == {
        "right": "right", "exact": "right", "alternatives": "right", "wrong": "wrong",
        "kind": "nameless", "part": "nameless", "silent": "nameless",
    }  # fmt: skip


def test_a_document_that_is_no_score_is_refused():
    with pytest.raises(InputError, match="score"):
        scored({"outcomes": [{"name": "case_001"}], "missing": []})
