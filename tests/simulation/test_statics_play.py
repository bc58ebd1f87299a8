"""An arm with play, or close to losing its stiffness, still has a static start: it creeps to rest where Newton's method fails."""

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.effects.backlash import Backlash
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

TORQUES = (0.0, 0.1, 0.6, -0.7, 1.2)


@pytest.mark.parametrize("effect", ["backlash:gap=0.05", "backlash:gap=0.3", "backlash:gap=0.8", "stiffening:cubic=-0.1"])
@pytest.mark.parametrize("links", [1, 4, 10, 32])
@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
def test_an_arm_with_play_or_softening_starts_at_rest_and_stays(mount, links, effect):
    time, law = np.arange(51) * 0.01, parse_effect(effect)
    arms = [ArmSpecification(links=links, mount=mount, placement=placement) for placement in ("base", "mid")]
    runs = [Scenario(arm, time, np.full(51, u), Settled(u), (law,)) for arm in arms for u in TORQUES]
    for result in simulate_batch(runs):
        assert result.completed
        np.testing.assert_allclose(result.trajectory.positions, result.trajectory.positions[:1].repeat(51, axis=0), atol=1e-7)


@pytest.mark.parametrize("side", [-1, 1])
def test_an_upright_arm_with_play_rests_on_the_side_where_it_is_looked_for(side):
    arm = ArmSpecification(mount="upright", placement="mid")
    scenario = Scenario(
        arm, np.arange(51) * 0.01, np.zeros(51), Settled(0.0, near=np.full(4, 0.05 * side)), effects=(Backlash(gap=0.1),)
    )
    tip = simulate(scenario).trajectory.marker("tip")[:, 0]
    assert side * tip[0] > 1e-3
    assert np.abs(tip - tip[0]).max() < 1e-6
