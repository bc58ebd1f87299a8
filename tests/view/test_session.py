"""A session simulates what the sliders say, and settings say what is on."""

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.actuator_lag import ActuatorLag
from hsr_pin.export.model import CorrectedModel
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.view.controls import arm_sliders, effect_sliders, with_value
from hsr_pin.view.session import POINTS, overall
from hsr_pin.view.settings import Settings

from .conftest import LAG

TRUE = Settings({"actuator_lag.time_constant": LAG})


def test_the_right_setting_leaves_noise_and_others_more(session):
    run = session.run("trial_02")
    declared, right = session.answer(run, Settings()), session.answer(run, TRUE)
    assert declared.rms > 3e-3
    assert right.rms == pytest.approx(session.noise, rel=0.15)
    stiff = session.answer(run, TRUE.changed("keq_scale", 1.3))
    assert stiff.rms > 3 * right.rms


def test_the_error_is_the_distance_of_the_markers_that_are_seen(session):
    run = session.run("trial_01")
    answer = session.answer(run, Settings())
    hidden = np.isnan(run.measured[:, -1, 0])
    apart = np.hypot(*(answer.markers - run.measured)[..., [0, 2]].transpose(2, 0, 1))
    assert hidden.sum() > 5
    assert np.allclose(answer.error[hidden], apart[hidden, 0])
    assert np.allclose(answer.error[~hidden], np.sqrt((apart[~hidden] ** 2).mean(axis=1)))


def test_the_backbone_passes_through_the_markers(session):
    answer = session.answer(session.run("trial_01"), TRUE)
    assert answer.backbone.shape[1:] == (POINTS, 3)
    assert np.allclose(answer.backbone[:, -1], answer.markers[:, -1], atol=1e-9)
    assert np.allclose(answer.backbone[:, POINTS // 2], answer.markers[:, 0], atol=1e-9)


def test_the_arm_stays_where_markers_are_moved_off_it(session):
    run = session.run("trial_01")
    plain, moved = session.answer(run, Settings()), session.answer(run, Settings({"marker_offset.offset": 0.01}))
    assert np.allclose(plain.backbone, moved.backbone)
    assert np.allclose(np.linalg.norm(moved.markers - plain.markers, axis=2), 0.01, atol=1e-9)


def test_a_simulation_that_fails_is_told_and_gives_no_number(session):
    run = session.run("trial_02")
    bad = Settings({"keq_scale": 0.2, "torque_gain": 3.0})
    answer = session.answer(run, bad)
    assert answer.stopped is not None
    assert np.isnan(answer.rms)
    assert np.isnan(overall([answer, session.answer(run, TRUE)]))


def test_all_trials_together_are_between_the_best_and_the_worst(session):
    answers = [session.answer(run, Settings()) for run in session.experiment.runs]
    assert min(each.rms for each in answers) < overall(answers) < max(each.rms for each in answers)


def test_only_effects_that_were_moved_act():
    assert Settings().effects() == ()
    settings = TRUE.changed("hysteresis.yield_angle", 0.5).changed("hysteresis.form", "maxwell_slip")
    assert settings.effects() == (ActuatorLag(LAG),)
    (_, loop) = sorted(settings.changed("hysteresis.amplitude", 0.1).effects(), key=lambda effect: effect.name)
    assert (loop.yield_angle, loop.form) == (0.5, "maxwell_slip")


def test_a_model_that_was_found_becomes_settings_and_back():
    model = CorrectedModel(ArmSpecification(keq=1.2, damping=0.04, mass=0.18), (ActuatorLag(0.05),), torque_gain=1.1)
    settings = Settings.of(model, keq=1.0, damping=0.05, mass=0.15)
    assert [settings.arm(name) for name in ("keq_scale", "damping_scale", "mass_scale", "torque_gain")] == pytest.approx(
        [1.2, 0.8, 1.2, 1.1]
    )
    assert settings.effects() == model.effects


@pytest.mark.parametrize("name", EFFECTS)
def test_every_number_has_a_slider_within_its_bounds(name):
    facts = {f"{name}.{fact.name}": fact for fact in EFFECTS[name].parameters()}
    sliders = effect_sliders(name)
    assert [slider.name for slider in sliders] == list(facts)
    for slider in sliders:
        fact = facts[slider.name]
        assert fact.lower <= slider.lower < slider.upper <= fact.upper
        assert slider.lower <= slider.neutral <= slider.upper
        assert 10 < (slider.upper - slider.lower) / slider.step < 10000
        assert (slider.upper - slider.lower) / fact.scale > 2


def test_a_slider_reaches_what_was_found():
    slider = arm_sliders()[1]
    assert with_value(slider, 12.0).upper == 12.0
    assert with_value(slider, 1.0) == slider
