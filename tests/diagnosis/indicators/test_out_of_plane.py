"""Motion out of the plane is measured, and a rotated plane is detected."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.out_of_plane import out_of_plane

from .recorded import LENGTH, arcs, swing

SWINGS = [swing(angle, 2.0, 0.05) for angle in (0.4, 0.6, 0.8)]


def test_noise_alone_is_next_to_nothing():
    found = out_of_plane(arcs(*SWINGS, noise=3e-4))
    assert found.kinds == () and "negligible" in found.sentence


def test_a_turned_plane_is_turned_back():
    across = [LENGTH * np.sinc(angle / 2 / np.pi) * np.sin(angle / 2) for angle in SWINGS]
    found = out_of_plane(arcs(*SWINGS, sideways=[0.1 * each for each in across], noise=5e-5))
    assert found.plane.turn.value == pytest.approx(np.arctan(0.1), rel=0.02)
    assert found.kinds == ("measurement",)


def test_a_motion_of_its_own_is_set_apart():
    sideways = [0.004 * np.sin(0.09 * np.arange(400) + phase) for phase in (0.0, 1.0, 2.0)]
    found = out_of_plane(arcs(*SWINGS, sideways=sideways, noise=5e-5))
    assert found.plane.sideways == pytest.approx(0.004 / np.sqrt(2), rel=0.1)
    assert found.plane.leaves and not found.plane.turned and found.kinds == ()
