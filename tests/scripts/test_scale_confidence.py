"""Scaling makes up for a confidence that is stated too low, and leaves one that is right."""

import numpy as np
import pytest

SCRIPT = "scale_confidence"


@pytest.mark.parametrize(("shift", "power"), [(0.0, 1.0), (1.0, 0.6)])
def test_what_was_stated_wrongly_is_found_and_mended(script, shift, power):
    rng = np.random.default_rng(3)
    stated = rng.uniform(0.02, 0.98, 4000)
    right = rng.random(4000) < 1 / (1 + np.exp(-shift) * (1 / stated - 1) ** power)
    run = [[(True, value, so)] for value, so in zip(stated, right, strict=True)]
    found = script.fitted([run])
    assert found == pytest.approx((shift, power), abs=0.1)
    assert script.error(run, *found) < 0.03
    assert (script.error(run) > 0.1) is (shift > 0)


def test_kinds_are_not_scaled(script):
    run = [[(False, 0.6, True), (False, 0.6, False)]]
    assert script.error(run, 1.0, 0.6) == script.error(run) == pytest.approx(0.1)
