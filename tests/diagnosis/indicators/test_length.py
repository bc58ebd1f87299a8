"""The backbone length of an arc is constant, and a stretch is measured with its true size."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.length import length

from .recorded import STEP, arcs

TIME = STEP * np.arange(600)
TORQUE = np.array([0.0, 0.5, 1.0, 0.0, -0.5, -1.0])[np.minimum((TIME + 1e-9).astype(int), 5)]


@pytest.mark.parametrize("markers", [(1.0,), (0.5, 1.0), (0.3, 0.6, 1.0)])
def test_an_arc_keeps_its_length(markers):
    found = length(arcs(*[1.2 * TORQUE] * 3, torques=[TORQUE] * 3, markers=markers, noise=1e-4))
    assert abs(found.bent.value) < 2e-3 and found.kinds == ()


def test_a_stretch_is_found():
    found = length(arcs(*[TORQUE] * 3, torques=[TORQUE] * 3, markers=(1.0,), stretch=0.04, noise=1e-4))
    assert found.bent.value == pytest.approx(0.04, rel=0.05)
    assert found.kinds == ("actuation_map", "measurement")


def test_an_arm_that_hardly_bends_cannot_tell():
    assert length(arcs(0.1 * TORQUE, torques=[TORQUE])) is None
