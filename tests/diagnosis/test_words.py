"""What to do next follows from the verdict."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import Diagnosis
from hsr_pin.diagnosis.next_experiment import Proposal
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.verdict import Evidence, judge
from hsr_pin.diagnosis.words import advice, effect_options, headline, sentence
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.hypothesis import Part

from .fabricated import LENGTH, THRESHOLDS, candidate, supported

BASE = candidate(gap=4e-3)


def advised(best, weak=()):
    found = Search((BASE,) if best is BASE else (BASE, best), (BASE, best))
    verdict = judge(found, THRESHOLDS, Evidence((6e-3) ** 2, *supported(best, weak), LENGTH, None, None, 0))
    return advice(Diagnosis(None, verdict, (), found, THRESHOLDS, ()))


@pytest.mark.parametrize(
    ("best", "told"),
    [
        (candidate("bending_stop"), "Simulate with Keq times 1.00, C times 1.00, and the effects found."),
        (candidate("torque_gain"), "Simulate with Keq times 1.00, C times 1.00, the torque times 1.10."),
        (candidate("bending_stop", gap=3e-3), "Simulate with what is certain"),
        (BASE, "Do not trust the values of a model that does not explain the gap"),
    ],
)
def test_the_advice_fits_the_verdict(best, told):
    (line,) = advised(best)
    assert told in line


@pytest.mark.parametrize(
    ("best", "told"),
    [
        (candidate("bending_stop", errors={"bending_stop": 5}), "Record more trials in which bending stop would act"),
        (candidate("bending_stop", errors={"bending_stop": 1}), "Record more trials in which bending stop would act"),
        (candidate("bending_stop", gap=3e-3), "Do not trust the values"),
    ],
)
def test_where_nothing_is_certain_it_says_what_would_pin_it_down_or_what_not_to_trust(best, told):
    (line,) = advised(best, weak=(*best.names, *best.kinds))
    assert told in line


def test_a_single_alternative_is_a_likely_explanation_with_trials_that_would_make_it_certain():
    best = candidate("bending_stop", gap=0.8e-3)
    found = Search((BASE, best), (BASE, best))
    verdict = judge(found, THRESHOLDS, Evidence((6e-3) ** 2, *supported(best), LENGTH, None, None, 0))
    alone = replace(verdict, status="ambiguous", effects=(), alternatives=(("bending_stop",),))
    assert headline(alone) == "A likely explanation"
    (line,) = advice(Diagnosis(None, alone, (), found, THRESHOLDS, ()))
    assert line.startswith("Record more trials in which bending stop would act")
    assert headline(replace(alone, effects=("tip_mass",))) == headline(replace(alone, alternatives=(("a",), ("b",))))


def test_where_no_experiment_tells_the_rivals_apart_none_is_proposed():
    best, other = candidate("mass_scale"), candidate("added_mass")
    found = Search((BASE, best), (BASE, best, other))
    verdict = judge(found, THRESHOLDS, Evidence((6e-3) ** 2, *supported(best), LENGTH, None, None, 0))
    assert verdict.status == "ambiguous"
    told = Diagnosis(None, verdict, (), found, THRESHOLDS, ())
    assert any(line.startswith("No standard experiment tells these apart") for line in advice(told))
    assert any(line.startswith("Record next: ") for line in advice(replace(told, next_experiment=(Proposal("steps", 3.0),))))


def test_a_value_on_its_bound_and_a_large_damping_are_warned_of():
    best = candidate("tip_mass")
    values = best.fit.values.copy()
    values[best.fit.hypothesis.free.index("damping_scale")] = 50.0
    lines = advised(replace(best, fit=replace(best.fit, values=values)))
    assert any(line.startswith("damping_scale ended on a bound") for line in lines)
    assert any("The damping came out 50.0 times the declared one" in line for line in lines)


def test_options_for_hsr_sim_are_those_of_each_level_where_sizes_differ_between_levels():
    one = candidate("gravity_tilt").fit
    (plain,) = effect_options(one, (1.11, 2.33)).items()
    assert plain == ("", f"--effect gravity_tilt:angle={one.named['gravity_tilt.angle']:.4g},frame=world")
    fit = candidate(Part("gravity_tilt", neutral(EFFECTS["gravity_tilt"]), levels=(1.11, 2.33))).fit
    fit = replace(fit, values=fit.values + np.array([0, 0, 0.01, -0.02]))
    sizes = {keq: fit.named[f"gravity_tilt.angle@{keq}"] for keq in (1.11, 2.33)}
    assert sizes[1.11] != sizes[2.33]
    assert effect_options(fit, (1.11, 2.33)) == {
        f"{keq} Nm/rad": f"--effect gravity_tilt:angle={a:.4g},frame=world" for keq, a in sizes.items()
    }


def test_options_for_hsr_sim_are_those_of_each_level_where_a_size_goes_with_it():
    law = EFFECTS["torque_bias"]
    fit = candidate(Part("torque_bias", neutral(law), resized=True)).fit
    soft, stiff = (float(text.partition("bias=")[2]) for text in effect_options(fit, (2.22, 1.11)).values())
    assert soft == pytest.approx(fit.named["torque_bias.bias"], rel=1e-3) and stiff == pytest.approx(2 * soft, rel=1e-3)
    assert list(effect_options(fit, (2.22, 1.11))) == ["1.11 Nm/rad", "2.22 Nm/rad"]


def test_a_sentence_for_people_has_no_names_of_code():
    told = "marker_profile with torque_bias: something of the kind actuation_map, or base_tilt."
    assert sentence(told) == "Marker profile with torque bias: something of the kind actuation map, or base tilt."
