"""What no arm and no run can have is refused with a documented exception, in one line that says what came."""

import math
import subprocess
import sys

import numpy as np
import pytest

from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects.hysteresis import Hysteresis
from hsr_pin.effects.tip_mass import TipMass
from hsr_pin.errors import LONGEST_QUOTE, EffectError, InputError, PressureError, SimulationFailure, SpecificationError
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import RANGES, ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.simulation.drive import checked_duration, torque_step
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker

#: No float holds it; and one of so many digits that Python does not write it out.
TOO_LARGE, ENDLESS = 10**400, 10**5000
ARM = ArmSpecification()


@pytest.mark.parametrize(
    "value", [1e308, 1e15, TOO_LARGE, ENDLESS, -ENDLESS, np.array([0.24]), 1j], ids=lambda value: type(value).__name__
)
@pytest.mark.parametrize("name", RANGES)
def test_a_quantity_beyond_any_arm_is_refused(name, value):
    with pytest.raises(SpecificationError, match=rf"^{name}: expected a number") as caught:
        ArmSpecification(**{name: value})
    assert len(str(caught.value)) < 2 * LONGEST_QUOTE


@pytest.mark.parametrize("name", [name for name, (_, least, _) in RANGES.items() if least])
def test_a_quantity_below_any_arm_is_refused(name):
    with pytest.raises(SpecificationError, match=rf"^{name}: expected a number from .*, got 5e-324$"):
        ArmSpecification(**{name: 5e-324})


@pytest.mark.parametrize("end", [0, 1])
def test_an_arm_at_either_end_of_all_ranges_is_a_urdf_of_finite_numbers(end):
    values = {name: bounds[end + 1] for name, bounds in RANGES.items()}
    text = arm_to_urdf(ArmSpecification(links=7, **values))
    assert '"inf"' not in text and "nan" not in text


@pytest.mark.parametrize("links", [TOO_LARGE, ENDLESS], ids=["too large", "endless"])
def test_links_past_any_number_are_refused(links):
    with pytest.raises(SpecificationError, match=r"^links: expected a whole number"):
        ArmSpecification(links=links)


@pytest.mark.parametrize("word", [np.array(["base"]), np.array(["base", "mid"]), ["base"], {"base"}])
@pytest.mark.parametrize("name", ["placement", "mount"])
def test_an_array_is_no_word(name, word):
    with pytest.raises(SpecificationError, match=rf"^{name}: expected .* or "):
        ArmSpecification(**{name: word})


@pytest.mark.parametrize(
    "value",
    ["heavy", "0.1", None, True, 1j, object(), TOO_LARGE, ENDLESS, math.nan, [None]],
    ids=lambda value: type(value).__name__,
)
def test_an_effect_is_made_of_numbers(value):
    with pytest.raises(EffectError, match=r"^tip_mass\.mass: expected 0 to 0\.5 \[kg\], got ") as caught:
        TipMass(mass=value)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 2 * LONGEST_QUOTE


def test_an_option_of_an_effect_is_a_word():
    with pytest.raises(EffectError, match=r"^hysteresis\.form: expected dahl or maxwell_slip, got array"):
        Hysteresis(form=np.array(["dahl"]))


@pytest.mark.parametrize("arc_length", [math.nan, math.inf, TOO_LARGE, "0.1", None], ids=lambda value: type(value).__name__)
def test_a_marker_has_a_place(arc_length):
    with pytest.raises(InputError, match=r"^arc length of marker x: expected a finite number"):
        Marker("x", arc_length)


@pytest.mark.parametrize("step", [0, -0.01, math.nan, math.inf, "0.01", TOO_LARGE], ids=lambda value: type(value).__name__)
def test_a_step_is_above_zero(step):
    with pytest.raises(InputError, match=r"^step: expected a number above zero"):
        simulate(step_scenario(ARM, 0.5, duration=0.2), step=step)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Settled(TOO_LARGE),
        lambda: Settled("x"),
        lambda: Settled(0.0, near="x"),
        lambda: Pose("x"),
        lambda: Pose([TOO_LARGE]),
        lambda: Scenario(ARM, "x", [1, 2]),
        lambda: Scenario(ARM, [0, TOO_LARGE], [1, 2]),
        lambda: Scenario(ARM, [0, 1], [TOO_LARGE, 2]),
        lambda: step_scenario(ARM, "x"),
        lambda: step_scenario(ARM, TOO_LARGE),
        lambda: step_scenario(ARM, 1.0, step=0),
        lambda: step_scenario(ARM, 1.0, duration=math.nan),
        lambda: torque_step(ARM, TOO_LARGE),
        lambda: torque_step(ARM, "x"),
        lambda: checked_duration(TOO_LARGE),
        lambda: checked_duration("long"),
        lambda: ArmSimulator(ARM).step(torque=TOO_LARGE),
    ],
)
def test_what_is_no_number_drives_no_arm(make):
    with pytest.raises(InputError) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("pressures", [[TOO_LARGE, 1.0], [ENDLESS, 1.0], "x"], ids=lambda value: type(value).__name__)
def test_pressures_are_numbers(pressures):
    with pytest.raises(PressureError, match=r"^pressures: expected numbers"):
        PAPER.torque(pressures)


def test_a_torque_that_no_arm_bears_is_a_failure_of_the_simulation():
    with pytest.raises(SimulationFailure, match="simulation stopped"):
        simulate(torque_step(ARM, 1e308).scenario(ARM))


HUNDREDS = """
import resource
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))  # Pinocchio's data of so many joints take more
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.export.model import CorrectedModel
from hsr_pin.replay.bodies import poses
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
arm = ArmSpecification(links=450)
motion = simulate(step_scenario(arm, 0.5, duration=0.2)).trajectory
assert poses(arm, motion.joint_angles)[0].shape[1:] == (451, 3)
assert "joint_450" in to_mjcf(CorrectedModel(arm)).text
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are others elsewhere")
def test_hundreds_of_links_are_simulated_drawn_and_handed_on_in_little_memory():
    done = subprocess.run([sys.executable, "-c", HUNDREDS], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
