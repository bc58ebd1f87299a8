"""The paper's procedure ends at the parameters of the arm that made the data, if that arm is the paper's chain."""

import numpy as np
import pytest

from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.paper_procedure import paper_procedure


@pytest.fixture(scope="module")
def carried_out(record):
    dataset = record([(1.11, 0.6), (2.33, 1.5)], keq=1.1, damping=1.7, noise=1e-5)
    return paper_procedure(prepare(dataset), links=24, placement="mid")


def test_it_finds_what_made_the_data(carried_out):
    assert carried_out.last.keq_scale == pytest.approx(1.1, rel=0.02)
    assert carried_out.last.damping_scale == pytest.approx(1.7, rel=0.05)


def test_no_pass_makes_it_worse_by_much_and_the_last_is_the_best(carried_out):
    errors = [step.rms for step in carried_out.passes]
    assert errors[0] > 5 * errors[-1]
    assert errors[-1] <= min(errors) * 1.01


def test_the_best_of_its_grid_is_not_at_the_edge(carried_out):
    factors, errors = carried_out.grid
    assert 0 < int(np.argmin(errors)) < len(factors) - 1
    assert carried_out.simulations == 1 + (3 + len(factors)) * (len(carried_out.passes) - 1)
