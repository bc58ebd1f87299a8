"""An arm in space comes in as it was: nothing is put into a plane, and what drove it, turned it and stood beside it is kept."""

import cmath
import importlib.util
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.import_ import command
from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.declared import declared_settings
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.importers.warnings import warnings
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.trajectory import Dataset, Marker, Section, Trajectory, Trial

HERE = Path(__file__).resolve().parent
spec = importlib.util.spec_from_file_location("in_space", HERE / "in_space.py")
in_space = importlib.util.module_from_spec(spec)
spec.loader.exec_module(in_space)
SpaceLaboratory = in_space.SpaceLaboratory

ARM = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "bending": "space"}
BODIES = (Body("base", ("base",), 0.0), Body("middle", ("middle",), 0.14), Body("tip", ("tip",), 0.24))
SIDE = Body("side", ("side",), 0.24, 0.03, 0.7)
TWO = """\
[robot]
mass = 0.15
diameter = 0.04
bending = "space"

[[section]]
length = 0.14
keq = 1.6
damping = 0.09

[[section]]
length = 0.10
keq = 1.4
damping = 0.06

[[input]]
section = 1
columns = ["P1", "P2", "P3"]
gain = 0.3

[[input]]
section = 2
columns = ["P4", "P5", "P6"]
gain = 0.25

[[measured]]
columns = ["P1 seen"]
"""


def table(path, names, columns):
    rows = [",".join(map(repr, row)) for row in np.concatenate(columns, axis=1).tolist()]
    path.write_text("\n".join([",".join(names), *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def take(tmp_path):
    """A table in the laboratory's axes, exact to the last digit, and its mapping."""

    def write(names, time, positions, extra="", turns=None):
        header = ["clock", *(f"{name} {axis}" for name in names for axis in "xyz")]
        columns = [time[:, None], positions.reshape(len(time), -1)]
        text = '[time]\ncolumn = "clock"\n[points]\n'
        text += "".join(f'{name} = ["{name} x", "{name} y", "{name} z"]\n' for name in names)
        if turns is not None:
            header += [f"{name} q{part}" for name in names for part in "wxyz"]
            columns.append(turns.reshape(len(time), -1))
            text += "[poses]\n" + "".join(f'{n} = ["{n} qw", "{n} qx", "{n} qy", "{n} qz"]\n' for n in names)
        (tmp_path / "map.toml").write_text(text + extra, encoding="utf-8")
        return table(tmp_path / "take.csv", header, columns), read_mapping(tmp_path / "map.toml")

    return write


def of(lab, take, extra="", turns=None, **changes):
    path, mapping = take(lab.names, lab.time, lab.positions, extra, turns)
    given = {**ARM, "markers": (*BODIES, SIDE), "mapping": mapping, "origin": lab.place, "x": lab.x()} | changes
    return [path], ImportSettings(**given)


@pytest.fixture(scope="module", params=["hanging", "upright", "horizontal"])
def plant(request, tmp_path_factory):
    """What a plant that shares no code with hsr_pin recorded, read as it is."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")
    from dataclasses import replace

    from hsr_pin.blind.plants.nuisance import Nuisance
    from hsr_pin.blind.plants.space.chain import BallPlant
    from hsr_pin.blind.plants.space.program import program
    from hsr_pin.blind.plants.space.writing import MARKERS

    steps = program("steps", request.param)
    short = replace(steps, trials=steps.trials[:2])
    folder = tmp_path_factory.mktemp("plant") / "arm"
    return read_dataset(BallPlant(elements=8, step=1e-3).run(short, [], 5, folder, Nuisance(noise=1e-4), MARKERS))


@pytest.mark.parametrize("up", ["+z", "+y"])
@pytest.mark.parametrize("system", ["table", "c3d"])
def test_a_recording_of_an_independent_plant_comes_back_from_the_axes_of_a_laboratory(plant, system, up, tmp_path, writers):
    lab = SpaceLaboratory(plant.mount, up, yaw=0.6, seconds=0.1)
    names, files, inputs = [marker.name for marker in plant.markers], [], []
    for trial in plant.trials:
        motion = trial.trajectory
        seen, files = motion.positions @ lab.laboratory.T + lab.place, [*files, tmp_path / f"{trial.name}.take"]
        if system == "table":
            columns = [motion.time[:, None], seen.reshape(len(motion.time), -1)]
            table(files[-1], ["t", *(f"{name}.{axis}" for name in names for axis in "XYZ")], columns)
        else:
            writers["c3d"](files[-1], names, seen, unit="m", rate=100.0)
        input_file = tmp_path / f"{trial.name}.csv"
        inputs.append(table(input_file, ["t", "tau_y", "tau_x"], [motion.time[:, None], motion.torque[:, ::-1]]))
    points = "".join(f'{name} = ["{name}.X", "{name}.Y", "{name}.Z"]\n' for name in names)
    (tmp_path / "map.toml").write_text(f'[time]\ncolumn = "t"\n[points]\n{points}', encoding="utf-8")
    first = plant.trials[0]
    settings = ImportSettings(
        mass=plant.mass, diameter=plant.diameter, bending="space", torsion=plant.torsion, origin=lab.place, up=up,
        keq=[trial.keq for trial in plant.trials], damping=[first.damping], inputs=inputs, name="arm", mount=plant.mount,
        x=lab.x(),
        mapping=read_mapping(tmp_path / "map.toml") if system == "table" else None,
        markers=[Body(m.name, (m.name,), m.arc_length, m.radius, m.angle) for m in plant.markers],
    )  # fmt: skip
    imported = import_recordings(files, settings)
    assert imported.warnings == ()
    write_dataset(imported.dataset, tmp_path / "arm")
    made = read_dataset(tmp_path / "arm")
    assert {marker.name: marker for marker in made.markers} == {marker.name: marker for marker in plant.markers}
    for name in ("length", "mass", "diameter", "mount", "bending", "torsion", "sections", "channels"):
        assert getattr(made, name) == getattr(plant, name)
    exact = 1e-12 if system == "table" else 3e-7  # a C3D has numbers of 32 bits
    for ours, theirs in zip(made.trials, plant.trials, strict=True):
        assert (ours.keq, ours.damping, ours.starts_at_rest) == (theirs.keq, theirs.damping, theirs.starts_at_rest)
        np.testing.assert_array_equal(ours.trajectory.torque, theirs.trajectory.torque)
        np.testing.assert_allclose(ours.trajectory.time, theirs.trajectory.time, atol=1e-12)
        for name in names:
            np.testing.assert_allclose(ours.trajectory.marker(name), theirs.trajectory.marker(name), rtol=0, atol=exact)


@pytest.mark.parametrize("mount", ["hanging", "upright"])
@pytest.mark.parametrize("up", ["+z", "+y"])
def test_known_motion_in_space_comes_back(mount, up, take):
    lab = SpaceLaboratory(mount, up, yaw=2.2)
    imported = import_recordings(*of(lab, take, up=up))
    dataset = imported.dataset
    assert (dataset.bending, dataset.mount) == ("space", mount)
    assert np.abs(dataset.trials[0].trajectory.positions - lab.world).max() < 1e-12
    assert imported.out_of_plane[0] > 0.01


def test_x_is_an_axis_of_the_laboratory_where_nothing_else_is_said(take):
    lab = SpaceLaboratory()
    imported = import_recordings(*of(lab, take, x=None, up="+z"))
    assert np.abs(imported.dataset.trials[0].trajectory.positions - lab.world).max() < 1e-12
    assert any("x is +x of the laboratory, the default" in note for note in imported.dataset.trials[0].trajectory.notes)


def test_chambers_and_measured_channels_of_sections_come_with_their_map(take, tmp_path):
    lab = SpaceLaboratory(yaw=0.4)
    seen = lab.pressures[:, :1] - 0.1
    names = ["t", "valve", "P1", "P2", "P3", "P4", "P5", "P6", "P1 seen"]
    commands = table(tmp_path / "p.csv", names, [lab.time[:, None], 0 * lab.time[:, None], lab.pressures, seen])
    path, mapping = take(lab.names, lab.time, lab.positions, TWO)
    settings = declared_settings(mapping, markers=BODIES, inputs=[commands], up="+z", x=lab.x(), origin=lab.place)
    imported = import_recordings([path], settings)
    assert imported.warnings == ()
    write_dataset(imported.dataset, tmp_path / "arm")
    dataset = read_dataset(tmp_path / "arm")
    (trial,) = dataset.trials
    assert [(section.length, section.keq) for section in dataset.sections] == [(0.14, 1.6), (0.10, 1.4)]
    assert [channel.name for channel in dataset.channels] == names[2:]
    assert dataset.channels[-1].torque == ()
    np.testing.assert_allclose(trial.trajectory.torque, lab.torque, atol=1e-12)
    np.testing.assert_array_equal(trial.trajectory.channels[:, 6], seen[:, 0])
    assert trial.keq == pytest.approx(1 / (1 / 1.6 + 1 / 1.4))
    assert trial.damping == pytest.approx(0.09 * (14 / 24) ** 2 + 0.06 * (10 / 24) ** 2)


def test_columns_of_other_names_are_said_with_from(take, tmp_path):
    lab = SpaceLaboratory()
    commands = table(tmp_path / "p.csv", ["when", *(f"{k}, bar" for k in range(6)), "s"],
                     [1e3 * lab.time[:, None] + 5e3, lab.pressures, lab.pressures[:, :1]])  # fmt: skip
    text = commands.read_text(encoding="utf-8").split("\n", 1)[1]
    commands.write_text('when,"0, bar","1, bar","2, bar",c,d,e,s\n' + text, encoding="utf-8")
    extra = TWO.replace("gain = 0.3\n", 'gain = 0.3\nfrom = ["0, bar", "1, bar", 4]\ntime = "when"\ntime_unit = "ms"\n')
    extra = extra.replace("gain = 0.25", 'gain = 0.25\nfrom = ["c", "d", "e"]').replace(
        '["P1 seen"]', '["P1 seen"]\nfrom = ["s"]'
    )
    path, mapping = take(lab.names, lab.time + 5, lab.positions, extra.replace("time_unit", 'clock = "shared"\ntime_unit'))
    settings = declared_settings(mapping, markers=BODIES, inputs=[commands], up="+z", origin=lab.place)
    (trial,) = import_recordings([path], settings).dataset.trials
    np.testing.assert_allclose(trial.trajectory.torque, lab.torque, atol=1e-9)


def test_a_gain_makes_every_column_a_chamber(take, tmp_path):
    lab = SpaceLaboratory(gains=(0.3, 0.0))
    commands = table(tmp_path / "p.csv", ["t", "A", "B", "C"], [lab.time[:, None], lab.pressures[:, :3]])
    dataset = import_recordings(*of(lab, take, up="+z", inputs=[commands], gain=0.3)).dataset
    assert [channel.name for channel in dataset.channels] == ["A", "B", "C"]
    np.testing.assert_allclose(dataset.trials[0].trajectory.torque, lab.torque[:, :2], atol=1e-12)


def test_measured_inputs_go_straight_from_row_to_row(take, tmp_path):
    lab = SpaceLaboratory(gains=(0.3, 0.0))
    commands = table(tmp_path / "p.csv", ["t", "A", "B", "C"], [lab.time[::7, None], lab.pressures[::7, :3]])
    (trial,) = import_recordings(*of(lab, take, up="+z", inputs=[commands], gain=0.3, interpolated=True)).dataset.trials
    assert trial.interpolated
    midst = np.arange(7, len(lab.time) - 7, 7) + 3  # three sevenths of the way to the next row
    expected = 4 / 7 * lab.pressures[midst - 3, :3] + 3 / 7 * lab.pressures[midst + 4, :3]
    np.testing.assert_allclose(trial.trajectory.channels[midst], expected, atol=1e-12)


def test_a_mapping_may_name_torques_of_sections(take):
    lab = SpaceLaboratory()
    extra = '[input]\ntau_y_1 = 15\ntau_x_1 = 14\ntau_x_2 = 16\ntau_y_2 = 17\nunit = "Nmm"\n'
    path, _ = take(lab.names, lab.time, lab.positions)
    text = path.read_text(encoding="utf-8").splitlines()
    torques = (",".join(map(repr, row)) for row in (1e3 * lab.torque).tolist())
    path.write_text(
        "\n".join([text[0] + ",a,b,c,d", *map(",".join, zip(text[1:], torques, strict=True))]) + "\n", encoding="utf-8"
    )
    mapping = path.with_name("map.toml")
    sections = TWO[TWO.index("[[section]]") : TWO.index("[[input]]")]
    mapping.write_text(mapping.read_text(encoding="utf-8") + extra + sections, encoding="utf-8")
    settings = declared_settings(read_mapping(mapping), **ARM, markers=BODIES, up="+z", origin=lab.place)
    (trial,) = import_recordings([path], settings).dataset.trials
    np.testing.assert_allclose(trial.trajectory.torque, lab.torque, atol=1e-12)
    assert trial.keq == 1.11  # said beside the mapping


def test_commands_that_are_no_torques_of_the_arm_are_refused(take):
    lab = SpaceLaboratory()
    extra = '[input]\nP1 = "tip x"\nP2 = "tip y"\n'
    with pytest.raises(RecordingError, match="input: expected tau_x and tau_y, got P1 and P2; declare chambers and tendons"):
        import_recordings(*of(lab, take, extra, up="+z"))


@pytest.mark.parametrize("yaw", [0.0, 0.9, -2.5])
def test_x_may_be_told_from_the_input(take, tmp_path, yaw):
    lab = SpaceLaboratory(yaw=yaw, gains=(0.3, 0.0))
    commands = table(tmp_path / "p.csv", ["t", "A", "B", "C"], [lab.time[:, None], lab.pressures[:, :3]])
    imported = import_recordings(*of(lab, take, up="+z", inputs=[commands], gain=0.3, x="input"))
    assert imported.warnings == ()
    assert np.abs(imported.dataset.trials[0].trajectory.positions - lab.world).max() < 2e-3


def test_an_arm_that_goes_beside_its_input_is_a_warning(take, tmp_path):
    lab = SpaceLaboratory(yaw=np.pi / 2, gains=(0.3, 0.0))
    commands = table(tmp_path / "p.csv", ["t", "A", "B", "C"], [lab.time[:, None], lab.pressures[:, :3]])
    (warning,) = import_recordings(*of(lab, take, up="+z", x=None, inputs=[commands], gain=0.3)).warnings
    assert "the arm bends -90 deg away from the direction of its input" in warning


def test_the_side_of_a_marker_is_estimated_where_it_is_not_said(take):
    lab = SpaceLaboratory(yaw=0.4)
    side = Body("side", ("side",), 0.24, 0.03)
    dataset = import_recordings(*of(lab, take, up="+z", markers=(*BODIES, side))).dataset
    (marker,) = [marker for marker in dataset.markers if marker.name == "side"]
    assert (marker.radius, marker.angle) == (0.03, pytest.approx(0.7, abs=1e-4))
    assert any("side: angle 0.7 rad was estimated" in note for note in dataset.notes)


def posed(name="tip", pose="straight"):
    return [body if body.name != name else Body(name, (name,), 0.24, pose=pose) for body in BODIES]


def check_pose(dataset, lab, atol):
    expected = lab.beside("tip", 0.02)
    for k, axis in enumerate("xy"):
        np.testing.assert_allclose(dataset.trials[0].trajectory.marker(f"tip:{axis}"), expected[:, k], atol=atol)
    found = {marker.name: marker for marker in dataset.markers}
    assert found["tip:y"].arc_length == 0.24
    assert found["tip:y"].offset == pytest.approx(0.02j)


@pytest.mark.parametrize("mount", ["hanging", "upright"])
@pytest.mark.parametrize("up", ["+z", "+y"])
def test_the_orientation_of_a_body_is_brought_to_its_link(mount, up, take, tmp_path):
    lab = SpaceLaboratory(mount, up, yaw=1.1)
    dataset = import_recordings(*of(lab, take, up=up, turns=lab.turns, markers=posed())).dataset
    write_dataset(dataset, tmp_path / "arm")
    check_pose(read_dataset(tmp_path / "arm"), lab, 1e-9)


def test_an_orientation_that_is_the_links_is_taken_as_it_is_though_the_arm_is_never_straight(take):
    lab = SpaceLaboratory(body=(0, 0, 0), yaw=1.1)
    for name in ("time", "positions", "turns", "world", "axes"):
        setattr(lab, name, getattr(lab, name)[150:])
    made = {
        pose: import_recordings(*of(lab, take, turns=lab.turns, markers=posed(pose=pose), up="+z"))
        for pose in ("link", "straight")
    }
    check_pose(made["link"].dataset, lab, 1e-9)
    with pytest.raises(AssertionError):
        check_pose(made["straight"].dataset, lab, 1e-4)


def motive_bodies(path, lab, legacy=False):
    """Rigid bodies of Motive, as it writes them: quaternions with their real part last, y up."""
    turns, places = np.roll(lab.turns, -1, axis=-1), lab.positions
    if legacy:
        lines = ['comment,"OptiTrack Export Data"', "righthanded", "info,version,1.1", f"info,framecount,{len(places)}"]
        lines += [f'rigidbody,"{name}",{k},0' for k, name in enumerate(lab.names)]
        for i in range(len(places)):
            each = [[k, *places[i, k], *turns[i, k], 0, 0, 0] for k in range(len(lab.names))]
            numbers = [float(value) for body in each for value in body[1:]]
            fields = [cell for k in range(len(each)) for cell in (k, *map(repr, numbers[10 * k : 10 * k + 10]))]
            lines.append(",".join(map(str, ["frame", i, i / 100, len(each), *fields, 0])))
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path
    kinds = [*["Rotation"] * 4, *["Position"] * 3, "Mean Marker Error"]
    rows = [["Format Version", "1.23", "Rotation Type", "Quaternion", "Length Units", "Meters", "Coordinate Space", "Global"], []]
    rows += [["", "Type", *["Rigid Body"] * 8 * len(lab.names)], ["", "Name", *[name for name in lab.names for _ in range(8)]]]
    rows += [["", "ID", *["1"] * 8 * len(lab.names)], ["", "", *kinds * len(lab.names)]]
    rows.append(["Frame", "Time (Seconds)", *["X", "Y", "Z", "W", "X", "Y", "Z", ""] * len(lab.names)])
    for i in range(len(places)):
        each = [[*turns[i, k].tolist(), *places[i, k].tolist(), 0.001] for k in range(len(lab.names))]
        rows.append([i, f"{i / 100:.6f}", *(value for body in each for value in body)])
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("legacy", [False, True])
def test_rigid_bodies_of_motive_bring_their_poses(tmp_path, legacy):
    lab = SpaceLaboratory(up="+y", yaw=0.3)
    path = motive_bodies(tmp_path / "take.csv", lab, legacy)
    settings = ImportSettings(**ARM, markers=posed(), origin=lab.place, x=lab.x())
    check_pose(import_recordings([path], settings).dataset, lab, 1e-8)


def test_poses_of_a_bag_are_put_on_one_clock_and_turned_the_short_way(tmp_path):
    pytest.importorskip("rosbags", reason="needs rosbags (group ros)")
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    lab = SpaceLaboratory(yaw=0.3)
    lab.turns[::2] *= -1  # the same rotations
    store = get_typestore(Stores.ROS2_HUMBLE)
    types, kind = store.types, "geometry_msgs/msg/PoseStamped"
    with Writer(tmp_path / "run", version=8) as writer:
        topics = {name: writer.add_connection(f"/{name}", kind, typestore=store) for name in (*lab.names, "late")}
        for i, t in enumerate(lab.time):
            at = 1_700_000_000_000_000_000 + round(1e9 * t)
            stamp = types["builtin_interfaces/msg/Time"](sec=at // 10**9, nanosec=at % 10**9)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="world")
            for k, name in enumerate(lab.names):
                w, x, y, z = lab.turns[i, k]
                turn = types["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w)
                place = types["geometry_msgs/msg/Point"](*lab.positions[i, k])
                message = types[kind](header, types["geometry_msgs/msg/Pose"](place, turn))
                writer.write(topics[name], at, store.serialize_cdr(message, kind))
                if name == "tip":
                    at += 5_000_000
                    stamp = types["builtin_interfaces/msg/Time"](sec=at // 10**9, nanosec=at % 10**9)
                    late = types["std_msgs/msg/Header"](stamp=stamp, frame_id="world")
                    writer.write(topics["late"], at, store.serialize_cdr(types[kind](late, message.pose), kind))
    bodies = [Body(body.name, (f"/{body.name}",), body.arc_length, pose=body.pose) for body in posed()]
    settings = ImportSettings(**ARM, markers=bodies, origin=lab.place, x=lab.x(), up="+z")
    check_pose(import_recordings([tmp_path / "run"], settings).dataset, lab, 1e-6)
    fields = "".join(f'{n} = ["/{n}:pose.position.x", "/{n}:pose.position.y", "/{n}:pose.position.z"]\n' for n in lab.names)
    turned = ", ".join(f'"/tip:pose.orientation.{part}"' for part in "wxyz")
    (tmp_path / "map.toml").write_text(f"[points]\n{fields}[poses]\ntip = [{turned}]\n", encoding="utf-8")
    mapped = read_capture(tmp_path / "run", None, read_mapping(tmp_path / "map.toml"))
    plain = read_capture(tmp_path / "run")
    np.testing.assert_array_equal(mapped.orientations["tip"], plain.orientations["/tip"])
    agreement = np.einsum("tc,tc->t", plain.orientations["/late"][1:-1], lab.turns[1:-1, 2])
    assert np.abs(agreement).min() > 1 - 1e-4  # between two samples of the tip that have opposite signs


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"x": "+z"}, "x: expected a direction perpendicular to the arm, got +z"),
        ({"x": "north"}, "x: expected an axis of the laboratory"),
        ({"x": "1,2"}, "x: expected three numbers"),
        ({"x": "input"}, "x: expected an input that determines x"),
        ({"bending": "plane"}, "marker beside the backbone: expected --bending space together with this option, got plane"),
        ({"bending": "+x", "markers": BODIES}, "use --x for the direction of positive bending"),
        ({"own_plane": True}, "own_plane: expected an arm that bends in a plane, got an arm in space"),
        ({"gain": 0.3}, "gain: expected an input to which the gain applies"),
        ({"markers": posed()}, "pose of 'tip': expected a file with orientations, got tip"),
        ({"inputs": ["P"]}, "expected t,tau_x,tau_y, got t,P1,P2,P3; declare the torque of each column with --gain or with"),
        ({"inputs": ["P"], "bending": "plane", "markers": BODIES}, "for an arm in space give --bending space"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(changes, said, take, tmp_path):
    lab = SpaceLaboratory()
    commands = table(tmp_path / "p.csv", ["t", "P1", "P2", "P3"], [lab.time[:, None], lab.pressures[:, :3]])
    changes = changes | ({"inputs": [commands]} if "inputs" in changes else {})
    with pytest.raises((InputError, RecordingError)) as caught:
        import_recordings(*of(lab, take, up="+z", **changes))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('bending = "space"', 'bending = "plane"', 'section: expected bending = "space" under [robot]'),
        ("section = 2", "section = 3", "section: expected the section that the columns bend, 1 to 2, or torque, got 3"),
        ("length = 0.10", "lenght = 0.10", "did you mean 'length'"),
        ("mass = 0.15", "mass = -1", "mass: expected a number, more than zero [kg], got -1"),
        ("mass = 0.15", "mas = 1", "did you mean 'mass'"),
        ('columns = ["P1 seen"]', 'columns = ["P1"]', "column 'P1' is declared twice"),
        ('columns = ["P1 seen"]', 'columns = "P1"', "columns: expected column names"),
        ("gain = 0.25", 'gain = 0.25\nfrom = ["a"]', "from: expected 3 columns of the file, each by its name"),
        ("gain = 0.25", 'gain = 0.25\ntime = "a"\n[[input]]\ncolumns = ["T"]\ntime = "b"', "time: expected the clock"),
        ("gain = 0.3", "gian = 0.3", "did you mean 'gain'"),
        ("diameter = 0.04", 'diameter = 0.04\ninput = "drawn"', "input: expected held or interpolated"),
        ("diameter = 0.04", "", "diameter: expected --diameter, or diameter under [robot] in --map, got none"),
        ("[[measured]]", '[[marker]]\nname = "tip"\norientation = 3\n[[measured]]', "orientation: expected true, false"),
        ("[[measured]]", '[[marker]]\nname = "tip"\npoints = []\n[[measured]]', "points: expected point names"),
        ("[robot]", "[poses]\nbase = [1, 2, 3]\n[robot]", "pose 'base': expected four columns of a quaternion"),
        ("[robot]", "[poses]\nbas = [1, 2, 3, 4]\n[robot]", "did you mean 'base'"),
        ("[robot]", "[space]\norigin = [1, 2]\n[robot]", "origin: expected three numbers [m]"),
        ("[robot]", "[space]\norigin = [0, 0, 1e300]\n[robot]", "origin: expected three numbers [m], up to 1e+06"),
        ("[robot]", "[space]\nunit = 1e300\n[robot]", "unit: expected at most 1e+06 m, got 1e+300"),
    ],
)  # fmt: skip
def test_a_mapping_that_is_wrong_says_where(old, new, said, take):
    assert TWO.count(old) == 1
    lab = SpaceLaboratory(seconds=1)
    with pytest.raises((InputError, RecordingError)) as caught:
        declared_settings(take(lab.names, lab.time, lab.positions, TWO.replace(old, new))[1])
    assert said in str(caught.value)


def test_an_input_that_a_mapping_tells_of_must_be_given_or_said_to_be_none(tmp_path):
    lab = SpaceLaboratory(up="+y")
    path = motive_bodies(tmp_path / "take.csv", lab)
    (tmp_path / "map.toml").write_text(TWO, encoding="utf-8")
    given = {"markers": BODIES, "origin": lab.place}
    settings = declared_settings(read_mapping(tmp_path / "map.toml"), **given)
    with pytest.raises(
        RecordingError, match=r"no commands: expected --input FILE with P1, P2, .*give --input - if there was none"
    ):
        import_recordings([path], settings)
    settings = declared_settings(read_mapping(tmp_path / "map.toml"), **given, inputs=["-"])
    assert not import_recordings([path], settings).dataset.trials[0].trajectory.has_input


@pytest.mark.parametrize(
    ("text", "body"),
    [
        ("side@0.24,0.03,0.7=Arm:s", Body("side", ("Arm:s",), 0.24, 0.03, 0.7)),
        ("side@0.24,0.03=a+b", Body("side", ("a", "b"), 0.24, 0.03)),
    ],
)
def test_a_marker_beside_the_backbone_is_written_in_one_word(text, body):
    assert Body.parse(text) == body
    for wrong in ("@0.24,-0.03=a", "side@0.24,0.03,0.7,1=a", "side@,0.03=a", "side@0.24,x=a", "side@0.24,0.03,nan=a"):
        with pytest.raises(InputError, match="NAME"):
            Body.parse(wrong)


GUIDE = (HERE.parents[2] / "docs" / "importing.md").read_text(encoding="utf-8").split("## An arm in space")[1]
COMMANDS = [shlex.split(block.replace("\\\n", "")) for block in re.findall(r"```bash\n(.*?)```", GUIDE, re.DOTALL)[:2]]


def test_the_short_example_of_the_guide_runs(tmp_path, monkeypatch, capsys, writers):
    markers = (("base", 0.0, 0.0, 0.0), ("mid", 0.12, 0.0, 0.0), ("tip", 0.24, 0.0, 0.0), ("side", 0.24, 0.02, 0.7))
    lab = SpaceLaboratory(yaw=0.8, gains=(0.3 * 14 / 24, 0.3 * 10 / 24), one=True, markers=markers)
    monkeypatch.chdir(tmp_path)
    writers["nexus"](Path("take.csv"), lab.names, lab.positions, rate=100.0)
    table(Path("pressures.csv"), ["t", "P1", "P2", "P3"], [lab.time[:, None], lab.pressures[:, :3]])
    assert run(command, COMMANDS[0][1:]) == 0, capsys.readouterr().err
    assert capsys.readouterr().err == ""
    dataset = read_dataset("my-arm")
    motion = dataset.trials[0].trajectory
    assert np.abs(motion.positions - lab.world).max() < 2e-3  # the input tells x to half a degree
    np.testing.assert_allclose(motion.torque, lab.torque[:, :2] * 24 / 14, atol=1e-9)
    assert dataset.markers[-1].offset == pytest.approx(cmath.rect(0.02, 0.7), abs=2e-4)


def test_the_whole_example_of_the_guide_runs(tmp_path, monkeypatch, capsys):
    markers = (("Base", 0.0, 0.0, 0.0), ("Middle", 0.14, 0.0, 0.0), ("Tip", 0.24, 0.0, 0.0))
    monkeypatch.chdir(tmp_path)
    block = re.findall(r"```toml\n(.*?)```", GUIDE, re.DOTALL)[0]
    Path("two-sections.toml").write_text(block, encoding="utf-8")
    labs = [SpaceLaboratory(up="+y", yaw=np.pi, seconds=s, second=np.pi / 3, markers=markers) for s in (3.0, 2.0)]
    for number, lab in enumerate(labs, 1):
        motive_bodies(Path(f"take{number}.csv"), lab)
        columns = [lab.time[:, None], lab.pressures, lab.pressures[:, [0, 3]] - 0.05]
        table(Path(f"pressures{number}.csv"), ["t", *(f"P{k}" for k in range(1, 7)), "ai0", "ai3"], columns)
    assert run(command, COMMANDS[1][1:]) == 0, capsys.readouterr().err
    assert capsys.readouterr().err == ""
    dataset = read_dataset("two-sections")
    assert [section.keq for section in dataset.sections] == [1.6, 1.4]
    assert [channel.name for channel in dataset.channels if not channel.torque] == ["P1 seen", "P4 seen"]
    for trial, lab in zip(dataset.trials, labs, strict=True):
        motion = trial.trajectory
        assert np.abs(motion.positions[:, :3] - lab.world).max() < 1e-8
        np.testing.assert_allclose(motion.torque, lab.torque, atol=2e-5)  # the angle in the guide has four digits
        np.testing.assert_allclose(motion.marker("tip:x"), lab.beside("Tip", 0.02)[:, 0], atol=1e-8)


def test_a_refused_import_is_one_line_and_writes_nothing(tmp_path, monkeypatch, capsys, writers):
    lab = SpaceLaboratory()
    monkeypatch.chdir(tmp_path)
    writers["nexus"](Path("take.csv"), lab.names, lab.positions, rate=100.0)
    given = ["take.csv", "-o", "arm", "--bending", "space", "--mass", "0.1", "--diameter", "0.04", "--keq", "1", "-m", "base@0"]
    for more, said in (
        (["-m", "tip@0.24", "--pose", "tip"], "pose of 'tip': expected a file with orientations, got tip"),
        (["-m", "tip@0.24", "--pose", "top"], "pose: expected base or tip, got 'top'"),
        (["-m", "tip@0.24", "--x", "up"], "x: expected an axis of the laboratory (+x, -y, ...)"),
        (
            ["-m", "tip@0.24", "--gain", "0.3"],
            "gain: expected an input to which the gain applies, got none; give it with --input",
        ),
    ):
        assert run(command, [*given, *more]) == 2
        err = capsys.readouterr().err
        assert err.startswith("hsr-import: error: ") and err.count("\n") == 1 and said in err
        assert [path.name for path in tmp_path.iterdir()] == ["take.csv"]


def test_the_list_tells_which_points_have_a_pose(tmp_path, capsys):
    lab = SpaceLaboratory(up="+y")
    assert run(command, [str(motive_bodies(tmp_path / "take.csv", lab)), "--list"]) == 0
    assert capsys.readouterr().out.count("yes") == len(lab.names)


def test_commands_of_measured_chambers_come_in_beside_them(tmp_path):
    lab = SpaceLaboratory(gains=(0.3 * 14 / 24, 0.3 * 10 / 24), one=True)
    asked = np.round(lab.pressures[:, :3], 1)
    columns = [lab.time[:, None], lab.positions.reshape(len(lab.time), -1), lab.pressures[:, :3], asked]
    places = [f"{name}.{axis}" for name in lab.names for axis in "XYZ"]
    table(tmp_path / "take.csv", ["t", *places, "m1", "m2", "m3", "c1", "c2", "c3"], columns)
    points = "".join(f'"{name}" = ["{name}.X", "{name}.Y", "{name}.Z"]\n' for name in lab.names)
    inputs = '[[input]]\ncolumns = ["A", "B", "C"]\nfrom = ["m1", "m2", "m3"]\ncommand = ["c1", "c2", "c3"]\ngain = 0.3\n'
    robot = '[robot]\nmass = 0.15\ndiameter = 0.04\nkeq = 1.11\nmount = "hanging"\nbending = "space"\n'
    path = tmp_path / "map.toml"
    path.write_text(f'{robot}[time]\ncolumn = "t"\n[space]\nup = "+z"\n[points]\n{points}{inputs}', encoding="utf-8")
    settings = declared_settings(read_mapping(path), origin=lab.place)
    write_dataset(import_recordings([tmp_path / "take.csv"], settings).dataset, tmp_path / "arm")
    dataset = read_dataset(tmp_path / "arm")
    assert [channel.name for channel in dataset.channels] == ["A", "B", "C"]
    np.testing.assert_allclose(dataset.trials[0].trajectory.channels, lab.pressures[:, :3], atol=1e-12)
    np.testing.assert_allclose(dataset.trials[0].trajectory.commanded, asked, atol=1e-12)
    path.write_text(path.read_text(encoding="utf-8").replace(', "c3"', ""), encoding="utf-8")
    with pytest.raises(RecordingError, match="command: expected the columns of 3 commands"):
        read_mapping(path)


def test_an_arm_in_space_that_stays_in_one_plane_is_doubted_unless_it_has_sections():
    """Sections are declared in space only, so that an arm of sections in a plane is one in space."""
    time = np.arange(50) / 50
    positions = np.stack([0.05 * np.sin(9 * time), 0 * time, -0.24 + 0 * time], axis=1)[:, None]
    trial = Trial("one", Trajectory(time, (Marker("tip", 0.24),), positions), 1.11)
    even = Dataset("arm", 0.24, 0.15, 0.04, "hanging", (trial,), bending="space")
    halves = replace(even, sections=(Section(0.12, 0.075, 2.22, 0.1),) * 2)
    (warning,) = warnings(even, [(0.03, 0.0)], True)
    assert "stays in one plane" in warning
    assert warnings(halves, [(0.03, 0.0)], True) == ()
