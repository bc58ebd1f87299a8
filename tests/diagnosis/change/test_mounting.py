"""Changes of the mounting: a rotated camera frame, and a rotated base."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hsr_pin.diagnosis.change.diagnose import _may_change
from hsr_pin.diagnosis.change.mounting import MOUNTING, turns_cameras
from hsr_pin.effects import EFFECTS, effect_named
from hsr_pin.effects.effect import View, neutral
from hsr_pin.identification.part import part_variants
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker

REACH = np.array([0.1, 0.2])
POINTS = np.random.default_rng(0).uniform(-0.2, 0.2, (3, 1, 2, 3))
PLANE = View(POINTS, REACH, marker_map(ArmSpecification(mount="upright"), REACH), np.zeros((3, 1, 4)))


def in_space(mount="upright"):
    arm = ArmSpecification(mount=mount, bending="space")
    return View(POINTS, REACH, space_marker_map(arm, REACH), np.zeros((3, 1, 12)))


@pytest.mark.parametrize("kind", MOUNTING.values(), ids=MOUNTING)
def test_neutral_is_as_it_was(kind):
    law = neutral(kind)
    assert law.in_plane or law.in_space
    for view in [PLANE] * law.in_plane + [in_space()] * law.in_space:
        assert law.observe(view) == pytest.approx(POINTS)


def test_a_turned_frame_keeps_distances_and_turns_up_to_the_side_of_positive_bending():
    seen = MOUNTING["frame_turn"](angle=0.3).observe(PLANE)
    assert np.linalg.norm(seen, axis=-1) == pytest.approx(np.linalg.norm(POINTS, axis=-1))
    up = replace(PLANE, positions=np.array([[[[0.0, 0.0, 1.0]]]]))
    assert MOUNTING["frame_turn"](angle=0.3).observe(up)[0, 0, 0] == pytest.approx([np.sin(0.3), 0.0, np.cos(0.3)])


def test_in_space_a_frame_turned_towards_x_is_that_of_the_plane_and_is_turned_about_any_axis():
    turned = MOUNTING["frame_rotation"](towards_x=0.3)
    assert turned.observe(in_space()) == pytest.approx(MOUNTING["frame_turn"](angle=0.3).observe(PLANE))
    both = MOUNTING["frame_rotation"](towards_x=0.3, towards_y=-0.2, twist=0.4)
    rotation = Rotation.from_rotvec([0.2, 0.3, 0.4])  # about (-y, x, twist)
    assert both.observe(in_space()) == pytest.approx(np.apply_along_axis(rotation.apply, -1, POINTS))


@pytest.mark.parametrize("tilt, readings", [("gravity_tilt", "angle"), ("base_tilt", "towards_x")])
def test_only_the_reading_of_a_tilt_in_which_cameras_alone_are_turned_is_a_turned_frame(tilt, readings):
    kind, view = effect_named(tilt), PLANE if tilt == "gravity_tilt" else in_space()
    every = [neutral(kind, **options) for options in kind.variants()]
    turning = [replace(each, **{readings: 0.3}).observe(view) for each in every if turns_cameras(each)]
    assert len(turning) == 1
    assert turning[0] == pytest.approx(MOUNTING["frame_turn"](angle=0.3).observe(PLANE))
    assert not turns_cameras(neutral(effect_named("tip_mass")))
    assert not turns_cameras(None)


@pytest.mark.parametrize("mount", ["hanging", "upright"])
def test_a_base_turned_about_its_line_takes_gravity_and_the_torques_with_it(mount):
    turn, tilt, torque, side = 0.5, 0.2 * np.exp(0.4j), 0.6 * np.exp(1.1j), 0.02j
    arm = ArmSpecification(links=6, mount=mount, bending="space", placement="mid")

    def seen(effect, torque, side):
        time = np.arange(31) * 0.01
        command = np.tile([torque.real, torque.imag], (len(time), 1))
        marker = Marker("tip", arm.length, abs(side), float(np.angle(side)))
        scenario = Scenario(arm, time, command, Settled(0.0), (effect,), (marker,))
        return simulate(scenario, dynamics="compiled").trajectory.positions

    law = MOUNTING["base_rotation"](towards_x=tilt.real, towards_y=tilt.imag, twist=turn)
    way = tilt * np.exp(1j * turn)  # the same arm, told in axes that were not turned with it
    plain = effect_named("base_tilt")(towards_x=way.real, towards_y=way.imag)
    whole = seen(plain, torque * np.exp(1j * turn), side * np.exp(1j * turn))
    assert seen(law, torque, side) == pytest.approx(whole, abs=2e-5)
    assert np.abs(seen(plain, torque, side) - whole).max() > 0.01


def test_a_tilt_that_only_the_cameras_see_is_asked_for_where_the_first_recording_is_described_by_it_and_else_not():
    tilts = part_variants(EFFECTS["gravity_tilt"])
    seen = [part for part in tilts if turns_cameras(part.effect)]
    assert seen and [part for part in tilts if _may_change(part, ())] == [part for part in tilts if part not in seen]
    assert all(_may_change(part, {part.variant}) for part in tilts)
