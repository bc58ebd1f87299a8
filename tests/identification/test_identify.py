"""Known arms are identified, from their own recordings and nothing else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.gravity_tilt import GravityTilt
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.identify import identify, simulated
from hsr_pin.identification.part import Part
from hsr_pin.inference import heldout
from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.heldout import leave_one_out
from hsr_pin.inference.residuals import rms


@pytest.fixture(scope="module")
def found(steps):
    return identify(steps)


def test_stiffness_and_damping_of_a_finer_arm_are_recovered(found):
    assert found.fit.named["keq_scale"] == pytest.approx(1.1, rel=2e-3)
    assert found.fit.named["damping_scale"] == pytest.approx(0.8, rel=1e-2)
    assert found.fit.converged


def test_nothing_but_noise_is_left_in_and_out_of_sample(found):
    noise = 3e-4 * 2**0.5  # in the plane
    assert rms(found.before) > 3 * noise
    assert rms(found.after) == pytest.approx(noise, rel=0.03)
    assert rms(found.heldout) == pytest.approx(noise, rel=0.03)
    assert found.experiment.noise_rms == pytest.approx(noise, rel=0.15)


def test_every_stiffness_level_gets_its_own_values(record):
    dataset = record([(1.11, 0.8), (2.33, 1.2)], keq={1.11: 1.2, 2.33: 0.9}, damping={1.11: 0.8, 2.33: 1.3})
    named = identify(dataset, by_level=True).fit.named
    assert named == pytest.approx(
        {"keq_scale@1.11": 1.2, "keq_scale@2.33": 0.9, "damping_scale@1.11": 0.8, "damping_scale@2.33": 1.3}, rel=0.02
    )


def test_the_parameter_of_an_effect_is_recovered_beside_them(record):
    dataset = record([(1.11, 0.5), (1.11, 1.0)], effects=[GravityTilt(angle=0.12)])
    assert identify(dataset, free=("keq", "damping", "gravity_tilt")).fit.named == pytest.approx(
        {"keq_scale": 1.0, "damping_scale": 1.0, "gravity_tilt.angle": 0.12}, abs=0.01
    )


def test_a_swing_out_of_step_is_found_though_the_declared_values_lead_astray(record):
    dataset = record([(1.11, None)], keq=2.2, damping=0.12, seconds=1.0)
    named = identify(dataset).fit.named
    assert named == pytest.approx({"keq_scale": 2.2, "damping_scale": 0.12}, rel=0.06)


def test_trials_that_are_set_aside_do_not_touch_the_fit(steps):
    first = identify(steps, train=("trial_0[12]",))
    last = steps.trials[2]
    spoilt = replace(last, trajectory=replace(last.trajectory, positions=last.trajectory.positions + np.array([0.01, 0, 0])))
    second = identify(replace(steps, trials=(*steps.trials[:2], spoilt)), test=("trial_03",))
    assert [run.trial.name for run in second.heldout_experiment.runs] == ["trial_03"]
    assert second.fit.values == pytest.approx(first.fit.values, rel=1e-6)
    assert rms(second.heldout) > 0.009 > 10 * rms(first.heldout)


def test_leaving_one_trial_out_equals_a_fit_without_it(record):
    dataset = record([(1.11, 0.4), (1.11, 0.8), (1.11, 1.2)], effects=[GravityTilt(angle=0.1)])  # a model that cannot be right
    experiment = prepare(dataset)
    whole = fit(experiment, Hypothesis())
    quick = leave_one_out(experiment, whole)
    for k, run in enumerate(experiment.runs):
        others = replace(experiment, runs=tuple(other for other in experiment.runs if other is not run))
        alone = replace(experiment, runs=(run,))
        refit = fit(others, Hypothesis(), start=whole.values)
        exact = simulated(alone, Hypothesis(), refit.values)
        assert rms([quick[k]]) == pytest.approx(rms(exact), rel=0.05)
        assert rms([quick[k]]) > 1.02 * rms([whole.residuals[k]])


def test_a_simulation_that_fails_is_data_and_not_a_crash(record):
    dataset = record([(1.11, 1.0)], keq=1.0)
    soft = replace(
        dataset, trials=tuple(replace(trial, keq=0.11) for trial in dataset.trials)
    )  # curls up at its declared stiffness
    found = identify(soft)
    assert rms(found.before) > 0.1
    assert found.fit.named["keq_scale"] == pytest.approx(10.0, rel=0.03)


def test_a_parameter_that_ends_on_its_bound_is_reported(record):
    dataset = record([(1.11, 1.0)], damping=0.004, seconds=0.6)
    assert identify(dataset).fit.on_bound() == ("damping_scale",)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"free": ("stiffness",)}, "did you mean stiff"),
        ({"free": ("hysteresis.width",)}, "parameter to fit"),
        ({"free": ()}, "at least one"),
        ({"free": ("keq@3.1",)}, "1.11, 2.33"),
        ({"free": ("keq@soft",)}, "keq_scale"),
        ({"free": ("keq", "keq@1.11")}, "both"),
        ({"train": ("trial_07",)}, "trial_01, trial_02, trial_03"),
        ({"test": ("trial_0*",)}, "at least one"),
        ({"train": ("trial_01",), "test": ("trial_01",)}, "trial_01 in both"),
    ],
)
def test_what_cannot_be_fitted_is_refused(steps, asked, said):
    with pytest.raises(IdentificationError, match=said):
        identify(steps, **asked)


def test_a_recording_of_gaps_only_is_refused(steps):
    blind = [replace(t, trajectory=replace(t.trajectory, positions=np.full((101, 3, 3), np.nan))) for t in steps.trials]
    with pytest.raises(IdentificationError, match="gaps everywhere"):
        identify(replace(steps, trials=tuple(blind)))


def test_a_trial_that_one_step_foretells_far_too_badly_is_foretold_by_a_fit_to_the_others(steps, monkeypatch):
    experiment = prepare(steps)
    whole = fit(experiment, Hypothesis())
    usual = leave_one_out(experiment, whole)
    monkeypatch.setattr(heldout, "without", lambda fitted, others: np.array([0.3, 3.0]))
    again = leave_one_out(experiment, whole)
    assert rms(again) < 1.05 * rms(usual)
    monkeypatch.setattr(heldout, "_AGAIN", 0)
    assert rms(leave_one_out(experiment, whole)) > 10 * rms(usual)


@pytest.mark.parametrize(
    ("values", "bounds"),
    [
        ({"damping_scale": 0.068}, ()),  # of a ratio the logarithm counts: three times the bound is not on it
        ({"damping_scale": 0.0201}, ("damping_scale",)),
        ({"side_force.at": 0.9999}, ()),  # the tip is where the force acts unless the fit moves it
        ({"side_force.at": 0.2001}, ("side_force.at",)),
    ],
)
def test_a_value_is_on_a_bound_that_is_not_its_neutral_value(values, bounds):
    hypothesis = Hypothesis().with_part(Part("side_force", EFFECTS["side_force"](force=0.1)))
    known = {fact.name: fact.neutral for fact in hypothesis.parameters} | {"side_force.force": 0.1} | values
    assert Fit.on_bound(SimpleNamespace(hypothesis=hypothesis, values=np.array([*known.values()]))) == bounds
