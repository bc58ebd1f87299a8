"""Pressures for a torque: on the line of constant stiffness, within range and rate."""

import numpy as np
import pytest

from hsr_pin.control.regulators import Regulators
from hsr_pin.errors import InputError, PressureError
from hsr_pin.robot.combinations import TABLE_II
from hsr_pin.robot.pressure import PAPER

REGULATORS = Regulators(1.11, rate=5.0)


@pytest.mark.parametrize("row", TABLE_II, ids=str)
def test_the_pressures_of_table_ii_come_out(row):
    command = Regulators(row.keq).command(row.tau)
    np.testing.assert_allclose(command.pressures, (row.P1, row.P2), atol=2e-3)
    assert not command.saturated


@pytest.mark.parametrize("torque", [-50.0, -1.0, 0.0, 1.0, 50.0])
def test_any_torque_gives_pressures_in_range_at_the_arms_stiffness(torque):
    command = REGULATORS.command(torque)
    assert np.all((command.pressures >= 0) & (command.pressures <= PAPER.max_pressure))
    assert PAPER.stiffness(command.pressures) == pytest.approx(1.11)
    assert PAPER.torque(command.pressures) == pytest.approx(command.torque)
    assert command.saturated == (abs(torque) > 2)
    assert command.torque == pytest.approx(np.clip(torque, *REGULATORS.torque_range))


def test_the_faster_pressure_changes_at_the_rate_until_the_torque_is_there():
    command, steps = REGULATORS.command(-0.5), []
    while command.saturated or not steps:
        before, command = command, REGULATORS.command(0.7, 0.01, command)
        steps.append(np.abs(command.pressures - before.pressures).max())
        assert PAPER.stiffness(command.pressures) == pytest.approx(1.11)
    assert command.torque == 0.7
    np.testing.assert_allclose(steps[:-1], 0.05, rtol=1e-9)
    assert 0 < steps[-1] <= 0.05 + 1e-12
    assert len(steps) == np.ceil(1.2 / (REGULATORS.torque_rate * 0.01))


def test_bad_requests_are_refused():
    with pytest.raises(InputError, match="finite torque"):
        REGULATORS.command(np.nan)
    with pytest.raises(InputError, match="step above zero"):
        REGULATORS.command(0.1, 0.0)
    with pytest.raises(InputError, match="rate"):
        Regulators(1.11, rate=0.0)
    with pytest.raises(PressureError, match="keq"):
        Regulators(9.0)
