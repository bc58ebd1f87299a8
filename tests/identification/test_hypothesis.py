"""How a hypothesis is discretised, with laws that need care and without."""

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.identification.evaluation import predict
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.misfit import FINE_LINKS, FINE_STEP


def test_the_fine_chain_is_converged_with_a_strong_quadratic_damping_too(heavy_tip):
    experiment = prepare(heavy_tip)
    hypothesis = Hypothesis().with_effects(EFFECTS["quadratic_damping"](0.03))

    def simulated(model):
        found = predict(experiment, model, [(run, model.start) for run in experiment.runs])
        return np.concatenate([prediction.positions.reshape(-1, 3) for prediction in found])

    fine = hypothesis.finer(FINE_LINKS, FINE_STEP)
    miss = simulated(fine) - simulated(hypothesis.finer(FINE_LINKS, FINE_STEP / 8))
    assert np.sqrt((miss**2).sum(axis=1).mean()) < 5e-5


def test_only_a_law_that_rings_changes_the_integrator():
    calm, ringing = (Hypothesis().with_effects(EFFECTS[name]()) for name in ("hysteresis", "quadratic_damping"))
    assert calm.steadied() is calm and calm.finer(20, 0.005).integrator == "ros2"
    assert ringing.steadied().integrator == "extrapolated3"
    assert ringing.finer(20, 0.005).step == pytest.approx(0.0025)
