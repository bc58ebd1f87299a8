"""Frames of the base as targets write them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hsr_pin.export.bodies import angles_of

ROUNDED = 3e-17 * np.array([[1, -2, 1], [2, 1, -1], [0, 1, 2]])


@pytest.mark.parametrize("pitch", [-90.0, -89.9999, 20.0, 89.9999, 90.0])
@pytest.mark.parametrize("error", [0.0, 1.0])
def test_roll_pitch_and_yaw_give_the_turn_back_also_where_an_arm_lies(pitch, error):
    """Of a pitch of a quarter turn rounding errors made a roll and a yaw: an exported arm pointed backwards."""
    for roll, yaw in ((0.0, 0.0), (180.0, 0.0), (30.0, -140.0)):
        turn = Rotation.from_euler("xyz", (roll, pitch, yaw), degrees=True).as_matrix() + error * ROUNDED
        back = Rotation.from_euler("xyz", angles_of(turn)).as_matrix()
        np.testing.assert_allclose(back, turn, atol=1e-8)
