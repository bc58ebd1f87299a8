"""Probabilities do not depend on the order of models or the number of variants, and are calibrated on synthetic data."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from hsr_pin.inference import Calibration, Cause, Data, Model, posterior
from hsr_pin.inference.model import information
from tests.inference.fabricated import CALIBRATION, DATA, FRICTION, LAG, MASS, model


def probabilities(*models):
    return posterior(models, DATA, CALIBRATION).sets


def test_probabilities_add_up_to_one():
    assert sum(probabilities(model([], 2.0), model([FRICTION], 0.3), model([LAG], 0.4)).values()) == pytest.approx(1.0)


def test_the_order_of_models_does_not_matter():
    models = [model([], 2.0), model([FRICTION], 0.3), model([LAG], 0.4), model([FRICTION, LAG], 0.29)]
    first = probabilities(*models)
    for other in permutations(models):
        assert probabilities(*other) == pytest.approx(first)


def test_a_second_name_for_a_law_halves_what_is_certain_of_it():
    again = Cause("rubbing", "friction")
    alone = probabilities(model([], 50.0), model([FRICTION], 0.0))
    both = probabilities(model([], 50.0), model([FRICTION], 0.0), model([again], 0.0))
    assert both[("friction",)] == pytest.approx(both[("rubbing",)])
    assert both[("friction",)] + both[("rubbing",)] >= alone[("friction",)]


def test_splitting_a_law_into_variants_changes_nothing():
    halves = Cause("friction", "friction", variants=2)
    whole = probabilities(model([], 2.0), model([FRICTION], 0.1))
    parts = probabilities(model([], 2.0), model([halves], 0.1), model([halves], 0.1))
    assert parts == pytest.approx(whole)


def test_a_model_gives_way_to_a_part_that_does_all_that_it_does():
    found = probabilities(model([], 10.0), model([FRICTION], 0.15), model([FRICTION, MASS], 0.0))
    assert found[("friction", "mass")] == 0.0
    assert found[("friction",)] > 0.99


def test_a_model_keeps_its_probability_where_no_part_does_as_much():
    found = probabilities(model([], 10.0), model([FRICTION], 3.0), model([FRICTION, MASS], 0.0))
    assert found[("friction", "mass")] > 0.99


def test_the_arm_alone_stands_for_an_unknown_cause():
    found = probabilities(model([], 10.0), model([FRICTION], 8.5), model([LAG], 9.0))
    assert next(iter(found)) == ()


def test_the_credible_set_is_the_smallest_that_holds_its_level():
    found = posterior([model([], 5.0), model([FRICTION], 0.1), model([LAG], 0.12), model([MASS], 4.0)], DATA, CALIBRATION)
    credible = found.credible(0.95)
    total = sum(found.sets[names] for names in credible)
    assert total >= 0.95 > total - found.sets[credible[-1]]


@pytest.mark.parametrize("seed", [0, 1])
def test_stated_probabilities_are_as_often_right_as_they_say(seed):
    """The share of right answers agrees with the stated probabilities of 0.5 to 0.9, and above, within chance."""
    rng = np.random.default_rng(seed)
    stated, right = [], []
    for _ in range(300):
        claim, truth = _one_case(rng)
        stated.append(claim[1])
        right.append(claim[0] == truth)
    p, y = np.array(stated), np.array(right, dtype=float)
    for low, high in ((0.5, 0.9), (0.9, 1.01)):
        some = (p >= low) & (p < high)
        error = np.sqrt((p[some] * (1 - p[some])).sum()) / some.sum()
        assert y[some].mean() > p[some].mean() - 3 * error - 0.02


def _one_case(rng: np.random.Generator) -> tuple[tuple[tuple[str, ...], float], tuple[str, ...]]:
    """Return the most probable set with its probability, and the truth: one of three shapes, or none, drawn from the prior."""
    count = 40
    numbers = Calibration(samples=float(count), cause=0.0, flexible=0.0, floor=0.0, share=0.0)
    shapes = rng.normal(size=(3, count))
    chosen = int(rng.integers(4))
    size = 5.0 * rng.standard_cauchy() if chosen < 3 else 0.0
    seen = rng.normal(size=count) + (size * 0.2 * shapes[chosen] if chosen < 3 else 0.0)
    models = []
    for k in range(4):
        own = 0.2 * shapes[k : k + 1].T if k < 3 else np.zeros((count, 0))
        value = np.linalg.lstsq(own, seen, rcond=None)[0]
        left = seen - own @ value
        causes = (Cause(f"shape {k}", "elastic"),) if k < 3 else ()
        known = information([own], np.full(own.shape[1], 5.0))[None]
        models.append(Model(causes, np.array([left @ left]) / count, known, value / 5.0))
    found = posterior(models, Data.of_one_group(0.0, count), numbers).sets
    names = next(iter(found))
    return (names, found[names]), ((f"shape {chosen}",) if chosen < 3 else ())
