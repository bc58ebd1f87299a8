"""Whatever the laboratory's axes, units and names, the arm comes out in its own frame."""

import itertools

import numpy as np
import pytest

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

BODIES = (Body("base", ("Arm:base",), 0.0), Body("mid", ("Arm:mid",), 0.12), Body("tip", ("tip",), 0.24))


def settings(**changes):
    return ImportSettings(**{"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": BODIES} | changes)


@pytest.fixture
def record(tmp_path, writers):
    """Write a laboratory's motion as a file of a system, with its input beside it."""
    numbers = itertools.count(1)

    def write(lab, system="nexus", names=None, **options):
        path = tmp_path / f"take{next(numbers)}"
        writers[system](path, names or lab.names, lab.positions, **options)
        rows = [f"{t:.6f},{tau}" for t, tau in zip(lab.time[::6], lab.torque[::6], strict=True)]
        path.with_suffix(".input").write_text("t,tau\n" + "\n".join(rows), encoding="utf-8")
        return path

    return write


def error_of(imported, lab, trial=0):
    return np.nanmax(np.abs(imported.dataset.trials[trial].trajectory.positions - lab.world))


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
@pytest.mark.parametrize("system, up", [*itertools.product(["nexus", "tracker", "motive"], ["+z", "+y", "-x"]), ("c3d", "+z")])
def test_known_motion_comes_back(record, laboratory, system, mount, up):
    lab = laboratory(mount, up, yaw=2.2)
    imported = import_recordings([record(lab, system)], settings(up=up, length=0.24))
    dataset = imported.dataset
    assert dataset.mount == mount
    assert [(marker.name, marker.arc_length) for marker in dataset.markers] == [("base", 0.0), ("mid", 0.12), ("tip", 0.24)]
    assert error_of(imported, lab) < 2e-6
    assert imported.out_of_plane[0] < 1e-6 < 0.01 < imported.in_plane[0]


@pytest.mark.parametrize("yaw", np.linspace(-3, 3, 5))
def test_the_plane_is_found_through_noise_spikes_and_gaps(record, laboratory, yaw):
    lab = laboratory(yaw=yaw, noise=5e-4, seed=2)
    rng = np.random.default_rng(0)
    lab.positions[rng.random(lab.positions.shape[:2]) < 0.01] += 0.2
    lab.positions[100:130, 2] = np.nan
    imported = import_recordings([record(lab)], settings())
    median = np.nanmedian(np.abs(imported.dataset.trials[0].trajectory.positions - lab.world))
    assert median < 6e-4
    assert imported.out_of_plane[0] == pytest.approx(5e-4, rel=0.15)


def test_spikes_stay_in_what_is_imported(record, laboratory):
    lab = laboratory()
    lab.positions[77, 2] += 0.3
    tip = import_recordings([record(lab)], settings()).dataset.trials[0].trajectory.marker("tip")
    assert np.linalg.norm(tip[77] - lab.world[77, 2]) == pytest.approx(0.3 * np.sqrt(3), rel=1e-3)


def test_markers_that_stand_off_the_plane_do_not_turn_it(record, laboratory):
    lab = laboratory()
    sideways = np.cross(lab.positions[200, 2] - lab.place, lab.positions[0, 2] - lab.place)
    lab.positions[:, 2] += 0.02 * sideways / np.linalg.norm(sideways)
    tip = import_recordings([record(lab)], settings()).dataset.trials[0].trajectory.marker("tip")
    assert np.allclose(np.abs(tip[:, 1]), 0.02, atol=1e-5)


def test_the_input_tells_which_way_is_positive(record, laboratory):
    lab = laboratory()
    path = record(lab)
    assert error_of(import_recordings([path], settings(inputs=[path.with_suffix(".input")])), lab) < 2e-6
    flipped = path.with_suffix(".flipped")
    flipped.write_text(path.with_suffix(".input").read_text(encoding="utf-8").replace(",0.8", ",-0.8"), encoding="utf-8")
    lab.world[..., :2] *= -1
    assert error_of(import_recordings([path], settings(inputs=[flipped])), lab) < 2e-6


def test_an_axis_tells_which_way_is_positive(record, laboratory):
    lab = laboratory(yaw=0.3)  # bends towards the laboratory's +x, mostly
    path = record(lab)
    assert error_of(import_recordings([path], settings(x="+x")), lab) < 2e-6
    lab.world[..., :2] *= -1
    assert error_of(import_recordings([path], settings(x="-x")), lab) < 2e-6


@pytest.mark.parametrize("axis, said", [("+z", "perpendicular to the arm"), ("+y", "in the bending plane"), ("north", "an axis")])
def test_an_axis_that_cannot_be_is_refused(record, laboratory, axis, said):
    with pytest.raises(InputError, match=said):
        import_recordings([record(laboratory(yaw=0.05))], settings(x=axis))


def test_the_input_is_held_at_the_samples_of_the_capture(record, laboratory):
    lab = laboratory()
    path = record(lab)
    trajectory = import_recordings([path], settings(inputs=[path.with_suffix(".input")])).dataset.trials[0].trajectory
    rows = lab.torque[::6]
    assert np.array_equal(trajectory.torque, np.repeat(rows, 6)[: len(trajectory.time)])


def test_pressures_are_held_too_and_a_late_first_row_is_noted(record, laboratory):
    path = record(laboratory())
    path.with_suffix(".p").write_text("P2,t,P1\n2.0,0.5,1.0\n3.0,1.0,0.5\n", encoding="utf-8")
    trajectory = import_recordings([path], settings(inputs=[path.with_suffix(".p")])).dataset.trials[0].trajectory
    assert np.array_equal(trajectory.pressures[[0, 60, 119, 120]], [[1, 2], [1, 2], [1, 2], [0.5, 3]])
    assert any("begins at 0.5 s" in note for note in trajectory.notes)


@pytest.mark.parametrize(
    "content, said",
    [
        ("t,P1\n0,1\n", "t,P1,P2 or t,tau"),
        ("t,tua\n0,1\n", "did you mean 'tau'"),
        ("t,tau\n0,1\n0,2\n", "increasing"),
        ("t,tau\n0,\n", "a number"),
    ],
)
def test_an_input_that_is_none_is_refused_with_its_place(record, laboratory, content, said):
    path = record(laboratory())
    path.with_suffix(".bad").write_text(content, encoding="utf-8")
    with pytest.raises(RecordingError, match=said) as caught:
        import_recordings([path], settings(inputs=[path.with_suffix(".bad")]))
    assert caught.value.line is not None


def test_arc_lengths_and_length_are_estimated_from_the_straight_pose(record, laboratory):
    lab = laboratory(noise=3e-4)
    dataset = import_recordings([record(lab)], settings(markers=())).dataset
    assert [marker.name for marker in dataset.markers] == ["base", "mid", "tip"]
    assert np.allclose([marker.arc_length for marker in dataset.markers], lab.arcs, atol=5e-4)
    assert dataset.length == dataset.markers[-1].arc_length
    assert sum("estimated" in note for note in dataset.notes) == 2


@pytest.mark.parametrize("bodies", [BODIES[1:], BODIES[2:]])
@pytest.mark.parametrize("mount", ["hanging", "upright"])
def test_without_a_point_at_the_base_the_base_is_estimated(record, laboratory, bodies, mount):
    lab = laboratory(mount, noise=2e-4)
    lab.world = lab.world[:, -len(bodies) :]
    imported = import_recordings([record(lab)], settings(markers=bodies, mount=mount))
    assert error_of(imported, lab) < 1.5e-3


def test_the_place_of_the_base_may_be_given(record, laboratory):
    lab = laboratory()
    lab.world = lab.world[:, 1:]
    imported = import_recordings([record(lab)], settings(markers=BODIES[1:], origin=lab.place))
    assert error_of(imported, lab) < 2e-6


def test_several_points_are_averaged_and_all_of_them_must_be_seen(record, laboratory):
    lab = laboratory()
    offsets = 0.01 * np.array([[1, 0, 0], [-1, 0.5, 0], [0, -0.5, 0]])
    lab.positions = np.concatenate([lab.positions[:, :2], lab.positions[:, 2:] + offsets], axis=1)
    lab.positions[50:55, 3] = np.nan
    names = ("Arm:base", "Arm:mid", "Arm:tip1", "Arm:tip2", "Arm:tip3")
    trial = import_recordings(
        [record(lab, names=names)], settings(markers=(*BODIES[:2], Body("tip", ("tip*",), 0.24)))
    ).dataset.trials[0]
    tip = trial.trajectory.marker("tip")
    assert np.isnan(tip[50:55]).all()
    assert np.nanmax(np.abs(tip - lab.world[:, 2])) < 2e-6
    assert any("5 samples are gaps" in note for note in trial.trajectory.notes)


def test_two_labels_of_one_marker_are_merged(record, laboratory):
    """The system lost the tip twice and gave it a new label each time; of a second marker beside it the mean is taken still."""
    lab = laboratory()
    whole = lab.positions
    labels = np.full((len(whole), 3, 3), np.nan)
    for label, frames in enumerate((slice(0, 100), slice(104, 220), slice(221, None))):
        labels[frames, label] = whole[frames, 2]
    offset = np.array([0.01, 0.0, 0.0])
    lab.positions = np.concatenate([whole[:, :2], labels - offset, whole[:, 2:] + offset], axis=1)
    names = ("Arm:base", "Arm:mid", "Arm:A", "Arm:B", "Arm:C", "Arm:D")
    bodies = (*BODIES[:2], Body("tip", ("A", "B", "C", "D"), 0.24))
    trial = import_recordings([record(lab, names=names)], settings(markers=bodies)).dataset.trials[0]
    tip = trial.trajectory.marker("tip")
    assert np.flatnonzero(np.isnan(tip[:, 0])).tolist() == [100, 101, 102, 103, 220]
    assert np.nanmax(np.abs(tip - lab.world[:, 2])) < 2e-6
    assert any(
        "Arm:A, Arm:B, Arm:C are never seen together and were taken as labels of one marker" in n for n in trial.trajectory.notes
    )


def test_files_of_one_session_share_a_frame_and_each_becomes_a_trial(record, laboratory):
    labs = [laboratory(), laboratory()]
    labs[1].positions = labs[1].positions[:200]
    labs[1].world, labs[1].time, labs[1].torque = labs[1].world[:200], labs[1].time[:200], labs[1].torque[:200]
    paths = [record(lab) for lab in labs]
    imported = import_recordings(paths, settings(keq=[1.11, 2.33], t_start=[0.5], tip_mass=[0.0, 0.1]))
    assert [(trial.name, trial.keq, trial.t_start, trial.tip_mass) for trial in imported.dataset.trials] == [
        ("trial_01", 1.11, 0.5, 0.0),
        ("trial_02", 2.33, 0.5, 0.1),
    ]
    assert max(error_of(imported, lab, trial) for trial, lab in enumerate(labs)) < 2e-6


def test_each_file_may_have_its_own_plane(record, laboratory):
    labs = [laboratory(yaw=0.3), laboratory(yaw=1.9)]
    paths = [record(lab) for lab in labs]
    own = import_recordings(paths, settings(own_plane=True))
    assert max(error_of(own, lab, trial) for trial, lab in enumerate(labs)) < 2e-6
    shared_plane = import_recordings(paths, settings())
    assert max(shared_plane.out_of_plane) > 0.02 > 1e-6 > max(own.out_of_plane)


def test_what_is_imported_can_be_written_and_read(record, laboratory, tmp_path):
    dataset = import_recordings([record(laboratory(noise=3e-4))], settings()).dataset
    write_dataset(dataset, tmp_path / "out")
    again = read_dataset(tmp_path / "out")
    assert np.array_equal(again.trials[0].trajectory.positions, dataset.trials[0].trajectory.positions)


def test_a_wrong_unit_is_noticed(record, laboratory):
    with pytest.raises(RecordingError, match="check the unit"):
        import_recordings([record(laboratory())], settings(unit="m"))


def test_a_wrong_mount_is_noticed(record, laboratory):
    with pytest.raises(InputError, match="an arm that is upright"):
        import_recordings([record(laboratory())], settings(mount="upright"))


def test_a_point_that_is_not_there_is_refused_with_the_nearest(record, laboratory):
    with pytest.raises(RecordingError, match="did you mean 'Arm:tip'"):
        import_recordings([record(laboratory())], settings(markers=(*BODIES[:2], Body("tip", ("Arm:tpi",)))))


def test_an_arm_that_does_not_move_is_refused(record, laboratory):
    lab = laboratory()
    lab.positions[:] = lab.positions[0]
    with pytest.raises(RecordingError, match="no moving marker"):
        import_recordings([record(lab)], settings())


def test_markers_that_are_never_seen_together_are_refused(record, laboratory):
    lab = laboratory()
    lab.positions[::2, 1] = np.nan
    lab.positions[1::2, 2] = np.nan
    with pytest.raises(RecordingError, match="no frame shows all markers"):
        import_recordings([record(lab)], settings())


@pytest.mark.parametrize(
    "change",
    [
        {"mass": 0.0},
        {"keq": []},
        {"keq": [1.0, 2.0]},
        {"mount": "sideways"},
        {"up": "z+"},
        {"origin": (1.0, 2.0)},
        {"t_start": [9.0]},
        {"markers": BODIES[1:2] * 2},
        {"markers": (Body("tip", ("tip",)),)},
    ],
)
def test_settings_that_cannot_be_are_refused(record, laboratory, change):
    path = record(laboratory())
    with pytest.raises(InputError):
        import_recordings([path], settings(**change))


@pytest.mark.parametrize(
    "text, body",
    [
        ("tip", Body("tip", ("tip",))),
        ("tip=Arm:t1+Arm:t2", Body("tip", ("Arm:t1", "Arm:t2"))),
        ("tip@0.24=Arm:t1", Body("tip", ("Arm:t1",), 0.24)),
        ("tip@0.24", Body("tip", ("tip",), 0.24)),
    ],
)
def test_a_body_is_read_from_one_word(text, body):
    assert Body.parse(text) == body


@pytest.mark.parametrize("text", ["", "=x", "tip=a++b", "tip@long=x", "tip@-1=x", "tip@nan=x"])
def test_a_word_that_is_no_body_is_refused(text):
    with pytest.raises(InputError, match="marker"):
        Body.parse(text)


def test_an_arm_that_never_straightens_is_noted(record, laboratory):
    lab = laboratory()
    bent = lab.angle > 0.9
    lab.positions, lab.time, lab.torque = lab.positions[bent], lab.time[bent], lab.torque[bent]
    notes = import_recordings([record(lab)], settings(mount="hanging")).dataset.notes
    assert any(note.startswith("tip: the straightest pose reaches only 9") for note in notes)
