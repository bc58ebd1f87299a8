"""Arms of sections are fitted under the torque of each: never under their sum, or one of them."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.commands import plateaus, steps
from hsr_pin.diagnosis.repeatability import repeated_groups
from hsr_pin.errors import IdentificationError, InputError
from hsr_pin.identification.arm_document import arm_to_json
from hsr_pin.identification.comparison import compare
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import rms
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.motion import Engine
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Section

from ..filmed import filmed

TWO = (Section(0.14, 0.10, 1.6, 0.09), Section(0.10, 0.05, 1.4, 0.06))
ARM = ArmSpecification.in_sections(TWO, links=12, placement="mid", bending_limit=20.0)
MARKERS = (Marker("mid", 0.14), Marker("tip", 0.24))
COMMANDS = ([0.6, 0.2, -0.5, 0.1], [-0.2, 0.5, 0.4, -0.3], [0.1, -0.5, 0.1, 0.5])


def recorded(commands=COMMANDS, keq=1.3, damping=0.8):
    """Trials of the arm, which is declared softer by ``keq`` and more damped by ``damping``; and the same without sections."""
    time = np.arange(101) * 0.01
    stepped = time[:, None] >= 0.1 - 1e-9
    runs = [Scenario(ARM, time, stepped * np.array(each), Settled(0.0), (), MARKERS) for each in commands]
    motions = [result.raise_on_failure().trajectory for result in simulate_batch(runs)]
    numbers = {name: getattr(ARM, name) for name in ("length", "mass", "diameter", "mount", "bending")}
    trials = filmed(motions, 1e-4, 2, (ARM.keq / keq, ARM.damping / damping))
    return Dataset("two", trials=trials, sections=TWO, **numbers)


def under_the_mean(dataset):
    """The same recordings of an arm that is said to have one torque: the mean along it."""
    share = np.kron(np.array([[0.14], [0.10]]) / 0.24, np.eye(2))
    trials = [replace(t, trajectory=replace(t.trajectory, torque=t.trajectory.torque @ share)) for t in dataset.trials]
    return replace(dataset, sections=(), trials=tuple(trials))


def test_the_numbers_of_an_arm_of_sections_are_found():
    dataset = recorded()
    experiment = prepare(dataset)
    assert experiment.runs[0].command.shape == (101, 2)
    np.testing.assert_array_equal(experiment.runs[0].drive, dataset.trials[0].trajectory.torque)
    found = fit(experiment, Hypothesis(links=12))
    np.testing.assert_allclose(found.values, [1.3, 0.8], rtol=2e-3)
    alone = fit(prepare(under_the_mean(dataset)), Hypothesis(links=12))
    assert rms(found.raw_residuals) < 1.02 * experiment.noise_rms and rms(alone.raw_residuals) > 2e-3


def test_a_comparison_and_its_document_have_the_sections():
    dataset = recorded(COMMANDS[:1], keq=1.0, damping=1.0)
    comparison = compare(dataset, links=12, placement="mid")
    assert comparison.errors[-1].rms < 3e-4 and comparison.trials[0].arm.sections == TWO
    np.testing.assert_array_equal(comparison.trials[0].simulated.torque, dataset.trials[0].trajectory.torque)
    found = arm_to_json(comparison.experiment, fit(comparison.experiment, Hypothesis(links=12)))
    assert found["sections"][1] == {"length": 0.10, "mass": 0.05, "keq": 1.4, "damping": 0.06}


def test_trials_whose_torques_are_the_same_in_the_mean_alone_do_not_repeat_each_other():
    other = [0.6 + 0.24, 0.2, -0.5 - 0.336, 0.1]  # as much more on 14 cm as less on 10 cm
    runs = prepare(recorded((COMMANDS[0], COMMANDS[0], other))).runs
    np.testing.assert_allclose(runs[2].torque, runs[0].torque, atol=1e-12)
    assert [[run.trial.name for run in group] for group in repeated_groups(runs)] == [["trial_01", "trial_02"]]


def test_a_step_that_the_mean_does_not_show_is_one():
    (run,) = prepare(recorded(([0.24, 0.0, -0.336, 0.0],))).runs
    np.testing.assert_allclose(run.torque, 0.0, atol=1e-12)
    assert run.span > 0.3 and run.resting == 10 and len(plateaus(run)) == 2
    (step,) = steps(run)
    assert step.instant == pytest.approx(0.1)


def test_inputs_of_other_sections_are_refused():
    dataset = recorded(COMMANDS[:1])
    with pytest.raises(IdentificationError, match="two components of torque, for an arm in space, for each of 2 sections"):
        prepare(replace(dataset, trials=under_the_mean(dataset).trials))
    with pytest.raises(IdentificationError, match="two components of torque, for an arm in space, got"):
        prepare(replace(dataset, sections=()))
    batch = Hypothesis(links=12).arm_batch(prepare(dataset), prepare(dataset).runs[0], np.ones((1, 2)))
    engine = Engine(batch, "compiled")
    with pytest.raises(InputError, match="one for each of 2 sections, or one for all, got 3"):
        engine.deliver(np.zeros((5, 1, 3), dtype=complex), np.zeros((1, 3), dtype=complex), 0.01)
    alike_driven = engine.deliver(np.full((5, 1), 0.3j), np.zeros(1, dtype=complex), 0.01)
    np.testing.assert_allclose(alike_driven.impulse[0, -1], [0.0, 1.2, 0.0, 1.2])


def test_a_curve_in_one_section_beside_steps_in_another_is_held_as_they_are():
    """A curve may be taken as one, in finer cells: then the sections' would not fit together."""
    batch = Hypothesis(links=12).arm_batch(
        prepare(recorded(COMMANDS[:1])), prepare(recorded(COMMANDS[:1])).runs[0], np.ones((1, 2))
    )
    curve, step = 0.4 * np.sin(np.linspace(0, 2 * np.pi, 41)), np.where(np.arange(41) < 20, 0.0, 0.3)
    engine, none = Engine(batch, "compiled"), np.zeros((1, 2), dtype=complex)
    for second, cells in ((step, 1), (curve, 4)):
        torque = np.stack([curve, second], axis=1)[:, None] + 0j
        found = engine.deliver(torque, none, 0.01, smooth=True)
        assert found.per_sample == cells
        np.testing.assert_allclose(found.impulse[0, -1, ::2] / cells, [curve[:-1].sum(), second[:-1].sum()], atol=1e-3)
