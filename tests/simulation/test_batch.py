"""Side by side is the same as one by one, and a column that fails fails alone."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from hsr_pin.effects.actuator_lag import ActuatorLag
from hsr_pin.effects.dry_friction import DryFriction
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.gravity_tilt import GravityTilt
from hsr_pin.effects.marker_offset import MarkerOffset
from hsr_pin.effects.soft_spot import SoftSpot
from hsr_pin.effects.stiffening import Stiffening
from hsr_pin.effects.tip_mass import TipMass
from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.errors import SimulationFailure
from hsr_pin.parameters import shape
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.result import Outcome
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker

ARM = ArmSpecification(links=3)
BASE = step_scenario(ARM, 0.6, duration=0.4)


@dataclass(frozen=True)
class Spoilt(Effect):
    """A test's own law: from a bending on, its moment is not a number (size 1) or drives the arm away (size -1e3)."""

    name = "spoilt"
    size: float = shape(0.0, 1.0, "1", lower=-1e9, upper=1.0, description="of the fault")
    start: float = shape(9.0, 1.0, "rad", lower=-1.0, upper=9.0, description="where it begins")

    @staticmethod
    def moment(p, bending):
        fault = np.where(p.size > 0, np.nan, p.size * np.sinh(bending.angle))
        return np.where(bending.angle < p.start, 0.0, fault)


def varied():
    """Scenarios that differ in every way there is."""
    time = np.arange(41) * 0.01
    wave = 0.5 * np.sin(7 * time)
    arms = [
        replace(BASE, arm=replace(ARM, **change))
        for change in (
            {"keq": 2.33, "damping": 0.1},
            {"damping": 0.0},
            {"tip_mass": 0.05},
            {"mass": 0.2},
            {"mount": "horizontal"},
            {"mount": "upright", "tilt": 0.2},
            {"placement": "mid"},
            {"links": 7},
            {"length": 0.3},
        )
    ]
    runs = [
        Scenario(ARM, time, wave),
        Scenario(ARM, time + 5.0, wave, Settled(0.4)),
        Scenario(ARM, time, wave, Pose([0.3, -0.1, 0.2], [1.0, 0.0, -2.0])),
        Scenario(ARM, time[:17], wave[:17]),
        Scenario(ARM, time * 0.4, wave),
        Scenario(ARM, time * 3.0, wave),
        Scenario(ARM, time, wave, markers=(Marker("a", 0.05), Marker("b", 0.21))),
        Scenario(ARM, time * 3.0, wave, interpolated=True),
    ]
    laws = (
        (Stiffening(0.3),),
        (Stiffening(0.5),),
        (Viscoelastic(0.2, 0.3),),
        (DryFriction(0.02), SoftSpot(0.4)),
        (DryFriction(0.03), SoftSpot(0.2, 0.3, 0.2)),
        (ActuatorLag(0.1),),
        (GravityTilt(0.1), TipMass(0.03)),
        (MarkerOffset(0.005),),
        (MarkerOffset(-0.003),),
    )
    return [BASE, *arms, *runs, *(replace(BASE, effects=effects) for effects in laws)]


VARIED = varied()


def same(one, other):
    """Bitwise the same motion and outcome."""
    a, b = one.trajectory, other.trajectory
    return (
        (one.outcome, one.failure_time, one.failure_joint) == (other.outcome, other.failure_time, other.failure_joint)
        and np.array_equal(a.joint_angles, b.joint_angles, equal_nan=True)
        and np.array_equal(a.joint_rates, b.joint_rates, equal_nan=True)
    )


@pytest.fixture(scope="module")
def together():
    return simulate_batch(VARIED)


@pytest.mark.parametrize("index", range(len(VARIED)))
def test_each_column_is_its_single_run(index, together):
    (alone,) = simulate_batch([VARIED[index]])
    assert together[index].scenario is VARIED[index]
    assert same(together[index], alone)
    np.testing.assert_allclose(together[index].trajectory.positions, alone.trajectory.positions, rtol=0, atol=1e-15)


def test_the_varied_runs_are_different_motions(together):
    ends = {tuple(np.round(result.trajectory.positions[-1].ravel(), 7)) for result in together}
    assert len(ends) == len(VARIED)


def test_the_order_of_scenarios_does_not_matter(together):
    backwards = simulate_batch(VARIED[::-1])[::-1]
    assert all(same(a, b) for a, b in zip(together, backwards, strict=True))


def test_threads_do_not_matter():
    short = step_scenario(ARM, 0.6, rest=0.0, duration=0.05)
    many = [replace(short, arm=replace(ARM, keq=1.0 + i / 500)) for i in range(60)]
    assert all(same(a, b) for a, b in zip(simulate_batch(many, threads=2), simulate_batch(many), strict=True))


def test_no_scenarios_give_no_results():
    assert simulate_batch([]) == []


FAULTS = {
    Outcome.BENDING_LIMIT: replace(BASE, torque=np.full(41, 6.0), effects=(Spoilt(),)),
    Outcome.DIVERGED: replace(BASE, effects=(Spoilt(1.0, 0.3),)),
    Outcome.NO_EQUILIBRIUM: replace(BASE, effects=(Spoilt(1.0, -1.0),)),
}
faults = pytest.mark.parametrize("outcome", FAULTS, ids=lambda outcome: outcome.name)


@faults
def test_a_failure_is_named_with_its_time_and_joint(outcome):
    result = simulate(FAULTS[outcome], raise_on_failure=False)
    assert result.outcome is outcome
    assert not result.completed
    assert 0.0 <= result.failure_time < 0.4
    assert result.failure_joint in (1, 2, 3)


@faults
def test_a_failure_raises_by_default_and_carries_the_motion_up_to_it(outcome):
    with pytest.raises(SimulationFailure, match=r"simulation stopped at t = .* s, joint \d: ") as raised:
        simulate(FAULTS[outcome])
    trajectory = raised.value.result.trajectory
    assert len(trajectory.time) == max(1, np.ceil(raised.value.result.failure_time / 0.01 - 1e-9))
    assert np.abs(trajectory.joint_angles.sum(axis=1)).max() <= ARM.bending_limit


@faults
def test_a_failing_column_leaves_the_others_bitwise_as_they_are(outcome):
    good = [replace(BASE, effects=(Spoilt(0.0),)), replace(BASE, torque=0.3 * BASE.torque, effects=(Spoilt(0.0),))]
    alone = simulate_batch(good)
    with_fault = simulate_batch([good[0], FAULTS[outcome], good[1]])
    assert same(with_fault[0], alone[0])
    assert same(with_fault[2], alone[1])
    assert with_fault[1].outcome is outcome


def test_columns_that_fail_one_after_the_other_are_each_named_with_their_own_time():
    torques = (9.0, 0.3, 6.0)
    runs = [step_scenario(ARM, torque, duration=0.4) for torque in torques]
    together, alone = simulate_batch(runs), [result for run in runs for result in simulate_batch([run])]
    assert all(same(a, b) for a, b in zip(together, alone, strict=True))
    assert together[0].failure_time < together[2].failure_time


def test_the_motion_up_to_a_failure_and_its_time_do_not_depend_on_the_steps():
    arm = replace(ARM, damping=2.0)  # so slow that the steps are longer than a sample
    run = step_scenario(arm, 6.0, rest=0.2, duration=4.0)
    (free,), (fine,) = simulate_batch([run]), simulate_batch([run], step=0.002)
    assert free.failure_time == pytest.approx(fine.failure_time, abs=0.002)
    np.testing.assert_allclose(free.trajectory.joint_angles, fine.trajectory.joint_angles, rtol=0, atol=1e-3)


def test_an_arm_driven_away_without_bound_diverges():
    blown_up = replace(BASE, effects=(Spoilt(-1e6, 0.2),))
    assert simulate(blown_up, raise_on_failure=False).outcome is Outcome.DIVERGED


def test_a_settled_start_beyond_the_limit_fails_at_once():
    result = simulate(replace(BASE, start=Settled(6.0)), raise_on_failure=False)
    assert result.outcome is Outcome.BENDING_LIMIT
    assert len(result.trajectory.time) == 1


def test_a_column_that_ended_well_does_not_fail_for_what_the_batch_does_afterwards():
    short = Scenario(ARM, np.arange(41) * 0.01, np.append(np.zeros(40), 9.0))
    long = Scenario(ARM, np.arange(44) * 0.01, np.zeros(44))
    assert simulate_batch([short, long])[0].completed
