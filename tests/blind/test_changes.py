"""Changes are scored by name and by size; a name that has not changed is wrong."""

from __future__ import annotations

import json
from math import log

import pytest

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.changes import SAME, score_changes, scored_changes, size_right
from hsr_pin.blind.plants import laws
from hsr_pin.blind.rate import Rate
from hsr_pin.cli.blind_report import report_changes
from hsr_pin.errors import InputError


def answer(kind, name="", old=0.0, new=0.0, case="case_001"):
    facts = {"change": {"name": name, "strength": "x", "from": old, "to": new} if name else {}}
    return Answer(case, kind, (name,) if name else (), "", facts, "change")


def said(status, *sets, changes=()):
    effects = sorted(set.intersection(*map(set, sets))) if sets else []
    alternatives = [list(each) for each in sets] if len(sets) > 1 else []
    document = {"status": status, "effects": effects, "alternatives": alternatives, "sentence": "so", "changes": list(changes)}
    return {"verdict": document}


def change(name, parameter, old, new, **intervals):
    return {"name": name, "parameter": parameter, "from": old, "to": new, "intervals": intervals}


LAG, STIFF = answer("appears", "actuator_lag", 0.0, 0.05), answer("parameter", "keq_scale", 0.9, 0.81)
SAME_ARM = answer("nothing")


def test_the_change_named_alone_or_among_alternatives_is_right():
    assert score_changes([LAG], {"case_001": said("identified", ["actuator_lag"])}).outcomes[0].grade == "exact"
    assert (
        score_changes([LAG], {"case_001": said("ambiguous", ["actuator_lag"], ["dead_time"])}).outcomes[0].grade == "alternatives"
    )
    assert score_changes([STIFF], {"case_001": said("identified", ["keq_scale"])}).outcomes[0].grade == "exact"
    assert score_changes([SAME_ARM], {"case_001": said("unchanged")}).outcomes[0].grade == "right"


def test_an_unchanged_name_is_wrong_and_a_missed_change_is_a_miss():
    for truth, names in ((LAG, ["stiffening"]), (STIFF, ["torque_gain"]), (SAME_ARM, ["keq_scale"])):
        outcome = score_changes([truth], {"case_001": said("identified", names)}).outcomes[0]
        assert outcome.wrong_name and not outcome.exact
    missed = score_changes([LAG], {"case_001": said("unchanged")})
    assert missed.rates["unchanged, something has"] == Rate(1, 1) and not missed.outcomes[0].exact
    assert score_changes([SAME_ARM], {"case_001": said("unexplained")}).outcomes[0].grade == "silent"


@pytest.mark.parametrize(("old", "new", "right"), [(0.02, 0.071, True), (0.0, 0.05, True), (0.0, 0.07, False)])
def test_the_step_of_an_effect_is_judged_by_its_interval(old, new, right):
    entry = change(
        "actuator_lag", "time_constant", old, new, **{"from": [old - 0.003, old + 0.003], "to": [new - 0.004, new + 0.004]}
    )
    assert size_right(LAG, said("identified", ["actuator_lag"], changes=[entry])) is right


def test_half_widths_add_in_squares_and_a_stated_step_comes_first():
    ends = {"from": [-0.003, 0.003], "to": [0.0509, 0.0589]}  # 0.0549 with an interval of 0.005 on both sides
    just_in = change("actuator_lag", "time_constant", 0.0, 0.0549, **ends)
    assert size_right(LAG, said("identified", ["actuator_lag"], changes=[just_in]))
    ends["to"] = [0.0511, 0.0591]
    just_out = change("actuator_lag", "time_constant", 0.0, 0.0551, **ends)
    assert not size_right(LAG, said("identified", ["actuator_lag"], changes=[just_out]))
    stated = change("actuator_lag", "time_constant", 0.0, 0.0551, step=[0.04, 0.06], **ends)
    assert size_right(LAG, said("identified", ["actuator_lag"], changes=[stated]))


def test_a_plain_parameter_is_judged_by_its_ratio():
    both = {"from": [0.97 * 1.0, 1.03 * 1.0], "to": [0.97 * 0.9, 1.03 * 0.9]}
    entry = change("keq_scale", "keq_scale", 1.0, 0.9, **both)
    assert size_right(STIFF, said("identified", ["keq_scale"], changes=[entry]))
    far = change("keq_scale", "keq_scale", 1.0, 0.97, **{"from": [0.99, 1.01], "to": [0.96, 0.98]})
    assert log(0.97) - log(0.9) > 0.05 and not size_right(STIFF, said("identified", ["keq_scale"], changes=[far]))


def test_a_size_that_is_not_reported_or_cannot_be_compared_is_not_judged():
    assert size_right(LAG, said("identified", ["actuator_lag"])) is None
    assert size_right(SAME_ARM, said("unchanged")) is None
    play = answer("appears", "backlash", 0.0, 0.2)
    assert size_right(play, said("identified", ["backlash"], changes=[change("backlash", "gap", 0.0, 0.2)])) is None


def test_names_with_a_size_are_laws_of_the_plants():
    assert set(SAME) <= {*laws.CATALOGUE, *laws.PARAMETERS}


def test_the_report_and_the_document_hold_every_rate_and_miss():
    answers = [
        LAG,
        answer("nothing", case="case_002"),
        answer("grows", "tip_mass", 0.1, 0.15, "case_003"),
        answer("nothing", case="case_004"),
    ]
    verdicts = {
        "case_001": said("identified", ["actuator_lag"]),
        "case_002": said("identified", ["keq_scale"]),
        "case_003": said("unchanged"),
    }
    found = score_changes(answers, verdicts)
    text = report_changes(found)
    assert "3 pairs diagnosed, 1 not diagnosed: case_004" in text and "2 misses:" in text and "WRONG NAME" in text
    assert found.rates["change named alone or among the alternatives"] == Rate(1, 2)
    document = found.document()
    again = scored_changes(json.loads(json.dumps(document)))
    assert (again.document(), report_changes(again)) == (document, text)
    with pytest.raises(InputError, match="score"):
        scored_changes({"outcomes": [{}], "missing": []})
    assert document["rates"]["wrong names, all pairs"]["hits"] == 1 and len(document["outcomes"]) == 3
