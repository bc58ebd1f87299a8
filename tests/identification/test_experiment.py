"""What a dataset is cut down to before anything is fitted, and what is said of the rest."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import moves, prepare
from hsr_pin.trajectory import Marker


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
    experiment = prepare(changed(heavy_tip, 2, lambda positions: positions + np.array([0.03, 0.0, -0.01])))
    assert len(experiment.runs) == len(heavy_tip.trials) and not experiment.notes


def test_a_marker_that_was_never_seen_in_a_trial_does_not_hide_what_the_others_did(heavy_tip):
    def hidden(positions):
        positions[:, -1] = np.nan
        return positions

    experiment = prepare(changed(heavy_tip, 1, hidden))
    assert len(experiment.runs) == 4
    assert moves(experiment.runs[1], experiment.noise)


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
