"""The verdict follows from the posterior: names, kinds, alternatives, parameters, or an unexplained gap."""

import pytest

from hsr_pin.diagnosis.verdict import WORDS
from hsr_pin.inference import Loss
from hsr_pin.inference.search import judged
from hsr_pin.inference.verdict import Limits, predicted_no_better, verdict_of

from ..inference.fabricated import CALIBRATION
from .fabricated import DATA, LENGTH, LIMITS, candidate

GAP = 4e-3


def verdict(*candidates, nominal=GAP, **options):
    found = judged([candidate(gap=GAP), *candidates], DATA, CALIBRATION)
    return verdict_of(found, LIMITS, nominal**2, WORDS, length=LENGTH, **options)


def test_one_law_that_closes_the_gap_is_identified():
    said = verdict(candidate("bending_stop"), candidate("tip_mass", gap=3e-3))
    assert (said.status, said.effects, said.kinds) == ("identified", ("bending_stop",), ("elastic",))
    assert (
        said.sentence.startswith("bending_stop is missing from the model (probability 0.99)")
        or "probability 1.00" in said.sentence
    )
    assert said.confidence["bending_stop"] > 0.95 and said.confidence["elastic"] > 0.95


def test_two_laws_that_do_the_same_are_alternatives():
    said = verdict(candidate("torque_bias"), candidate("dry_friction"))
    assert (said.status, set(said.alternatives), said.effects) == ("ambiguous", {("torque_bias",), ("dry_friction",)}, ())
    assert said.sentence.startswith("One of these is missing from the model (probability 1.00): ")
    assert "torque_bias (0.50)" in said.sentence and "dry_friction (0.50)" in said.sentence


def test_what_the_alternatives_share_is_named():
    said = verdict(candidate("tip_mass", "torque_bias"), candidate("tip_mass", "dry_friction"))
    assert (said.status, said.effects) == ("ambiguous", ("tip_mass",))


def test_a_law_that_takes_little_is_not_named():
    said = verdict(candidate("tip_mass", gap=0.9 * GAP))
    assert (said.status, said.effects, said.alternatives) == ("unexplained", (), ())
    assert "tip_mass" in said.sentence


def test_a_law_that_leaves_something_is_named_with_what_is_left():
    said = verdict(candidate("tip_mass", gap=0.25 * GAP))
    assert (said.status, said.effects) == ("partly_identified", ("tip_mass",))
    assert "another cause is not identified" in said.sentence and said.left.rms == pytest.approx(1e-3, rel=0.02)


def test_a_flexible_law_is_a_kind_without_a_name():
    said = verdict(candidate("torque_profile"))
    assert (said.status, said.effects, said.kinds) == ("partly_identified", (), ("actuation_map",))
    assert "torque_profile" not in said.confidence


def test_another_number_of_the_arm_is_no_effect():
    said = verdict(candidate("torque_gain"))
    assert (said.status, said.effects) == ("parameters", ())
    assert verdict(candidate("keq_drift")).status == "partly_identified"


def test_a_declared_model_that_fits_leaves_no_gap():
    assert verdict(nominal=0.5 * LIMITS.closed).status == "no_gap"


def test_stiffness_and_damping_explain_what_they_close():
    found = judged([candidate(gap=0.5 * LIMITS.closed)], DATA, CALIBRATION)
    assert verdict_of(found, LIMITS, GAP**2, WORDS, length=LENGTH).status == "parameters"


def test_a_dearer_wrong_name_makes_the_verdict_more_careful():
    likely = candidate("tip_mass", gap=0.6 * GAP)
    assert verdict(likely).effects == ("tip_mass",)
    assert verdict(likely, loss=Loss(wrong_name=-1e4, none_right=-1e4)).effects == ()


def test_what_predicts_trials_set_aside_no_better_is_not_named():
    said = verdict(candidate("tip_mass"))
    assert predicted_no_better(said, 2e-3, 1e-3, ("tip_mass",), WORDS) is said
    withheld = predicted_no_better(said, 1e-3, 2e-3, ("tip_mass",), WORDS)
    assert (withheld.status, withheld.effects, withheld.kinds, withheld.confidence) == ("unexplained", (), (), {})
    assert "no better (2.00 mm) than stiffness and damping alone (1.00 mm)" in withheld.sentence


def test_what_is_too_small_to_report_follows_from_noise_and_length():
    assert Limits.of(1e-3, 1.2e-4).closed == pytest.approx(3e-4)
    assert Limits.of(1e-5, 1.2e-4).closed == pytest.approx(1.8e-4)
    assert Limits.of(1e-3, 1.2e-4).explains(0.02, 1.0) and not Limits.of(1e-3, 1.2e-4).explains(0.2, 1.0)
