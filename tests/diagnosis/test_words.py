"""The advice follows from the verdict."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.next_experiment import Proposal
from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.diagnosis.verdict import WORDS
from hsr_pin.diagnosis.words import advice, effect_options, sentence, supply_sentence
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.part import Part
from hsr_pin.inference.search import judged
from hsr_pin.inference.verdict import Verdict, verdict_of

from ..inference.fabricated import CALIBRATION
from .fabricated import DATA, LENGTH, LIMITS, PROMPT, SLOW, candidate

GAP = 4e-3


def advised(*candidates, **changes):
    found = judged([candidate(gap=GAP), *candidates], DATA, CALIBRATION)
    verdict = verdict_of(found, LIMITS, (6e-3) ** 2, WORDS, length=LENGTH)
    return advice(replace(Diagnosis(None, verdict, (), found, LIMITS, ()), **changes))


@pytest.mark.parametrize(
    ("best", "said"),
    [
        (["tip_mass"], "Simulate with Keq times 1.00, C times 1.00, and the identified effects."),
        (["torque_gain"], "Simulate with Keq times 1.00, C times 1.00, the torque times 1.10."),
        ([], "Do not trust the values of a model that does not explain the gap"),
    ],
)
def test_the_advice_fits_the_verdict(best, said):
    (line,) = advised(*([candidate(*best)] if best else []))
    assert said in line


def test_where_something_is_left_only_what_is_reported_is_to_be_simulated():
    (line,) = advised(candidate("tip_mass", gap=1e-3))
    assert "Simulate with the reported effects" in line


def test_where_no_experiment_tells_the_alternatives_apart_none_is_proposed():
    both = candidate("torque_bias"), candidate("dry_friction")
    assert any(line.startswith("No standard experiment separates these explanations") for line in advised(*both))
    proposals = (Proposal("steps", 3.0),)
    assert any(line.startswith("Record next: ") for line in advised(*both, next_experiment=proposals))


def test_a_value_on_its_bound_is_warned_of():
    best = candidate("tip_mass")
    values = best.fit.values.copy()
    values[best.fit.hypothesis.free.index("damping_scale")] = 50.0
    lines = advised(replace(best, fit=replace(best.fit, values=values)))
    assert any(line.startswith("damping_scale ended on a bound") for line in lines)


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


@pytest.mark.parametrize(
    ("effects", "supply", "said"),
    [
        (("dead_time",), (SLOW,), "The supply is late, and so is the arm (dead_time)"),
        (("dead_time",), (PROMPT,), "The arm is late (dead_time), not the supply"),
        (("tip_mass",), (SLOW,), "The supply is late; the model of the arm is driven by what was measured."),
        (("tip_mass",), (PROMPT,), "The supply is not late"),
    ],
)
def test_what_is_late_is_named(effects, supply, said):
    verdict = Verdict("identified", effects, (), "")
    words = supply_sentence(Diagnosis(None, verdict, (), None, LIMITS, (), supply=supply))
    assert said in words and words.startswith(str(supply[0]))


def test_several_channels_are_named():
    verdict = Verdict("identified", (), (), "")
    words = supply_sentence(Diagnosis(None, verdict, (), None, LIMITS, (), supply=(SLOW, PROMPT)))
    assert words.startswith(f"P1 {SLOW}; P2 {PROMPT}. The supply is late;")


def test_without_a_command_beside_what_was_measured_nothing_is_said_of_the_supply():
    assert supply_sentence(Diagnosis(None, Verdict("identified", (), (), ""), (), None, LIMITS, ())) == ""
