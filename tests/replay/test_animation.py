"""What is sent to the viewer puts every body and marker where the simulation has it."""

import numpy as np
import pinocchio as pin
import pytest
import umsgpack

from hsr_pin.replay.animation import RATE, draw
from hsr_pin.replay.bodies import bodies, poses
from hsr_pin.replay.viewer import Visualizer
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf


class Recorder:
    def __init__(self):
        self.commands = []

    def send(self, command):
        self.commands.append(umsgpack.unpackb(umsgpack.packb(command.lower())))


@pytest.fixture
def drawn():
    """``drawn(runs)``: the commands by path, and the tracks of the animation by path and property."""

    def call(runs):
        recorder = Recorder()
        draw(Visualizer(window=recorder), runs)
        objects, tracks = {}, {}
        for command in recorder.commands:
            if command["type"] == "set_object":
                objects[command["path"]] = command["object"]
            if command["type"] == "set_animation":
                for part in command["animations"]:
                    for track in part["clip"]["tracks"]:
                        keys = track["keys"]
                        times = np.array([key["time"] for key in keys]) / part["clip"]["fps"]
                        tracks[part["path"], track["name"][1:]] = times, np.array([key["value"] for key in keys])
        return objects, tracks

    return call


def at(track, time):
    times, values = track
    return np.array([np.interp(time, times, column) for column in values.T])


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
@pytest.mark.parametrize("placement", ["base", "mid"])
def test_the_last_link_ends_where_the_tip_is(run_of, mount, placement):
    run = run_of(ArmSpecification(links=5, mount=mount, placement=placement))
    translations, quaternions = poses(run.arm, run.angles)
    (tip,) = [body for body in bodies(run.arm) if body.name.startswith("tip")]
    x, y, z, w = quaternions[:, tip.joint].T
    along = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    ends = translations[:, tip.joint] + tip.placement[2, 3] * along
    assert ends == pytest.approx(run.simulated.marker("tip"), abs=1e-12)


def test_bodies_are_those_of_the_urdf_in_its_colours():
    arm = ArmSpecification(links=3)
    found = bodies(arm)
    assert len(found) == arm_to_urdf(arm).count("<visual>")
    assert max(body.radius for body in found) == pytest.approx(0.02)
    discs = [body.colour for body in found if body.radius == pytest.approx(0.02)]
    assert len(set(discs)) == 3


def test_every_joint_moves_as_it_was_simulated(run_of, drawn):
    run = run_of()
    _, tracks = drawn([run])
    translations, _ = poses(run.arm, run.angles)
    for joint in range(1, 5):
        track = tracks[f"/meshcat/arms/arm_1/joint_{joint}", "position"]
        for time in (0.0, 0.16, 0.5, 1.0):
            assert at(track, time) == pytest.approx(translations[round(100 * time), joint], abs=2e-6)


def test_an_arm_at_rest_needs_no_frames_between_the_ends(run_of, drawn):
    _, tracks = drawn([run_of(torque=0.0)])
    assert {len(times) for times, _ in tracks.values()} == {2}


def test_gaps_reach_from_simulated_to_measured(run_of, drawn):
    run = run_of(measured=(0.03, 0.01, -0.04))
    _, tracks = drawn([run])
    path = "/meshcat/arms/arm_1/{}/tip"
    times, position = tracks[path.format("gaps"), "position"]
    length = at(tracks[path.format("gaps"), "scale"], times[0])[1]
    x, y, z, w = at(tracks[path.format("gaps"), "quaternion"], times[0])
    along = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    start, end = (at(tracks[path.format(f"{kind}_markers"), "position"], times[0]) for kind in ("simulated", "measured"))
    assert length == pytest.approx(np.linalg.norm([0.03, 0.01, -0.04]), abs=1e-9)
    assert position[0] - length / 2 * along == pytest.approx(start, abs=1e-9)
    assert position[0] + length / 2 * along == pytest.approx(end, abs=1e-9)


def test_a_marker_out_of_sight_and_its_gap_are_hidden(run_of, drawn):
    _, tracks = drawn([run_of(measured=(0.03, 0.0, 0.0))])
    for kind in ("measured_markers", "gaps"):
        times, shown = tracks[f"/meshcat/arms/arm_1/{kind}/tip", "visible"]
        after = shown[np.searchsorted(times, [0.49, 0.55, 0.63], side="right") - 1]
        assert after.tolist() == [True, False, True]
        assert set(tracks[f"/meshcat/arms/arm_1/{kind}/mid", "visible"][1].tolist()) == {True}


def test_runs_stand_beside_each_other_and_share_one_clock(run_of, drawn):
    objects, tracks = drawn(
        [run_of(torque=torque, label=str(torque), duration=duration) for torque, duration in ((0.2, 0.5), (0.6, 1.0))]
    )
    assert {path.split("/")[3] for path in objects if "/arm_" in path} == {"arm_1", "arm_2"}
    assert {round(times[-1], 9) for times, _ in tracks.values()} == {1.0}
    assert max(len(times) for times, _ in tracks.values()) <= RATE + 1


def test_a_very_long_run_has_a_bounded_number_of_frames(run_of, drawn):
    _, tracks = drawn([run_of(ArmSpecification(links=1), duration=60.0)])
    assert max(times[-1] for times, _ in tracks.values()) == pytest.approx(60.0, abs=0.05)


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
def test_poses_are_those_of_pinocchio(mount):
    arm = ArmSpecification(links=5, mount=mount, tilt=0.3)
    angles = np.random.default_rng(0).normal(size=(3, 5))
    model = build_model(arm).model
    data, base = model.createData(), model.frames[model.getFrameId("base")].placement
    for q, places, turns in zip(angles, *poses(arm, angles), strict=True):
        pin.forwardKinematics(model, data, q)
        for wanted, place, turn in zip([base, *data.oMi.tolist()[1:]], places, turns, strict=True):
            np.testing.assert_allclose(place, wanted.translation, atol=1e-14)
            np.testing.assert_allclose(pin.Quaternion(turn).matrix(), wanted.rotation, atol=1e-14)
