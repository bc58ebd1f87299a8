"""How an arm is seen may be another: a frame that is turned."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.change.cameras import CAMERAS, turns_cameras
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import View, neutral
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.specification import ArmSpecification

POINTS = np.random.default_rng(0).uniform(-0.2, 0.2, (3, 1, 2, 3))
VIEW = View(POINTS, np.array([0.1, 0.2]), marker_map(ArmSpecification(mount="upright"), [0.1, 0.2]), np.zeros((3, 1, 4)))


@pytest.mark.parametrize("kind", CAMERAS.values(), ids=CAMERAS)
def test_neutral_is_as_it_was(kind):
    assert neutral(kind).observe(VIEW) == pytest.approx(POINTS)


def test_a_turned_frame_keeps_distances_and_turns_up_to_the_side_of_positive_bending():
    seen = CAMERAS["frame_turn"](angle=0.3).observe(VIEW)
    assert np.linalg.norm(seen, axis=-1) == pytest.approx(np.linalg.norm(POINTS, axis=-1))
    up = replace(VIEW, positions=np.array([[[[0.0, 0.0, 1.0]]]]))
    assert CAMERAS["frame_turn"](angle=0.3).observe(up)[0, 0, 0] == pytest.approx([np.sin(0.3), 0.0, np.cos(0.3)])


def test_only_the_reading_of_a_tilt_in_which_cameras_alone_are_turned_is_a_turned_frame():
    readings = [neutral(EFFECTS["gravity_tilt"], **options) for options in EFFECTS["gravity_tilt"].variants()]
    turning = [replace(each, angle=0.3).observe(VIEW) for each in readings if turns_cameras(each)]
    assert len(turning) == 1
    assert turning[0] == pytest.approx(CAMERAS["frame_turn"](angle=0.3).observe(VIEW))
    assert not turns_cameras(neutral(EFFECTS["tip_mass"]))
    assert not turns_cameras(None)
