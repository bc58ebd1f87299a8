"""A declaration that the recordings contradict is noted before anything is fitted; a sound one is not."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trial


@pytest.fixture(scope="module")
def steps():
    """Two steps of the torque at rest, 0.5 s after the start."""
    trials = []
    for number, torque in enumerate((0.4, -0.7), 1):
        scenario = step_scenario(ArmSpecification(links=6, placement="mid"), torque, duration=3.0, step=0.01)
        commanded = np.where(scenario.time < 0.5, 0.0, torque)
        motion = simulate(replace(scenario, torque=commanded)).trajectory
        noise = 1e-4 * np.random.default_rng(number).standard_normal(motion.positions.shape)
        recorded = replace(motion, positions=motion.positions + noise, joint_angles=None, joint_rates=None)
        trials.append(Trial(f"trial_{number:02d}", recorded, keq=1.11, damping=0.05))
    return Dataset("steps", 0.24, 0.15, 0.04, "hanging", tuple(trials))


def with_each(dataset, **factors):
    trials = (replace(trial, **{key: by * getattr(trial, key) for key, by in factors.items()}) for trial in dataset.trials)
    return replace(dataset, trials=tuple(trials))


@pytest.mark.parametrize("factor", [1000.0, 0.001])
@pytest.mark.parametrize("key, meant", [("keq", "keq of 1.11 Nm/rad"), ("damping", "damping of 0.05 Nm s/rad")])
def test_a_stiffness_or_a_damping_off_by_a_thousand_is_noted_with_what_was_meant(steps, key, meant, factor):
    note = prepare(with_each(steps, **{key: factor})).notes[0]
    assert note.startswith("trial_01, trial_02: the declaration is keq ") and meant in note and "in N mm" in note


def test_one_trial_of_several_that_is_declared_in_another_unit_is_noted(steps):
    spoiled = with_each(replace(steps, trials=steps.trials[1:]), keq=1000.0)
    note = prepare(replace(steps, trials=(steps.trials[0], *spoiled.trials))).notes[0]
    assert note.startswith("trial_02: the declaration is keq 1110 Nm/rad") and "fits keq of 1.11 Nm/rad" in note


@pytest.mark.parametrize("factors", [{}, {"keq": 5.0}, {"keq": 0.2}, {"damping": 20.0}, {"damping": 0.05}])
def test_what_a_fit_can_put_right_is_not_noted(steps, factors):
    assert prepare(with_each(steps, **factors)).notes == ()


def test_a_log_that_is_late_is_told_with_how_late_it_is(steps):
    late = []
    for trial in steps.trials:
        torque = np.concatenate([np.zeros(140), trial.trajectory.torque[:-140]])
        late.append(replace(trial, trajectory=replace(trial.trajectory, torque=torque)))
    note = prepare(replace(steps, trials=tuple(late))).notes[0]
    assert note.startswith("trial_01, trial_02: the motion begins 1.")
    assert abs(float(note.split(" begins ")[1].split()[0]) - 1.4) < 0.05


@pytest.mark.parametrize(
    "name", ["sample-steps", "real-pneumatic", "real-trunk-space", "field/cable-arm/day_b", "field/foreign-s16"]
)
def test_recordings_of_others_are_not_contradicted(shared, name):
    notes = prepare(read_dataset(shared / "recordings" / name)).notes
    assert not any("before its command" in note for note in notes)
