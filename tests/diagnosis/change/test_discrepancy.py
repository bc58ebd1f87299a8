"""The hyperparameters of the discrepancy are recovered, and the gradient of the likelihood is correct."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from hsr_pin.diagnosis.change import discrepancy
from hsr_pin.diagnosis.change.discrepancy import Covariance, fitted_hyperparameters
from hsr_pin.inference.trial_parameters import Eliminated


def covariance(runs=5, samples=50, seed=0):
    """Return the covariance of runs with nearly equal motion, which differ by noise only."""
    rng = np.random.default_rng(seed)
    run, time = np.repeat(np.arange(runs), samples), np.tile(0.04 * np.arange(samples), runs)
    x = np.column_stack([3 * time, np.sin(time) + 0.1 * rng.standard_normal(runs)[run]])
    distance = ((x[:, None] - x) ** 2).sum(axis=2)
    ones, n = np.ones(len(run)), len(run)
    same = (run[:, None] == run).astype(float)
    return Covariance(distance, same, np.abs(time[:, None] - time), 0 * ones, ones, 0 * ones, np.full(n, 1e-8), 1e-3)


def test_what_trials_share_is_told_from_what_each_has_of_its_own():
    form, found = covariance(), {}
    for name, sizes in {"shared": (1.0, 0.05, 0.05), "own": (0.05, 0.6, 0.6)}.items():
        true = np.log([*sizes, 0.5, 1.0, 1.5, 2.0])
        draw = np.linalg.cholesky(form.matrix(true)) @ np.random.default_rng(1).standard_normal(len(form.white))
        found[name] = np.exp(fitted_hyperparameters(form, draw, np.zeros((len(draw), 0))))
    assert found["shared"][0] > 5 * found["shared"][1]
    assert found["shared"][4] == pytest.approx(1.0, rel=0.3)
    assert found["own"][0] < max(found["own"][1:3])
    assert found["own"][1] > 5 * found["shared"][1]


def test_the_slope_of_the_likelihood_is_its_slope(monkeypatch):
    form, seen = covariance(runs=3, samples=20), {}
    monkeypatch.setattr(
        discrepancy, "minimize", lambda cost, start, **options: seen.setdefault("at", (cost, start)) and _At(start)
    )
    draw = np.linalg.cholesky(form.matrix(discrepancy._EXPECTED)) @ np.random.default_rng(2).standard_normal(len(form.white))
    fitted_hyperparameters(form, draw, np.zeros((len(draw), 0)))
    cost, start = seen["at"]
    assert cost(start + 0.1)[1] == pytest.approx(approx_fprime(start + 0.1, lambda x: cost(x)[0], 1e-6), rel=1e-3, abs=1e-3)


class _At:
    def __init__(self, x):
        self.x = x


def test_rows_that_follow_on_zeros_are_freed_of_numbers_as_all_rows_are():
    rng = np.random.default_rng(3)
    basis, rows = rng.standard_normal((40, 4)), np.vstack([np.zeros((15, 2)), rng.standard_normal((25, 2))])
    free = Eliminated.of(basis)
    assert free.after(15, rows[15:]) == pytest.approx(free(rows))
