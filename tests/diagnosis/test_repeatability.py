"""The trial-to-trial scatter is recovered, apart from noise, clock errors and differences of the initial poses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.repeatability import repeatability
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset

from .indicators.recorded import LENGTH, STEP, arcs, swing

TIME = STEP * np.arange(500)
TORQUE = np.where((TIME > 1) & (TIME < 3), 1.0, 0.0)
#: Markers at the tip only: a bending of so many radians moves it by half the length times that.
TIP = LENGTH / 2


def followed(lag=0.15, gain=0.5, late=0.0):
    up, down = (np.maximum(TIME - at - late, 0) for at in (1.0, 3.0))
    return gain * (np.where(up > 0, 1 - np.exp(-up / lag), 0) - np.where(down > 0, 1 - np.exp(-down / lag), 0))


def commanded(bendings, noise=2e-4, torques=None, seed=0):
    return arcs(*bendings, torques=torques or [TORQUE] * len(bendings), noise=noise, markers=(1.0,), seed=seed)


def test_noise_alone_is_no_scatter():
    found = repeatability(commanded([followed()] * 6, noise=5e-4))
    assert len(found.groups) == 1 and found.groups[0].freedom == 5
    assert found.in_plane < 1e-4  # of noise of 0.7 mm in the plane


def test_scatter_of_the_trials_is_found_at_its_size_and_inside_the_interval():
    sizes, covered = [], 0
    for seed in range(12):
        offsets = 0.02 * np.random.default_rng(seed).standard_normal(5)
        found = repeatability(commanded([followed() + offset for offset in offsets], seed=seed))
        sizes.append(found.in_plane**2)
        covered += found.interval[0] <= 0.02 * TIP <= found.interval[1]
    assert np.sqrt(np.mean(sizes)) == pytest.approx(0.02 * TIP, rel=0.2)
    assert covered >= 10
    assert found.moving < 0.25 * found.in_plane  # an offset is none of the motion


def test_two_repeats_are_each_half_of_their_difference():
    found = repeatability(commanded([followed(), followed() + 0.04]))
    assert found.in_plane == pytest.approx(0.04 * TIP / np.sqrt(2), rel=0.02)  # RMS of one, of two that are 0.04 rad apart
    assert found.rest == pytest.approx(0.04 * TIP / np.sqrt(2), rel=0.02)


def test_clocks_that_are_off_by_less_than_two_samples_are_set_alike():
    found = repeatability(commanded([followed(late=late) for late in (-0.012, 0.0, 0.005, 0.014)], noise=5e-5))
    assert found.groups[0].shift == pytest.approx(np.std([-0.012, 0.0, 0.005, 0.014], ddof=1), rel=0.1)
    assert found.in_plane < 2e-4


def test_steps_at_other_instants_are_brought_to_the_same():
    bendings, torques = [], []
    for late in (0.0, 0.1, 0.2):
        up, down = (np.maximum(TIME - at, 0) for at in (1.0 + late, 3.0))
        bendings.append(0.5 * (np.where(up > 0, 1 - np.exp(-up / 0.15), 0) - np.where(down > 0, 1 - np.exp(-down / 0.15), 0)))
        torques.append(np.where((1 + late - 1e-9 < TIME) & (TIME < 3 - 1e-9), 1.0, 0.0))
    found = repeatability(commanded(bendings, torques=torques, noise=5e-5))
    assert len(found.groups) == 1 and found.in_plane < 1e-3  # not aligned they are 7 mm apart


def test_other_commands_are_no_repeats():
    assert repeatability(commanded([followed(gain=0.5), followed(gain=0.6)], torques=[TORQUE, 1.2 * TORQUE])) is None


def test_a_single_trial_repeats_nothing():
    assert repeatability(commanded([followed()])) is None


def test_releases_from_other_places_are_compared_beyond_what_the_start_explains():
    angles = 0.6 + 0.08 * np.random.default_rng(1).standard_normal(12)
    found = repeatability(arcs(*(swing(angle, 1.5, 0.1) for angle in angles), noise=5e-5, markers=(1.0,)))
    (group,) = found.groups
    assert group.kind == "release" and group.allowed_for >= 1 and group.freedom == 12 - 1 - group.allowed_for
    assert group.start > 3e-3 and group.in_plane < 0.1 * group.start
    assert "regression" in found.sentence


def test_what_the_start_does_not_explain_is_left():
    generator = np.random.default_rng(2)
    releases = [
        swing(angle, 1.5, 0.1, rest=0.02 * generator.standard_normal()) for angle in 0.6 + 0.05 * generator.standard_normal(16)
    ]
    found = repeatability(arcs(*releases, noise=5e-5, markers=(1.0,)))
    assert found.in_plane == pytest.approx(0.02 * TIP, rel=0.4)
    assert f"accuracy of any model to {1e3 * found.floor:.2g} mm" in found.sentence


def test_few_releases_are_compared_only_where_they_start_alike():
    assert repeatability(arcs(swing(0.6, 1.5, 0.1), swing(0.8, 1.5, 0.1))) is None
    found = repeatability(arcs(swing(0.6, 1.5, 0.1), swing(0.62, 1.5, 0.1)))
    assert found.groups[0].allowed_for == 0 and "not corrected" in found.sentence
    assert found.floor is None and "accuracy of any model" not in found.sentence  # they differ as far as their starts make them


@pytest.mark.filterwarnings("error")
def test_releases_of_which_one_does_not_show_its_start_are_not_taken_for_alike():
    experiment = arcs(swing(0.6, 1.5, 0.1), swing(0.62, 1.5, 0.1))
    one, other = experiment.runs
    unseen = replace(other, start_pose=np.full_like(other.start_pose, np.nan))
    assert repeatability(experiment) is not None
    assert repeatability(replace(experiment, runs=(one, unseen))) is None


def test_gaps_cost_only_what_they_hide():
    experiment = commanded([followed() + offset for offset in (-0.02, 0.0, 0.02)])
    whole = repeatability(experiment).in_plane
    holes = np.random.default_rng(5)
    for run in experiment.runs:
        run.measured.flags.writeable = True
        run.measured[holes.random(len(run.time)) < 0.3] = np.nan
    assert repeatability(experiment).in_plane == pytest.approx(whole, rel=0.1)


def test_a_marker_that_is_hidden_where_a_release_comes_to_rest_tells_nothing_of_that():
    experiment = arcs(*(swing(angle, 2.0, 0.1) for angle in (0.5, 0.5, 0.5)), noise=1e-4)
    for run in experiment.runs:
        run.measured.flags.writeable = True
        run.measured[-60:, 1] = np.nan
    assert repeatability(experiment).rest < 1e-3  # of the other


def test_it_is_plain_json():
    written = json.loads(json.dumps(repeatability(commanded([followed(), followed()])).to_json(), allow_nan=False))
    assert written["groups"][0]["trials"] == ["trial_1", "trial_2"]


def test_what_repeats_in_the_shared_recordings(shared):
    def of(name):
        return repeatability(prepare(read_dataset(shared / "recordings" / name)))

    assert {group.kind for group in of("real-pneumatic").groups} == {"command"}
    assert sum(len(group.trials) for group in of("real-trunk").groups) == 32
    assert [group.trials for group in of("real-beam").groups] == [("trial_01", "trial_02"), ("trial_03", "trial_04")]
    assert of("sample-steps") is None
