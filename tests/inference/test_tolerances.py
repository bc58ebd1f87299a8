"""Errors of declared numbers are found within their tolerances, and nothing else is taken for one."""

import numpy as np
import pytest

from hsr_pin.inference.tolerances import Tolerances

SAMPLES = 14.0


def case(seed=0, count=4000, errors=4):
    rng = np.random.default_rng(seed)
    basis = 300 * np.linalg.qr(rng.normal(size=(count, errors)))[0]
    groups = [np.arange(count) % 2 == k for k in (0, 1)]
    return basis, groups, rng.normal(size=count)


def test_errors_within_their_tolerances_are_found_and_leave_the_noise():
    basis, groups, noise = case()
    true = np.array([1.0, -0.5, 2.0, 0.0])
    found = Tolerances.of(noise - basis @ true, basis, groups, SAMPLES)
    assert found.errors(noise - basis @ true) == pytest.approx(true, abs=0.25)
    left = found(noise - basis @ true)[: len(noise)]
    assert np.mean(left**2) < 1.1


def test_residuals_that_no_error_makes_are_unchanged():
    basis, groups, noise = case()
    outside = 5 * (noise - basis @ np.linalg.lstsq(basis, noise, rcond=None)[0])
    found = Tolerances.of(outside, basis, [groups[0] | groups[1]], SAMPLES)
    assert np.abs(found(outside)[: len(noise)] - outside).max() < 1e-9


def test_an_error_of_many_tolerances_is_taken_for_a_smaller_one():
    basis, groups, noise = case()
    far = noise - basis[:, :1] @ [1000.0]
    assert Tolerances.of(far, basis, groups, SAMPLES).errors(far)[0] < 500


def test_a_group_with_a_large_discrepancy_does_not_hide_the_errors_that_another_group_shows():
    basis, groups, noise = case()
    basis[groups[1]] = 0.0
    rough = np.where(groups[1], 1e4, 1.0) * noise - basis @ np.ones(4)
    assert Tolerances.of(rough, basis, groups, SAMPLES).errors(rough) == pytest.approx(np.ones(4), abs=0.3)


def test_the_square_of_the_answer_is_smallest_at_the_most_probable_errors():
    basis, groups, noise = case()
    rows = noise - basis @ np.ones(4)
    found = Tolerances.of(rows, basis, [groups[0] | groups[1]], SAMPLES)

    def square(errors):
        return float(np.sum((rows + basis @ errors) ** 2) + found.held**2 * np.sum(errors**2))

    best = found.errors(rows)
    assert np.sum(found(rows) ** 2) == pytest.approx(square(best))
    assert all(square(best) < square(best + side) for side in 0.01 * np.vstack([np.eye(4), -np.eye(4)]))
