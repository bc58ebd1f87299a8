"""Verdicts are graded as right, right in kind, silent or wrong, in each tier."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import FLEXIBLE
from hsr_pin.blind.outcome import GRADES, main_kind, outcome_of
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.scoring import score, scored
from hsr_pin.cli.blind_report import report
from hsr_pin.effects.flexible import FLEXIBLE as FLEXIBLE_LAWS
from hsr_pin.errors import InputError

DATA = Path(__file__).resolve().parents[2] / "data"
SMALL = ("viscoelastic", "tip_gust")
MESSY = Answer("case_001", "single", ("dry_friction",), "large", {}, "messy", background=SMALL)
FORM = Answer(
    "case_001", "form", ("actuator_lag",), "large", {}, "forms", (("actuator_lag", "unequal_lag"),), (("actuation_time",),)
)
REAL = Answer(
    "case_001", "real", ("tip_mass",), "", {"own": ["elastic", "creep"]}, "real", (("tip_mass",),), (("mass_gravity",),)
)
NONE = Answer("case_001", "none", (), "", {}, "messy", background=SMALL)
OUTSIDE = Answer("case_001", "outside", ("wall",), "large", {}, "messy", background=SMALL)
PAIR = Answer("case_001", "pair", ("backlash", "tip_mass"), "", {})


def said(status, *sets, kinds=None, confidence=None):
    effects = sorted(set.intersection(*map(set, sets))) if sets else []
    verdict = {"status": status, "effects": effects, "alternatives": [list(s) for s in sets] if len(sets) > 1 else []}
    more = {key: value for key, value in (("kinds", kinds), ("confidence", confidence)) if value is not None}
    return {"verdict": {**verdict, **more, "sentence": "so"}, "ladder": []}


def grade(answer, *args, **more):
    return outcome_of(answer, said(*args, **more), None).grade


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [
        (("identified", ["dry_friction"]), "exact"),
        (("partly_identified", ["dry_friction"]), "exact"),
        (("identified", ["dry_friction", "viscoelastic"]), "exact"),  # a small effect that is truly present
        (("identified", ["dry_friction", "tip_mass"]), "wrong"),
        (("identified", ["viscoelastic"]), "part"),  # true, but not the main effect
        (("identified", ["hysteresis"]), "wrong"),
        (("ambiguous", ["dry_friction"], ["hysteresis"]), "alternatives"),
        (("ambiguous", ["hysteresis"], ["stiffening"]), "wrong"),
        (("unexplained",), "silent"),
        (("insufficient",), "silent"),
    ],
)
def test_a_messy_case_is_graded_by_its_main_effect(verdict, expected):
    assert grade(MESSY, *verdict) == expected


@pytest.mark.parametrize(
    ("certain", "alternatives", "kinds", "expected"),
    [
        (["dry_friction"], [], None, "exact"),
        (
            ["dry_friction"],
            [["dry_friction", "tip_mass"], ["dry_friction", "stiffening"]],
            None,
            "exact",
        ),  # nothing further is reported
        ([], [["dry_friction"], ["hysteresis"]], ["friction"], "alternatives"),
        (["viscoelastic"], [["dry_friction", "viscoelastic"], ["tip_mass", "viscoelastic"]], None, "alternatives"),
        ([], [["hysteresis"], ["tip_mass"]], ["friction"], "wrong"),  # offered names count, although the kind is right
        ([], [["hysteresis"], ["tip_mass"]], ["elastic"], "wrong"),
        ([], [], ["friction"], "kind"),
        (["hysteresis"], [], None, "wrong"),
        (["hysteresis"], [["dry_friction"], ["hysteresis"]], None, "wrong"),  # reported names count, whatever else is offered
        (["dry_friction", "tip_mass"], [], None, "wrong"),
        ([], [], [], "silent"),
    ],
)
def test_a_partial_verdict_is_graded_by_its_reported_names_and_kinds(certain, alternatives, kinds, expected):
    verdict = {"status": "partly_identified", "effects": certain, "alternatives": alternatives, "kinds": kinds, "sentence": "so"}
    found = outcome_of(MESSY, {"verdict": verdict, "ladder": []}, None)
    assert found.grade == expected
    again = scored(json.loads(json.dumps(score([MESSY], {"case_001": {"verdict": verdict, "ladder": []}}).document())))
    assert [outcome.grade for outcome in again.outcomes] == [expected]


def test_the_flexible_law_of_a_kind_stands_for_its_kind():
    assert {name: law.kind for name, law in FLEXIBLE_LAWS.items()} == {name: main_kind(name) for name in FLEXIBLE}
    assert grade(MESSY, "ambiguous", ["friction_spectrum"], ["hysteresis"]) == "kind"
    assert grade(MESSY, "ambiguous", ["friction_spectrum"], ["dry_friction"]) == "alternatives"
    assert grade(MESSY, "ambiguous", ["elastic_curve"], ["stiffening"]) == "wrong"


def test_the_remaining_rms_is_that_of_the_last_model_not_of_the_repeatability():
    rungs = {"declared model": 9.0, "stiffness and damping": 4.0, "dry_friction": 1.0}
    floors = {"not repeatable (trial-to-trial scatter)": 0.5, "noise floor (share: unexplained remainder)": 0.4}
    verdict = said("identified", ["dry_friction"])
    for foot in ({}, floors, dict([floors.popitem()])):
        verdict["ladder"] = [{"rung": name, "heldout_rms_mm": value} for name, value in (rungs | foot).items()]
        assert outcome_of(MESSY, verdict, None).shrinkage == 0.75


@pytest.mark.parametrize(
    ("kinds", "expected"),
    [(["friction"], "kind"), (["friction", "creep"], "part"), (["creep"], "wrong"), (["elastic"], "wrong"), ([], "silent")],
)
def test_kinds_without_names_count_as_kinds(kinds, expected):
    assert grade(MESSY, "unexplained", kinds=kinds) == expected


def test_a_false_kind_invalidates_the_right_one():
    assert not outcome_of(MESSY, said("unexplained", kinds=["friction", "mass_gravity"]), None).kind_right


def test_alternatives_of_one_kind_report_that_kind():
    outcome = outcome_of(MESSY, said("ambiguous", ["dry_friction"], ["hysteresis"]), None)
    assert outcome.kinds == ("friction",)
    assert outcome_of(MESSY, said("ambiguous", ["dry_friction"], ["stiffening"]), None).kinds == ()


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [
        (("identified", ["actuator_lag"]), "exact"),
        (("identified", ["unequal_lag"]), "exact"),
        (("identified", ["dead_time"]), "kind"),  # another form of delay
        (("ambiguous", ["dead_time"], ["stiffening"]), "kind"),
        (("identified", ["stiffening"]), "wrong"),
        (("identified", ["dead_time", "stiffening"]), "wrong"),
        (("unexplained",), "silent"),
    ],
)
def test_another_form_may_go_by_another_name_of_its_kind(verdict, expected):
    assert grade(FORM, *verdict) == expected


@pytest.mark.parametrize(
    ("verdict", "kinds", "expected"),
    [
        (("identified", ["tip_mass"]), None, "exact"),
        (("partly_identified", ["tip_mass", "torque_bias"]), None, "exact"),  # its further effects are unknown
        (("ambiguous", ["tip_mass"], ["actuator_lag"]), None, "alternatives"),
        (("unexplained",), ["mass_gravity"], "kind"),
        (("partly_identified", ["viscoelastic"]), ["mass_gravity", "creep"], "kind"),
        (("ambiguous", ["added_mass"], ["stiffening"]), None, "kind"),
        (("identified", ["viscoelastic"]), None, "part"),  # creep is plausible
        (("identified", ["actuator_lag"]), None, "wrong"),  # it has no actuator
        (("unexplained",), ["contact"], "wrong"),
        (("unexplained",), None, "silent"),
    ],
)
def test_a_real_case_is_right_if_the_withheld_cause_is_named_and_wrong_if_an_impossible_one_is(verdict, kinds, expected):
    assert grade(REAL, *verdict, kinds=kinds) == expected


def test_a_messy_arm_without_effect_may_also_be_unexplained():
    assert [grade(NONE, status) for status in ("parameters", "no_gap", "unexplained")] == ["right"] * 3
    assert grade(NONE, "insufficient") == "silent"
    assert grade(NONE, "identified", ["stiffening"]) == "wrong"
    assert grade(NONE, "unexplained", kinds=["elastic"]) == "wrong"
    clean = Answer("case_001", "none", (), "", {})
    assert grade(clean, "unexplained") == "silent"


def test_outside_is_unexplained_and_its_kind_may_be_reported():
    assert grade(OUTSIDE, "unexplained") == "right"
    assert not outcome_of(OUTSIDE, said("unexplained"), None).kind_right
    assert outcome_of(OUTSIDE, said("unexplained", kinds=["contact"]), None).kind_right
    assert grade(OUTSIDE, "unexplained", kinds=["friction"]) == "wrong"
    assert grade(OUTSIDE, "identified", ["bending_stop"]) == "wrong"
    assert grade(OUTSIDE, "identified", ["restraint"]) == "right"  # the catalogue may contain an equivalent later


def test_half_of_a_pair_is_a_part_and_both_kinds_are_needed():
    assert grade(PAIR, "partly_identified", ["backlash"]) == "part"
    assert grade(PAIR, "unexplained", kinds=["elastic", "mass_gravity"]) == "kind"
    assert grade(PAIR, "unexplained", kinds=["elastic"]) == "part"


def test_confidence_is_given_for_known_claims_from_zero_to_one():
    outcome = outcome_of(MESSY, said("identified", ["dry_friction"], confidence={"dry_friction": 0.9, "keq_scale": 1.0}), None)
    assert outcome.confidence == (("dry_friction", 0.9),)
    for value in (1.2, -0.1, "high", None):
        with pytest.raises(InputError, match="0 to 1"):
            outcome_of(MESSY, said("identified", ["dry_friction"], confidence={"dry_friction": value}), None)


def test_rates_are_separate_for_each_tier_and_are_restored_from_the_document():
    cases = (MESSY, FORM, REAL, NONE, OUTSIDE, PAIR, MESSY)
    answers = [replace(each, name=f"case_{k:03d}") for k, each in enumerate(cases, 1)]
    verdicts = [
        said("identified", ["dry_friction"], kinds=["friction"], confidence={"dry_friction": 0.9, "friction": 0.95}),
        said("identified", ["dead_time"], confidence={"dead_time": 0.6}),
        said("identified", ["actuator_lag"], confidence={"actuator_lag": 0.7}),
        said("parameters"),
        said("unexplained", kinds=["contact"]),
        said("identified", ["backlash", "tip_mass"]),
        said("unexplained"),
    ]
    found = score(answers, {answer.name: verdict for answer, verdict in zip(answers, verdicts, strict=True)})
    rates = found.rates
    assert rates["messy: exact or among the alternatives"] == Rate(1, 2) and rates["messy: silent"] == Rate(1, 2)
    assert rates["forms: kind right"] == Rate(1, 1) and rates["forms: exact or among the alternatives"] == Rate(0, 1)
    assert rates["real: wrong"] == Rate(1, 1) and rates["kind right, outside"] == Rate(1, 1)
    assert rates["messy: no name, none"] == Rate(1, 1) and rates["wrong names, all cases"] == Rate(1, 7)
    assert rates["exact, pair"] == Rate(1, 1) and rates["exact, single effects, large"] == Rate(0, 0)
    text = report(found)
    assert "expected calibration error" in text and "WRONG NAME" in text and max(map(len, text.splitlines())) <= 130
    assert sum(found.grades("messy", "single").values()) == 2 and set(found.grades("messy", "single")) == set(GRADES)
    again = scored(json.loads(json.dumps(found.document())))
    assert report(again) == text
