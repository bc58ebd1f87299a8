"""A drive is what the user commands: rest, then the step, in torques that belong to the pressures."""

import numpy as np
import pytest

from hsr_pin.errors import InputError, PressureError
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.drive import Drive, pressure_step, torque_step
from hsr_pin.simulation.simulate import simulate

ARM = ArmSpecification(keq=1.11)


def test_pressures_rest_on_the_line_of_constant_stiffness_and_step_to_what_was_asked():
    drive = pressure_step(ARM, (0.8127, 2.1477))
    resting = drive.time < 0.1 - 1e-9
    assert resting.sum() == 10
    assert PAPER.stiffness(drive.pressures[0]) == pytest.approx(1.11, abs=1e-9)
    assert np.ptp(drive.pressures[resting], axis=0).max() == 0
    assert (drive.pressures[~resting] == (0.8127, 2.1477)).all()


def test_the_torque_is_that_of_the_pressures_in_every_sample():
    drive = pressure_step(ARM, (0.8127, 2.1477))
    assert drive.torque == pytest.approx(PAPER.torque(drive.pressures, 1.11), abs=1e-12)


def test_the_arm_starts_settled_under_the_first_command():
    drive = Drive(np.linspace(0, 1, 101), np.full(101, 0.4))
    motion = simulate(drive.scenario(ARM)).trajectory.marker("tip")
    assert np.ptp(motion, axis=0).max() < 1e-9
    assert motion[0, 0] > 0.01


def test_pressures_are_noted_in_the_motion_as_far_as_it_goes():
    drive = pressure_step(ARM, (0.8127, 2.1477), duration=0.5)
    motion = simulate(drive.scenario(ARM)).trajectory
    assert (drive.noted_in(motion).pressures == drive.pressures).all()
    assert torque_step(ARM, 0.2, 0.5).noted_in(motion).pressures is None


@pytest.mark.parametrize("torque", [np.nan, np.inf])
def test_a_torque_that_is_no_number_is_refused(torque):
    with pytest.raises(InputError, match="torque: expected a finite number"):
        torque_step(ARM, torque)


@pytest.mark.parametrize("duration", [0.1, -1.0, np.nan, np.inf, 1e9])
def test_a_duration_without_a_step_in_it_or_without_end_is_refused(duration):
    with pytest.raises(InputError, match=r"duration: expected 0\.2 to 3600 s"):
        torque_step(ARM, 0.2, duration)


def test_pressures_out_of_range_are_refused():
    with pytest.raises(PressureError, match="P2: expected a pressure from 0 to 4 bar"):
        pressure_step(ARM, (1.0, 7.0))
