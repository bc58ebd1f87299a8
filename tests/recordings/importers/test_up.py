"""Up is taken from what is certain, said, and doubted aloud."""

import numpy as np
import pytest

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

BODIES = (Body("base", ("Arm:base",), 0.0), Body("mid", ("Arm:mid",), 0.12), Body("tip", ("Arm:tip",), 0.24))


def imported(path, **changes):
    return import_recordings(
        [path], ImportSettings(**{"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": BODIES} | changes)
    )


@pytest.fixture
def take(tmp_path, writers):
    def write(lab, system="trc", **options):
        writers[system](tmp_path / "take", lab.names, lab.positions, **options)
        return tmp_path / "take"

    return write


def error_of(made, lab):
    return np.nanmax(np.abs(made.dataset.trials[0].trajectory.positions - lab.world))


def test_a_file_that_does_not_tell_is_asked_about(laboratory, take):
    with pytest.raises(InputError, match=r"up: expected the axis .* TRC files do not state it .* --up .* --mount hanging"):
        imported(take(laboratory()))


@pytest.mark.parametrize("mount", ["hanging", "upright"])
@pytest.mark.parametrize("up", ["+z", "+y", "-x"])
def test_an_arm_that_is_plumb_at_rest_tells(laboratory, take, mount, up):
    lab = laboratory(mount, up)
    made = imported(take(lab), mount=mount)
    assert error_of(made, lab) < 2e-6
    assert made.dataset.notes[0] == f"imported: {mount} arm, {up} of the laboratory is up, from the arm, which is {mount} at rest"
    assert made.warnings == ()


def test_an_arm_that_is_not_plumb_does_not_tell(laboratory, take):
    with pytest.raises(InputError, match="up"):
        imported(take(laboratory("horizontal")), mount="horizontal")


def test_an_axis_that_is_told_is_right_whatever_the_file_says(laboratory, take):
    lab = laboratory("hanging", "+y")
    made = imported(take(lab, "qualisys"), up="+y")
    assert error_of(made, lab) < 2e-6
    assert "+y of the laboratory is up, as given" in made.dataset.notes[0]


def test_a_convention_that_is_used_is_said(laboratory, take):
    assert (
        "+z of the laboratory is up, by the convention of Qualisys" in imported(take(laboratory(), "qualisys")).dataset.notes[0]
    )
    lab = laboratory("hanging", "+y")
    assert "+y of the laboratory is up, by the convention of Motive" in imported(take(lab, "motive")).dataset.notes[0]


def test_a_convention_that_the_arm_contradicts_is_refused_with_what_to_try(laboratory, take):
    with pytest.raises(
        InputError,
        match=r"one that points -?[0-4] deg .* \+z .* was taken as up, by the convention of Qualisys; .* give --up",
    ):
        imported(take(laboratory("hanging", "+y"), "qualisys"), mount="hanging")


def test_a_soft_arm_with_the_wrong_axis_up_is_not_horizontal_without_a_word(laboratory, take):
    """It hangs along the laboratory's y, which the file of a system with z up does not tell; it swings across both."""
    lab = laboratory("hanging", "+y", yaw=1.1)
    made = imported(take(lab, "qualisys"))
    assert made.dataset.mount == "horizontal"
    (warning,) = made.warnings
    assert "of motion out of the plane" in warning
    assert "another axis is up (--up)" in warning


def test_a_base_that_moves_is_warned_of_and_one_that_is_carried_about_refused(laboratory, take):
    lab = laboratory()
    drift = np.linspace(0, 1, len(lab.positions))[:, None, None] * np.array([0.0, 1.0, 0.0])
    lab.positions += 0.1 * drift
    (warning,) = imported(take(lab, "qualisys")).warnings
    assert "the base moves by up to 0.0496 m" in warning
    lab.positions += 2 * drift
    with pytest.raises(RecordingError, match=r"the base, 'base', moves: expected a clamped base; .* got 1\.0\d m of motion"):
        imported(take(lab, "qualisys"))


def test_a_good_import_is_not_warned_of(laboratory, take):
    assert imported(take(laboratory(noise=5e-4), "qualisys")).warnings == ()


def test_files_that_have_different_axes_up_are_not_mixed(laboratory, tmp_path, writers):
    lab = laboratory()
    paths = []
    for system in ("qualisys", "motive"):
        writers[system](tmp_path / system, lab.names, lab.positions)
        paths.append(tmp_path / system)
    given = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": BODIES}
    with pytest.raises(InputError, match=r"up: expected files of one laboratory, got \+y, \+z; give the axis"):
        import_recordings(paths, ImportSettings(**given))
    assert error_of(import_recordings(paths, ImportSettings(**given, up="+z")), lab) < 2e-6


@pytest.mark.parametrize("side, x", [(1.0, None), (-1.0, None), (1.0, "-y")])
def test_an_arm_that_moves_in_a_horizontal_plane_comes_in_without_gravity_in_it(laboratory, tmp_path, side, x):
    """The arm bends to the left or to the right, seen from above; positive is where the input bends it, or what --x says."""
    lab = laboratory("horizontal")
    along, down = lab.world[..., 0], -lab.world[..., 2]
    yaw = 0.3
    level = np.stack([along, side * down, 0 * along], axis=-1)
    turned = level @ np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]) + [1.0, 2.0, 0.5]
    columns = np.column_stack([lab.time, turned.reshape(len(turned), -1), lab.torque])
    names = ["t", *(f"{name}{axis}" for name in "bmt" for axis in "xyz"), "tau"]
    np.savetxt(tmp_path / "run.csv", columns, delimiter=",", comments="", header=",".join(names))
    points = "".join(f'{name} = ["{key}x", "{key}y", "{key}z"]\n' for name, key in (("base", "b"), ("mid", "m"), ("tip", "t")))
    text = f'[time]\ncolumn = "t"\n[space]\nup = "+z"\n[points]\n{points}[input]\ntau = "tau"\n'
    (tmp_path / "map.toml").write_text(text, encoding="utf-8")
    bodies = [Body(name, (name,), arc) for name, arc in zip(("base", "mid", "tip"), lab.arcs, strict=True)]
    settings = ImportSettings(0.15, 0.04, [1.11], markers=bodies, mapping=read_mapping(tmp_path / "map.toml"), mount="flat", x=x)
    imported = import_recordings([tmp_path / "run.csv"], settings)
    assert imported.warnings == ()
    write_dataset(imported.dataset, tmp_path / "arm")
    dataset = read_dataset(tmp_path / "arm")
    assert (dataset.mount, dataset.bending) == ("flat", "plane")
    positive = lab.world * [1, 1, -1 if x else 1]
    assert np.abs(dataset.trials[0].trajectory.positions - positive).max() < 2e-6
