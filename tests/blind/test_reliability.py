"""The calibration error is zero within chance for calibrated confidence, and larger otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from hsr_pin.blind.picture import draw_reliability
from hsr_pin.blind.reliability import reliability


def claims(rng, cases, honest):
    """Return two claims for each case, right with the probability that `honest` returns for the confidence."""
    stated = rng.uniform(0, 1, (cases, 2))
    return [[(float(p), bool(rng.random() < honest(p))) for p in pair] for pair in stated]


def test_calibrated_confidence_is_within_chance_and_overconfidence_is_not():
    rng = np.random.default_rng(1)
    calibrated = reliability(claims(rng, 400, lambda p: p))
    overconfident = reliability(claims(rng, 400, lambda p: p**3))
    assert calibrated.error <= calibrated.by_chance[1] < overconfident.error
    assert overconfident.interval[0] > calibrated.by_chance[1]
    assert overconfident.error == pytest.approx(0.25, abs=0.05)  # the mean of p - p^3


def test_the_error_of_a_few_claims_equals_the_one_computed_by_hand():
    found = reliability([[(0.95, True), (0.95, False)], [(0.25, False)], [(1.0, True)], []])
    assert found.error == pytest.approx((abs(0.95 + 0.95 + 1.0 - 2) + 0.25) / 4)
    assert [(each.right.hits, each.right.of) for each in found.bins] == [(0, 1), (2, 3)]
    assert [(each.low, each.high) for each in found.bins] == [(0.2, 0.3), (0.9, 1.0)]


def test_claims_of_one_case_are_resampled_together():
    rng = np.random.default_rng(2)
    alone = claims(rng, 60, lambda p: p)
    many = [pair * 10 for pair in alone]
    a, b = (reliability(each).interval for each in (alone, many))
    assert b[1] - b[0] > 0.8 * (a[1] - a[0])  # ten equal claims are no more evidence than one
    assert reliability(many) == reliability(many)


def test_the_picture_is_drawn(tmp_path):
    draw_reliability(reliability(claims(np.random.default_rng(3), 50, lambda p: p)), tmp_path / "trust.png")
    assert (tmp_path / "trust.png").stat().st_size > 5_000
