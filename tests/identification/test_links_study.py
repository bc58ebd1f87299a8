"""How many links: the error of a chain falls with its square, and no more links are recommended than the data can show."""

import numpy as np
import pytest

from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.links_study import links_study
from hsr_pin.inference.fit import fit


@pytest.fixture(scope="module")
def study(record):
    experiment = prepare(record([(1.11, 1.0)], seconds=0.6))
    answer = fit(experiment, Hypothesis())
    return links_study(experiment, answer.hypothesis, answer.values, links=(2, 4, 8, 12))


def test_the_model_error_falls_with_the_square_of_the_number(study):
    counts, errors = (np.array([getattr(row, name) for row in study.rows]) for name in ("links", "model_error"))
    assert np.all(np.diff(errors) < 0)
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(-2, abs=0.6)


def test_the_fewest_links_within_the_noise_are_recommended(study):
    limit = max(study.noise / 2, 0.00024)
    good = [row.links for row in study.rows if row.model_error < limit]
    assert study.recommended == min(good) > 2
    assert f"N = {study.recommended} " in study.sentence
    assert "more links do not reduce the data error" in study.sentence


def test_the_cost_grows_with_the_links(study):
    assert [row.cost for row in study.rows] == pytest.approx([1, 2, 4, 6])


def test_too_few_links_are_not_recommended(record):
    experiment = prepare(record([(1.11, 1.0)], seconds=0.6))
    few = links_study(experiment, Hypothesis(placement="base"), np.array([1.0, 1.0]), links=(1, 2))
    assert few.recommended is None
    assert "more links" in few.sentence
