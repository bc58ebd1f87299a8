"""Commands that may be held or go straight from sample to sample, where nobody says which."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.effects import EFFECTS
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.identify import identify
from hsr_pin.identification.input_form import alternative_forms, best_form, form_of, is_open, with_form
from hsr_pin.inference.fit import fit

TIME = 0.02 * np.arange(101)
WAVES = [(1.11, size * np.sin(way * np.clip(TIME - 0.1, 0.0, None))) for size, way in ((0.7, 6.0), (-0.5, 11.0), (0.6, 8.0))]


def at_half_the_rate(dataset):
    """Every other sample: half a sample is 10 ms."""

    def thinned(trial):
        seen = trial.trajectory
        coarse = replace(seen, time=seen.time[::2], positions=seen.positions[::2], torque=seen.torque[::2])
        return replace(trial, trajectory=coarse)

    return replace(dataset, trials=tuple(map(thinned, dataset.trials)))


@pytest.fixture(scope="module")
def waves(record):
    """Recordings that tell nothing of what their commands do between samples, made in one way or the other."""

    def made(interpolated, effects=()):
        fine = [(keq, np.interp(0.01 * np.arange(201), TIME, wave)) for keq, wave in WAVES]
        if not interpolated:
            fine = [(keq, np.repeat(wave, 2)[:201]) for keq, wave in WAVES]
        return at_half_the_rate(record(fine, keq=1.1, seconds=2.0, effects=effects, interpolated=interpolated, noise=1e-4))

    return made


@pytest.mark.parametrize("straight", [False, True])
def test_what_is_not_declared_the_recordings_tell(waves, straight):
    found = identify(waves(straight))
    assert form_of(found.experiment) == ("straight" if straight else "held")
    assert found.fit.named == pytest.approx({"keq_scale": 1.1, "damping_scale": 1.0}, rel=0.01)
    told = [note for note in found.experiment.notes if "is interpolated linearly between samples" in note]
    assert told == ([f"the command of trial_01, trial_02, trial_03 {told[0].partition(' trial_03 ')[2]}"] if straight else [])


def test_trials_that_are_set_aside_are_taken_alike(waves):
    found = identify(waves(True), test=["trial_03"])
    assert found.heldout_experiment.runs[0].interpolated and form_of(found.experiment) == "straight"


def test_what_is_declared_stays(waves):
    dataset = waves(True)
    declared = replace(dataset, trials=tuple(replace(trial, interpolated=False) for trial in dataset.trials))
    experiment = prepare(declared)
    assert alternative_forms(experiment) == []
    assert best_form(experiment, fit(experiment, Hypothesis()))[0] is experiment


def test_steps_alone_are_held(steps):
    experiment = prepare(steps)
    assert all(map(is_open, experiment.runs)) and alternative_forms(experiment) == []
    assert with_form(experiment, "steps held").notes == experiment.notes


@pytest.mark.parametrize("form", ["held", "steps held", "straight"])
def test_beside_curves_steps_are_taken_as_they_fit_too(waves, record, form):
    """Steps of a controller that is faster than its recording come somewhere between two samples."""
    fine = np.where(0.01 * np.arange(201) < (0.385 if form == "straight" else 0.395), 0.0, 0.8)
    steps = at_half_the_rate(record([(1.11, side * fine) for side in (1, -1)], keq=1.1, seconds=2.0, noise=1e-4))
    named = (replace(trial, name=f"step_{k}") for k, trial in enumerate(steps.trials))
    dataset = waves(form != "held")
    found = identify(replace(dataset, trials=(*dataset.trials, *named)))
    assert form_of(found.experiment) == form
    assert found.fit.named == pytest.approx({"keq_scale": 1.1, "damping_scale": 1.0}, rel=0.02)


def test_without_the_lag_it_has_an_arm_looks_held_and_the_diagnosis_finds_both(waves, record):
    lag = [EFFECTS["actuator_lag"](0.03)]
    steps = at_half_the_rate(record([(1.11, 0.8), (1.11, -0.6)], keq=1.1, seconds=2.0, effects=lag, noise=1e-4))
    dataset = waves(True, lag)
    named = (replace(trial, name=f"step_{k}") for k, trial in enumerate(steps.trials))
    dataset = replace(dataset, trials=(*dataset.trials, *named))
    alone, _ = best_form(prepare(dataset), fit(prepare(dataset), Hypothesis()))
    assert form_of(alone) == "held"
    found = diagnose(dataset, effects=["tip_mass", "actuator_lag", "stiffening"], max_effects=2, jobs=1)
    assert form_of(found.experiment) == "steps held" and found.verdict.effects == ("actuator_lag",)
    assert found.search.best.fit.named["actuator_lag.time_constant"] == pytest.approx(0.03, rel=0.03)
