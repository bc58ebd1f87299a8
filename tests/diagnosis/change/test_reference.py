"""The reference recording is described by its true law, not by one that is nearly equivalent."""

from hsr_pin.diagnosis.change.reference import described
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.parallel import open_executor

from ..made import made


def test_a_slow_actuator_is_not_taken_for_an_arm_that_is_damped_more():
    experiment = prepare(made("actuator_lag:time_constant=0.4", links=12, damping=1.0, duration=3.0))
    parts = [Part("actuator_lag", neutral(EFFECTS["actuator_lag"]))]
    with open_executor(1) as executor:
        found = described(experiment, Hypothesis(links=8), parts, FitPool(experiment, executor), max_effects=1)
    assert found.names == ("actuator_lag",)
    assert abs(found.fit.named["actuator_lag.time_constant"] - 0.4) < 0.1
