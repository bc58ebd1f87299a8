"""Pressures of chambers and tensions of tendons for the torques of sections."""

import numpy as np
import pytest

from hsr_pin.control.chambers import ChannelRegulators
from hsr_pin.errors import InputError
from hsr_pin.trajectory import Channel

ANGLES = 2 * np.pi / 3 * np.arange(3)
CHAMBERS = tuple(Channel(f"P{k}", "bar", (0.1 * np.cos(a), 0.1 * np.sin(a))) for k, a in enumerate(ANGLES))
TWO = tuple(
    Channel(f"{s}{k}", "bar", (0.0, 0.0) * s + (0.1 * np.cos(a), 0.1 * np.sin(a)) + (0.0, 0.0) * (1 - s))
    for s in range(2)
    for k, a in enumerate(ANGLES)
)


@pytest.mark.parametrize("angle", np.linspace(0, 6, 7))
def test_a_torque_is_made_with_the_least_pressures(angle):
    torque = 0.15 * np.array([np.cos(angle), np.sin(angle)])
    told = ChannelRegulators(CHAMBERS, highest=4.0).command(torque)
    assert not told.saturated
    np.testing.assert_allclose(told.torque, torque, atol=1e-7)
    assert told.values.min() == pytest.approx(0.0, abs=1e-6) and told.values.max() <= 4.0


def test_sections_are_told_apart_and_what_was_measured_drives_nothing():
    torque = [0.1, 0.05, -0.12, 0.02]
    told = ChannelRegulators((*TWO, Channel("seen", "bar")), highest=4.0).command(torque)
    assert told.values.shape == (6,)
    np.testing.assert_allclose(told.torque, torque, atol=1e-7)


def test_out_of_reach_the_nearest_is_given_and_said():
    told = ChannelRegulators(CHAMBERS, highest=2.0).command([5.0, 0.0])
    assert told.saturated
    np.testing.assert_allclose(told.values, [2.0, 0.0, 0.0], atol=1e-6)


def test_no_value_changes_faster_than_its_rate():
    regulators = ChannelRegulators(CHAMBERS, highest=4.0, lowest=0.2, rate=5.0)
    before = regulators.command([0.0, 0.0])
    np.testing.assert_allclose(before.values, 0.2, atol=1e-9)
    told = regulators.command([0.3, 0.0], dt=0.1, before=before)
    assert told.saturated and np.abs(told.values - before.values).max() <= 0.5 + 1e-9
    assert told.values[0] == pytest.approx(0.7)


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="at least one that produces a torque"):
        ChannelRegulators((Channel("seen", "bar"),), highest=1.0)
    with pytest.raises(InputError, match="a lowest value below the highest"):
        ChannelRegulators(CHAMBERS, highest=0.0)
    with pytest.raises(InputError, match="4 finite torques"):
        ChannelRegulators(TWO, highest=1.0).command([0.1, 0.2])
