"""Indicators of an arm in space use motions on a line, in any direction, and no motions off a line."""

import json

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.decay import decay
from hsr_pin.diagnosis.indicators.indicators import indicators
from hsr_pin.diagnosis.indicators.lines import lines
from hsr_pin.effects import parse_effect
from hsr_pin.identification.experiment import prepare
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

from .recorded import LENGTH, STEP, commanded, commands, released

MARKERS = (Marker("mid", LENGTH / 2), Marker("beside", 0.2, 0.03, 1.0), Marker("tip", LENGTH))
SIDES = np.exp(1j * np.array([0.3, 0.9, 1.5, 2.1, 2.7, -0.2]))


def recorded(scenarios, *, has_input, noise=1e-4, markers=MARKERS):
    """Return an experiment of simulated arms in space."""
    generator, trials = np.random.default_rng(1), []
    for number, result in enumerate(simulate_batch(scenarios), 1):
        motion, arm = result.trajectory, result.scenario.arm
        seen = motion.positions + noise * generator.standard_normal(motion.positions.shape)
        recording = Trajectory(motion.time, markers, seen, torque=motion.torque if has_input else None)
        trials.append(Trial(f"trial_{number}", recording, arm.keq, arm.damping, t_start=None if has_input else 0.0))
    return prepare(Dataset("recorded", LENGTH, 0.15, 0.04, arm.mount, tuple(trials), bending="space"))


def to_sides(*effects, noise=3e-4, mount="hanging"):
    """Return the commands of a planar arm, each in another direction."""
    arm = ArmSpecification(links=8, placement="mid", bending="space", mount=mount)
    laws, made = tuple(map(parse_effect, effects)), []
    for side, (time, torque) in zip(SIDES, commands(), strict=False):
        made.append(Scenario(arm, time, np.stack([side.real * torque, side.imag * torque], axis=1), Settled(), laws, MARKERS))
    return recorded(made, has_input=True, noise=noise)


def let_go(*effects, rates=0.0, sides=SIDES):
    """Return releases from equilibria under torques in some directions; with rates, the arm has a transverse initial velocity."""
    arm = ArmSpecification(links=8, placement="mid", bending="space", damping=0.003)
    laws, time = tuple(map(parse_effect, effects)), np.arange(0, 3, STEP)
    made = [Scenario(arm, time, np.zeros((len(time), 2)), Settled(0.8 * side), laws, MARKERS) for side in sides]
    if rates:
        from hsr_pin.simulation.scenario import Pose
        from hsr_pin.simulation.simulate import simulate

        for k, (side, scenario) in enumerate(zip(sides, made, strict=True)):
            angles = simulate(scenario).trajectory.joint_angles[0]
            across = rates * 1j * side / 8
            pushed = Pose(angles, np.tile([across.real, across.imag, 0.0], (8, 1)))
            made[k] = Scenario(arm, time, np.zeros((len(time), 2)), pushed, laws, MARKERS)
    return recorded(made, has_input=False)


@pytest.mark.parametrize("mount", ["hanging", "horizontal"])
def test_a_lag_is_told_as_in_a_plane_to_whatever_side(mount):
    found = indicators(to_sides("actuator_lag:time_constant=0.1", mount=mount))
    assert "actuation_time" in found.kinds
    assert indicators(to_sides(mount=mount)).kinds == ()
    assert (
        found.notes == ("the model-free indicators use trials that stay on one line: 5 commands and 5 motions of 5 trials",)
        or mount == "horizontal"
    )


def test_friction_leaves_the_loop_that_it_leaves_in_a_plane():
    effect = "dry_friction:level=0.1"
    space, plane = indicators(to_sides(effect)).named("loops"), indicators(commanded(effect)).named("loops")
    assert space.kinds == plane.kinds == ("friction",)
    assert space.standing.value == pytest.approx(plane.standing.value, rel=0.1)
    assert space.returned.value == pytest.approx(plane.returned.value, rel=0.1)
    for (_, ours), (_, theirs) in zip(space.curves, plane.curves, strict=True):
        assert np.ptp(ours) == pytest.approx(np.ptp(theirs), rel=0.05)


def test_a_decay_is_that_of_the_plane():
    space, plane = decay(lines(let_go()).swinging), decay(released())
    for name in ("frequency", "damping"):
        told = (np.median([getattr(swing, name) for swing in each.swings if swing.amplitude > 0.1]) for each in (space, plane))
        assert next(told) == pytest.approx(next(told), rel=0.03)


def test_an_arm_that_is_stiffer_to_a_side_is_told_with_the_side():
    """The releases are along and across the stiffest direction, so that the arm oscillates on lines."""
    stiffest = 0.5
    told = f"unequal_stiffness:along_x={0.2 * np.cos(2 * stiffest)},diagonal={0.2 * np.sin(2 * stiffest)}"
    ways = stiffest + np.array([0.0, np.pi / 2, np.pi, -np.pi / 2, 0.0, np.pi / 2])
    found = indicators(let_go(told, sides=np.array([1.0, 1.0, 0.8, 0.8, 0.6, 0.6]) * np.exp(1j * ways))).named("sides")
    assert found.unequal and found.kinds == ("elastic",)
    assert found.stiffest == pytest.approx(np.degrees(stiffest), abs=3)
    assert 0.1 < found.share < 0.25  # gravity is the same to all sides
    assert f"towards {found.stiffest:.0f} degrees" in found.sentence


def test_a_round_arm_swings_alike_to_every_side():
    found = indicators(let_go()).named("sides")
    assert len(found.angles) == 6 and found.kinds == ()
    assert "no dependence on the direction" in found.sentence


def test_of_swings_that_go_round_nothing_is_said():
    found = indicators(let_go(rates=8.0))
    assert found.named("decay") is None and found.named("sides") is None
    assert found.notes[0].endswith("0 commands and 0 motions of 6 trials")


def test_of_commands_that_turn_nothing_is_said_though_friction_is_there():
    time = np.arange(0, 6, STEP)
    corners = 0.8 * np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0], [0, 0]])
    torque = corners[np.minimum((time + 1e-9).astype(int), 5)]
    arm = ArmSpecification(links=8, placement="mid", bending="space")
    laws = (parse_effect("dry_friction:level=0.1"),)
    found = indicators(recorded([Scenario(arm, time, torque, Settled(), laws, MARKERS)] * 2, has_input=True))
    assert found.items == ()


def test_markers_beside_the_backbone_alone_show_nothing():
    beside = (Marker("beside", 0.2, 0.03, 1.0),)
    time = np.arange(0, 2, STEP)
    arm = ArmSpecification(links=8, placement="mid", bending="space")
    runs = [Scenario(arm, time, np.full((len(time), 2), 0.4), Settled(), (), beside)] * 2
    found = indicators(recorded(runs, has_input=True, markers=beside))
    assert found.items == () and found.notes


def test_the_document_holds_plain_numbers():
    json.dumps(indicators(let_go()).to_json(), allow_nan=False)
