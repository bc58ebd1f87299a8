"""The laws outside the catalogue have an influence, equal in the compiled loop and in the Pinocchio loop."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate

from .outside import OUTSIDE


@pytest.mark.parametrize("law", OUTSIDE.values(), ids=OUTSIDE)
def test_a_law_outside_moves_the_tip_and_both_loops_agree(law):
    scenario = step_scenario(ArmSpecification(links=4, placement="mid"), 0.8, duration=1.2)
    with_law = replace(scenario, effects=(law,))
    bare, compiled, reference = (
        simulate(each, dynamics=dynamics).trajectory.marker("tip")
        for each, dynamics in ((scenario, "compiled"), (with_law, "compiled"), (with_law, "aba"))
    )
    assert np.abs(compiled - bare).max() > 5e-3
    assert np.abs(compiled - reference).max() < 1e-9


def test_none_of_them_is_in_the_catalogue():
    assert not {*OUTSIDE} & {*EFFECTS, *FLEXIBLE}
