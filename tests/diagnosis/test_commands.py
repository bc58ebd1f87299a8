"""Plateaus and steps of a command are found, and brief fluctuations are not."""

import numpy as np
import pytest

from hsr_pin.diagnosis.commands import plateaus, steps

from .indicators.recorded import STEP, arcs


def run(torque):
    torque = np.asarray(torque, dtype=float)
    return arcs(0.5 * torque, torques=[torque]).runs[0]


def test_a_staircase_is_its_stairs():
    found = run(np.repeat([0.0, 0.5, 1.0, 0.5], 100))
    assert [(each.first, each.last, each.torque) for each in plateaus(found)] == [
        (0, 99, 0.0),
        (100, 199, 0.5),
        (200, 299, 1.0),
        (300, 399, 0.5),
    ]
    assert [each.instant for each in steps(found)] == pytest.approx([1.0, 2.0, 3.0])
    assert [each.size for each in steps(found)] == pytest.approx([0.5, 0.5, -0.5])


def test_a_flicker_between_plateaus_moves_the_instant_by_what_it_gives():
    torque = np.repeat([0.0, 1.0], 100)
    torque[100:104] = [1.0, 0.0, 0.0, 1.0]  # half of the command, for four samples
    (found,) = steps(run(torque))
    assert found.instant == pytest.approx(1.0 + 2 * STEP)


def test_a_flicker_inside_a_plateau_leaves_it_one():
    torque = np.ones(200)
    torque[100] = 0.0
    assert len(plateaus(run(torque))) == 1


def test_a_chirp_has_no_plateaus():
    time = STEP * np.arange(500)
    assert len(plateaus(run(np.sin(2 * np.pi * time) + 2))) <= 1 and steps(run(np.sin(2 * np.pi * time) + 2)) == ()
