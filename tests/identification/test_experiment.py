"""What a dataset is cut down to before anything is fitted, and what is said of the rest."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import informative, moves, prepare, restricted
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker, Trial


def changed(dataset, number, change):
    """The dataset with the positions (T, M, 3) of one trial passed through ``change``."""
    trials = list(dataset.trials)
    trajectory = trials[number].trajectory
    trials[number] = replace(trials[number], trajectory=replace(trajectory, positions=change(trajectory.positions.copy())))
    return replace(dataset, trials=tuple(trials))


def test_a_trial_that_leaves_the_reach_of_the_arm_is_left_out_and_the_others_are_as_they_were(heavy_tip):
    def blown_up(positions):
        positions[20:] *= 4.0
        return positions

    experiment = prepare(changed(heavy_tip, 2, blown_up))
    assert [run.trial.name for run in experiment.runs] == ["trial_01", "trial_02", "trial_04"]
    (note,) = experiment.notes
    assert note.startswith("trial_03 is left out") and "farther from the base than the arm reaches" in note


def test_markers_well_off_the_neutral_line_are_within_reach(heavy_tip):
    aside = heavy_tip
    for number in range(4):
        aside = changed(aside, number, lambda positions: positions + np.array([0.03, 0.0, -0.01]))
    experiment = prepare(aside)
    assert len(experiment.runs) == len(heavy_tip.trials) and not experiment.notes


def test_a_marker_declared_too_near_to_the_base_is_told_and_its_trials_stay(heavy_tip):
    def wrong(marker):
        return replace(marker, arc_length=0.3 * marker.arc_length) if marker.arc_length == 0.24 else marker

    def misplaced(trial):
        markers = tuple(map(wrong, trial.trajectory.markers))
        return replace(trial, trajectory=replace(trial.trajectory, markers=markers))

    experiment = prepare(replace(heavy_tip, trials=tuple(map(misplaced, heavy_tip.trials))))
    assert len(experiment.runs) == len(heavy_tip.trials)
    (note,) = experiment.notes
    assert "in most samples, but is declared 72 mm along the arm; check its arc_length" in note


def test_an_arm_that_rests_elsewhere_in_every_trial_is_said_to_and_one_that_does_not_is_not(heavy_tip):
    scattered = heavy_tip
    for number, aside in enumerate((0.003, -0.003, 0.002, -0.002)):
        scattered = changed(scattered, number, lambda positions, aside=aside: positions + np.array([aside, 0.0, 0.0]))
    experiment = prepare(scattered)
    assert experiment.rest_scatter == pytest.approx(np.std([3e-3, -3e-3, 2e-3, -2e-3], ddof=1), rel=0.1)
    assert experiment.notes == ("the resting position of the arm varies from trial to trial by 2.9 mm (standard deviation)",)
    assert prepare(heavy_tip).rest_scatter == 0 and prepare(heavy_tip).notes == ()


@pytest.mark.parametrize("rest", [0.0, 0.02, 0.2])
def test_noise_is_not_taken_for_rests_that_differ_however_short_they_are(rest):
    motion = simulate(step_scenario(ArmSpecification(), 0.5, rest=rest + 0.02, duration=0.6, step=0.02)).trajectory
    said = 0
    for seed in range(40):
        generator = np.random.default_rng(seed)
        trials = tuple(
            Trial(
                f"t{k}",
                replace(motion, positions=motion.positions + 3e-4 * generator.normal(size=motion.positions.shape)),
                1.11,
                0.05,
            )
            for k in range(6)
        )
        said += prepare(Dataset("still", 0.24, 0.15, 0.04, "hanging", trials)).rest_scatter > 0
    assert said <= 2


def test_what_some_trials_tell_together_is_not_told_by_the_others(heavy_tip):
    apart = changed(heavy_tip, 3, lambda positions: positions + np.array([0.01, 0.0, 0.0]))
    whole = prepare(apart)
    first = restricted(whole, ["trial_01", "trial_02", "trial_03"])
    assert whole.rest_scatter > 4e-3 and len(whole.notes) == 1
    assert first.rest_scatter == 0 and first.notes == ()
    assert [run.trial.name for run in first.runs] == ["trial_01", "trial_02", "trial_03"]


def test_a_marker_that_was_never_seen_in_a_trial_does_not_hide_what_the_others_did(heavy_tip):
    def hidden(positions):
        positions[:, -1] = np.nan
        return positions

    experiment = prepare(changed(heavy_tip, 1, hidden))
    assert len(experiment.runs) == 4
    assert moves(experiment.runs[1].measured, experiment.noise)


def test_a_marker_of_which_one_coordinate_was_never_seen_does_not_hide_what_the_others_did(heavy_tip):
    def flat(positions):
        positions[:, -1, 1] = np.nan
        return positions

    experiment = prepare(changed(heavy_tip, 1, flat))
    assert moves(experiment.runs[1].measured, experiment.noise)


def test_a_trial_in_which_nothing_was_seen_is_left_out(heavy_tip):
    experiment = prepare(changed(heavy_tip, 0, lambda positions: np.full_like(positions, np.nan)))
    assert len(experiment.runs) == 3
    assert "fewer than 10 positions were seen" in experiment.notes[0]


@pytest.mark.parametrize("arc_length", [-0.01, 0.25])
def test_a_marker_that_cannot_be_on_the_arm_is_refused_by_name(heavy_tip, arc_length):
    wrong = tuple(Marker("stray", arc_length) if m.arc_length == 0.24 else m for m in heavy_tip.markers)
    trials = tuple(replace(t, trajectory=replace(t.trajectory, markers=wrong)) for t in heavy_tip.trials)
    with pytest.raises(IdentificationError, match=r"stray.*0\.24 m"):
        prepare(replace(heavy_tip, trials=trials))


def test_a_dataset_without_trials_is_refused(heavy_tip):
    with pytest.raises(IdentificationError, match="at least one"):
        prepare(replace(heavy_tip, trials=()))


def test_arms_that_rest_in_several_places_are_informative_and_in_one_are_not(heavy_tip):
    experiment = prepare(heavy_tip)
    first = experiment.runs[0]
    low, high = (int(reach(first.measured[:, -1, 0])) for reach in (np.argmin, np.argmax))
    still = [replace(first, measured=np.repeat(first.measured[at : at + 1], len(first.time), axis=0)) for at in (low, high, high)]
    assert informative(experiment.of_runs(still)) == still
    assert informative(experiment.of_runs(still[1:])) == []
    assert informative(experiment.of_runs([first, *still[1:]])) == [first]
