"""The JSON of a diagnosis contains all results in the documented fields."""

import json
import math
from dataclasses import replace

import pytest

from hsr_pin.diagnosis.document import to_json

from .fabricated import SLOW

NUMBER = (int, float)
MAYBE = (*NUMBER, type(None))
MAP = {"quantity": str, "unit": str, "bins": [{"label": str, "value": NUMBER, "share": NUMBER, "noise": NUMBER}]}
CANDIDATE = {
    "effects": [str],
    "resized": [str],
    "options": dict,
    "parameters": dict,
    "heldout_rms_mm": NUMBER,
    "fit_rms_mm": NUMBER,
}
LEFT = {"mm": NUMBER, "percent_of_length": NUMBER, "share": NUMBER, "not_repeatable_mm": MAYBE}
JUDGED = {"causes": [dict], "misfit": NUMBER, "misfits": [NUMBER], "information": [[[NUMBER]]]}
JUDGED |= {"departures": [NUMBER], "errors": [NUMBER]}
CANDIDATE |= JUDGED | {"probability": NUMBER, "log_evidence": NUMBER, "special_cases": [int]}
POSTERIOR = {
    "sets": [{"effects": [str], "probability": NUMBER}],
    "loss": dict,
    "expected_gain": MAYBE,
    "probability": MAYBE,
    "calibration": dict,
    "data": {"groups": [[int]], "noise": [NUMBER], "count": [int], "discrepancy": [NUMBER]},
    "unfitted": [JUDGED],
}
ESTIMATE = {"value": NUMBER, "unit": str, "ci95": [NUMBER]}
SUPPLY = {"channel": str, "unit": str, "late": bool, "rms": NUMBER, "unexplained": NUMBER, "delay": ESTIMATE, "rise": ESTIMATE}
SUPPLY |= {"fall": ESTIMATE, "gain": ESTIMATE, "offset": ESTIMATE}
SCHEMA = {
    "schema": int,
    "dataset": str,
    "verdict": {
        "status": str,
        "effects": [str],
        "alternatives": [[str]],
        "sentence": str,
        "kinds": [str],
        "confidence": dict,
        "left": LEFT,
    },
    "posterior": POSTERIOR,
    "arm": (dict, type(None)),
    "ladder": [
        {
            "rung": str,
            "effects": [str],
            "heldout_rms_mm": NUMBER,
            "heldout_rms_percent": NUMBER,
            "share": NUMBER,
            "ci95_mm": [NUMBER],
        }
    ],
    "noise_floor_mm": NUMBER,
    "candidates": [CANDIDATE],
    "where": {
        "arc_length": MAP,
        "time": MAP,
        "operating_range": {"bending_angle": MAP, "bending_rate": MAP, "torque": MAP},
        "trials": MAP,
        "sentence": str,
        "frequency_hz": MAYBE,
        "defect": (dict, type(None)),
        "base": (dict, type(None)),
        "pulsation": (dict, type(None)),
    },
    "next_experiment": [{"name": str, "separation": MAYBE}],
    "limits": {"closed_mm": NUMBER, "share": NUMBER},
    "fingerprint": {
        "kinds": [str],
        "prints": [dict],
        "starts": [{"seconds": MAYBE, "told": (bool, type(None)), "word": str}],
    },
    "repeats": (dict, type(None)),
    "supply": [SUPPLY],
    "detection_limits": [{"effect": str, "parameter": str, "size": MAYBE, "unit": str}],
    "notes": [str],
}


def assert_shape(value, shape, at="document"):
    if isinstance(shape, dict):
        assert isinstance(value, dict) and value.keys() == shape.keys(), at
        for name, inner in shape.items():
            assert_shape(value[name], inner, f"{at}.{name}")
    elif isinstance(shape, list):
        assert isinstance(value, list), at
        for place, each in enumerate(value):
            assert_shape(each, shape[0], f"{at}[{place}]")
    else:
        allowed = shape if isinstance(shape, tuple) else (shape,)
        assert isinstance(value, allowed) and (bool in allowed or not isinstance(value, bool)), at


@pytest.fixture(params=["diagnosis", "ambiguous"])
def document(request):
    return to_json(replace(request.getfixturevalue(request.param), supply=(SLOW,)))


def test_every_field_of_the_schema_is_there_with_its_type(document):
    assert_shape(document, SCHEMA)


def test_it_is_strict_json_and_comes_back_equal(document):
    assert json.loads(json.dumps(document, allow_nan=False)) == document


def test_a_document_that_lacks_a_field_is_caught(diagnosis):
    document = to_json(diagnosis)
    del document["ladder"][1]["share"]
    with pytest.raises(AssertionError, match="ladder"):
        assert_shape(document, SCHEMA)


def test_values_are_those_of_the_diagnosis_in_mm(diagnosis):
    document = to_json(diagnosis)
    assert document["dataset"] == "heavy-tip"
    assert document["verdict"]["status"] == "identified"
    assert document["verdict"]["effects"] == ["tip_mass"]
    first, last = diagnosis.ladder[0], document["ladder"][-1]
    assert document["ladder"][0]["heldout_rms_mm"] == pytest.approx(1e3 * first.rms)
    assert document["ladder"][0]["heldout_rms_percent"] == pytest.approx(100 * first.rms / 0.24)
    assert document["ladder"][0]["ci95_mm"] == pytest.approx([1e3 * bound for bound in first.interval])
    assert last["heldout_rms_mm"] == document["noise_floor_mm"] == pytest.approx(1e3 * diagnosis.experiment.noise_rms)
    assert sum(rung["share"] for rung in document["ladder"]) == pytest.approx(1.0)
    assert document["where"]["time"]["unit"] == "mm"
    assert [part["label"] for part in document["where"]["trials"]["bins"]] == [f"trial_0{k}" for k in (1, 2, 3, 4)]


def test_candidates_come_best_first_with_sorted_parameters_and_intervals_around_them(diagnosis):
    candidates = to_json(diagnosis)["candidates"]
    assert {tuple(each["effects"]) for each in candidates} == {(), ("actuator_lag",), ("tip_mass",)}
    errors = [each["heldout_rms_mm"] for each in candidates]
    assert errors == sorted(errors)
    for candidate in candidates:
        names = list(candidate["parameters"])
        assert names == sorted(names) and {"keq_scale", "damping_scale"} <= {*names}
        for fact in candidate["parameters"].values():
            assert fact.keys() == {"value", "unit", "ci95"}
            assert fact["ci95"][0] <= fact["value"] <= fact["ci95"][1]
    mass = candidates[0]["parameters"]["tip_mass.mass"]
    assert mass["unit"] == "kg"
    assert mass["value"] == pytest.approx(0.03, abs=0.003)


def test_alternatives_are_sets_of_sorted_names_and_what_is_infinite_is_null(ambiguous):
    verdict = replace(ambiguous.verdict, alternatives=(("tip_mass", "dead_time"), ("actuator_lag",)))
    document = to_json(replace(ambiguous, verdict=verdict))
    assert document["verdict"]["alternatives"] == [["dead_time", "tip_mass"], ["actuator_lag"]]
    assert document["next_experiment"] == [{"name": "payload", "separation": 40.0}, {"name": "steps", "separation": None}]


def test_numbers_that_are_none_are_null(diagnosis):
    rungs = (replace(diagnosis.ladder[0], rms=math.nan, share=-math.inf), *diagnosis.ladder[1:])
    first = to_json(replace(diagnosis, ladder=rungs))["ladder"][0]
    assert first["heldout_rms_mm"] is first["heldout_rms_percent"] is first["share"] is None


def test_too_little_to_go_on_has_the_same_fields_with_nothing_in_them(insufficient):
    document = to_json(insufficient)
    assert document.keys() == SCHEMA.keys()
    assert document["verdict"]["status"] == "insufficient"
    assert document["candidates"] == []
    assert document["where"].keys() == SCHEMA["where"].keys()
    assert document["where"]["arc_length"] == {}
    assert document["next_experiment"]
    json.dumps(document, allow_nan=False)
