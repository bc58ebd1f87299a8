"""Scaling makes up for a confidence that is stated too low, and leaves one that is right."""

import numpy as np
import pytest

SCRIPT = "scale_confidence"


def stated(rng, claim, shift, power, count=4000):
    """Claims that are right as often as a confidence says that is scaled so."""
    said = rng.uniform(0.02, 0.98, count)
    right = rng.random(count) < 1 / (1 + np.exp(-shift) * (1 / said - 1) ** power)
    return [[(claim, value, so)] for value, so in zip(said, right, strict=True)]


@pytest.mark.parametrize(("shift", "power"), [(0.0, 1.0), (1.0, 0.6)])
def test_what_was_stated_wrongly_is_found_and_mended(script, shift, power):
    run = stated(np.random.default_rng(3), "hysteresis", shift, power)
    found = script.fitted([run], names=True)
    assert (found.shift, found.power) == pytest.approx((shift, power), abs=0.1)
    assert not found.of_kind
    assert script.error(run, found, script.Scale()) < 0.03
    assert (script.error(run, script.Scale(), script.Scale()) > 0.1) is (shift > 0)


def test_of_kinds_one_that_is_right_more_often_than_others_is_told_from_them(script):
    rng = np.random.default_rng(5)
    run = stated(rng, "creep", 0.0, 1.0) + stated(rng, "damping", 1.0, 1.0) + stated(rng, "hysteresis", -2.0, 1.0)
    found = script.fitted([run], names=False)
    assert set(found.of_kind) == {"creep", "damping"}  # a name tells nothing of them
    assert found.of_kind["damping"] - found.of_kind["creep"] == pytest.approx(1.0, abs=0.15)
    assert found.of("damping", 0.5) == pytest.approx(1 / (1 + np.exp(-1.0)), abs=0.03)
    assert found.of("creep", 0.5) == pytest.approx(0.5, abs=0.03)


def test_names_and_kinds_are_scaled_each_on_their_own(script):
    run = [[("friction", 0.6, True), ("friction", 0.6, False)]]
    assert script.error(run, script.Scale(1.0, 0.6), script.Scale()) == pytest.approx(0.1)
    assert script.error(run, script.Scale(), script.Scale(0.0, 1.0, {"friction": -0.405})) == pytest.approx(0.0, abs=0.001)


def test_claims_are_counted_by_their_kind_and_their_confidence(script):
    run = [[("creep", 0.6, True), ("creep", 0.9, False)], [("creep", 0.6, False), ("damping", 0.6, True)]]
    assert script.right([run], "creep", 0.5, 0.75) == "1 of 2"
