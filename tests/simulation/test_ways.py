"""The compiled loops are those over Pinocchio: the same motions to 1e-10 for every effect and any arm."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_batch, simulate_together
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.simulation.motion import Engine
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.sensitivity import sensitivities

#: Every effect in every reading.
READINGS = [(kind, variant) for kind in (EFFECTS | FLEXIBLE).values() for variant in kind.variants()]
every_reading = pytest.mark.parametrize("reading", READINGS, ids=lambda r: "-".join([r[0].name, *r[1].values()]))
LINKS = st.integers(1, 12) | st.sampled_from([16, 32, 64])


def examples(count):
    """So many random examples, however long they take."""
    return settings(max_examples=count, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])


@st.composite
def effect(draw, kind, variant):
    """An effect with any parameters."""
    facts = kind.parameters()
    return kind(**{fact.name: draw(st.floats(fact.lower, fact.upper)) for fact in facts}, **variant)


@st.composite
def effects(draw):
    """None, or up to three effects of different kinds."""
    chosen = draw(st.lists(st.sampled_from(READINGS), max_size=3, unique_by=lambda reading: reading[0]))
    return tuple(draw(effect(*reading)) for reading in chosen)


@st.composite
def scenarios(draw, laws, links=LINKS):
    """Any arm in any state under any command."""
    arm = ArmSpecification(
        links=draw(links),
        placement=draw(st.sampled_from(["base", "mid"])),
        mount=draw(st.sampled_from(["hanging", "upright", "horizontal", "flat"])),
        keq=draw(st.floats(0.3, 5)),
        damping=draw(st.floats(0.01, 0.5)),
        length=draw(st.floats(0.1, 0.6)),
        mass=draw(st.floats(0.05, 0.5)),
        tip_mass=draw(st.sampled_from([0.0, 0.03, 0.3])),
        tilt=draw(st.floats(-1, 1)),
        bending_limit=50.0,
    )
    generator = np.random.default_rng(draw(st.integers(0, 2**32)))
    angles = generator.normal(0, 1.0, arm.links) / arm.links
    rates = generator.normal(0, 5.0, arm.links) / arm.links
    time = np.arange(13) * draw(st.sampled_from([0.004, 0.01, 0.03]))
    torque = generator.normal(0, 0.7, 13) * draw(st.sampled_from([0.1, 1.0]))
    start = draw(st.sampled_from([Pose(angles, rates), Settled(torque[0])]))
    return Scenario(arm, time, torque, start, draw(laws), interpolated=draw(st.booleans()))


def check(scenario, dynamics="aba", **how):
    """Both ways take the same steps, and arrive at the same places."""
    batch, method = ArmBatch.of([scenario]), Integrator(**how)
    here, there = (simulate_together([scenario], batch, method, way) for way in ("compiled", dynamics))
    np.testing.assert_array_equal(here.steps, there.steps)
    np.testing.assert_array_equal(here.lost, there.lost)
    fast = max(1.0, np.abs(there.rates).max())
    np.testing.assert_allclose(here.angles, there.angles, rtol=0, atol=1e-10)
    np.testing.assert_allclose(here.rates, there.rates, rtol=0, atol=1e-9 * fast)
    np.testing.assert_allclose(here.end.z, there.end.z, rtol=0, atol=1e-10)
    return here


@every_reading
def test_every_effect_moves_an_arm_alike_on_both_ways(reading):
    @examples(12)
    @given(scenarios(effect(*reading).map(lambda law: (law,))), st.sampled_from([0.005, 0.01]))
    def alike(scenario, step):
        check(scenario, step=step)

    alike()


@every_reading
@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal", "flat"])
@pytest.mark.parametrize("placement", ["base", "mid"])
def test_with_steps_of_its_own_every_effect_moves_an_arm_alike(reading, placement, mount):
    kind, variant = reading
    law = kind(**{fact.name: fact.neutral + 0.3 * (fact.upper - fact.neutral) for fact in kind.parameters()}, **variant)
    time = np.arange(61) * 0.01
    arm = ArmSpecification(links=5, placement=placement, mount=mount, tip_mass=0.02)
    torque = np.select([time < 0.1, time < 0.3], [0.0, 0.6], -0.4)
    run = check(Scenario(arm, time, torque, effects=(law,)))
    assert np.ptp(run.steps) > 0


@examples(60)
@given(scenarios(effects()), st.sampled_from([{"step": 0.01}, {"step": 0.005, "name": "extrapolated2"}, {}, {"tolerance": 1e-6}]))
def test_any_arm_with_any_effects_moves_alike(scenario, how):
    check(scenario, **how)


@examples(25)
@given(scenarios(effects(), links=st.integers(1, 16)))
def test_recursive_newton_euler_moves_it_alike_too(scenario):
    check(scenario, "rnea", step=0.01)


@pytest.mark.parametrize("links", [1, 2, 3, 4, 7, 16, 33, 64])
@pytest.mark.parametrize("placement", ["base", "mid"])
@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal", "flat"])
def test_a_plain_arm_of_any_number_of_links_moves_alike(links, placement, mount):
    time = np.arange(31) * 0.01
    scenario = Scenario(ArmSpecification(links=links, placement=placement, mount=mount), time, np.full(31, 0.8))
    check(scenario)
    check(scenario, step=0.01)


@pytest.mark.long
def test_all_pairs_of_effects_move_an_arm_alike():
    time = np.arange(31) * 0.01
    torque = np.select([time < 0.05, time < 0.2], [0.0, 0.7], -0.5)
    for (one, first), (other, second) in itertools.combinations(READINGS, 2):
        if one is other:
            continue
        laws = tuple(
            kind(**{fact.name: fact.neutral + 0.2 * (fact.upper - fact.neutral) for fact in kind.parameters()}, **variant)
            for kind, variant in ((one, first), (other, second))
        )
        check(Scenario(ArmSpecification(links=4, placement="mid"), time, torque, effects=laws), step=0.01)


@examples(25)
@given(scenarios(effects(), links=st.integers(1, 8)), st.integers(0, 2**32))
def test_different_arms_side_by_side_move_alike(scenario, seed):
    generator = np.random.default_rng(seed)
    family = [scenario]
    for _ in range(3):
        arm = replace(
            scenario.arm, keq=generator.uniform(0.5, 3), mass=generator.uniform(0.1, 0.3), tilt=generator.uniform(-1, 1)
        )
        family.append(replace(scenario, arm=arm))
    batch = ArmBatch.of(family)
    method = Integrator(step=0.01).for_arm(bool(batch.ringing[0]))  # one method for all, as in a batch of simulate_batch
    here, there = (simulate_together(family, batch, method, way) for way in ("compiled", "aba"))
    np.testing.assert_allclose(here.angles, there.angles, rtol=0, atol=1e-10)
    for b in range(4):
        alone = simulate_together(family[b : b + 1], batch.members(slice(b, b + 1)), method, "compiled")
        np.testing.assert_allclose(here.angles[:, b], alone.angles[:, 0], rtol=0, atol=1e-11)


@examples(80)
@given(scenarios(effects()), st.floats(-2, 2))
def test_arms_rest_alike(scenario, torque):
    batch, wanted = ArmBatch.of([scenario]), np.ones(1, dtype=bool)
    near = np.zeros((1, batch.links))
    here, there = (Engine(batch, way).settled(np.array([torque]), wanted, near) for way in ("compiled", "aba"))
    beside = [Engine(batch, "aba").settled(np.array([torque + change]), wanted, near) for change in (-1e-7, 1e-7)]
    moved = max(np.abs(other - there[0]).max() for other, _ in beside)
    assume(moved < 1e-5 and beside[0][1] == there[1] == beside[1][1])  # not where it buckles, or a law softens to nothing
    assert here[1] == there[1]
    loose = any(law.name == "backlash" for law in batch.laws)  # no stiffness in the play: a residual of 1e-8 is far
    np.testing.assert_allclose(here[0], there[0], rtol=0, atol=1e-5 if loose else 1e-9)


def test_sensitivities_are_alike_on_all_three_ways():
    time = np.arange(31) * 0.01
    laws = (EFFECTS["dry_friction"](0.05), EFFECTS["actuator_lag"](0.05), EFFECTS["soft_spot"](0.3))
    scenario = Scenario(ArmSpecification(links=4), time, np.where(time < 0.05, 0.0, 0.8), effects=laws)
    names = ["keq", "damping", "tip_mass", "dry_friction.level", "actuator_lag.time_constant", "soft_spot.centre"]
    found = [sensitivities([scenario], names, dynamics=way)[1][0] for way in ("compiled", "aba", "rnea")]
    for other in found[1:]:
        scale = np.abs(other).max(axis=(0, 1, 2))
        assert np.all(np.abs(found[0] - other).max(axis=(0, 1, 2)) < 1e-7 * scale)


def test_a_difference_in_the_arm_is_noticed():
    """The comparison can fail: a hundred-millionth of the stiffness is seen."""
    time = np.arange(31) * 0.01
    scenario = Scenario(ArmSpecification(), time, np.full(31, 0.8))
    other = replace(scenario, arm=replace(scenario.arm, keq=scenario.arm.keq * (1 + 1e-8)))
    (one,), (two,) = simulate_batch([scenario]), simulate_batch([other], dynamics="aba")
    assert np.abs(one.trajectory.joint_angles - two.trajectory.joint_angles).max() > 1e-10
