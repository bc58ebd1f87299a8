"""No law is certain for want of being compared with its double."""

import pytest

from hsr_pin.diagnosis.rivals import with_doubles
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.identification.hypothesis import Part

from .fabricated import THRESHOLDS, candidate

BASE = candidate(gap=4e-3)
BEND, TILT = candidate("preset_bend", gap=2e-3), candidate("gravity_tilt", gap=2e-3)
CURVE = neutral(FLEXIBLE["elastic_curve"])
BEST = candidate(CURVE, "preset_bend", gap=0.5e-3)


def doubles(best, *tried):
    return with_doubles(best, BASE, [BASE, best, *tried], THRESHOLDS, 0)


def test_a_law_that_did_as_well_in_anothers_place_is_to_be_tried_beside_the_rest_too():
    (start,) = doubles(BEST, BEND, TILT)
    assert {part.name for part in start.hypothesis.parts} == {"elastic_curve", "gravity_tilt"}
    own = dict(zip(start.hypothesis.free, start.values, strict=True))
    assert own["gravity_tilt.angle"] == TILT.fit.named["gravity_tilt.angle"] != 0
    assert own["elastic_curve.first"] == BEST.fit.named["elastic_curve.first"]
    assert len(start.values) == len(start.hypothesis.parameters)


def test_it_may_have_done_so_beside_a_third():
    pairs = [candidate("dead_time", name, gap=1e-3) for name in ("preset_bend", "torque_bias")]
    (start,) = doubles(BEST, *pairs)
    assert {part.name for part in start.hypothesis.parts} == {"elastic_curve", "torque_bias"}


@pytest.mark.parametrize("other", [candidate("gravity_tilt", gap=3.5e-3), candidate(FLEXIBLE["torque_curve"](), gap=2e-3)])
def test_a_law_that_did_worse_and_one_that_is_no_cause_are_no_doubles(other):
    assert doubles(BEST, BEND, other) == []


def test_of_the_readings_of_a_double_the_likest_come_first_and_a_single_law_has_been_tried_against_all():
    worse = candidate(Part("torque_bias", neutral(EFFECTS["torque_bias"])), gap=2.05e-3)
    like = candidate(Part("torque_bias", neutral(EFFECTS["torque_bias"]), resized=True), gap=2e-3)
    starts = doubles(BEST, BEND, worse, like)
    assert [start.hypothesis.resized for start in starts] == [("torque_bias",), ()]
    assert doubles(BEND, worse, like) == []


def test_what_two_models_have_in_common_does_not_contain_what_they_have_not():
    curve, other = candidate(CURVE), candidate(CURVE, "gravity_tilt")
    assert not other.contains(BEST)
    assert not curve.contains(BEST)
    assert curve.contains(candidate("preset_bend"))
    assert other.contains(candidate("preset_bend", "gravity_tilt"))
