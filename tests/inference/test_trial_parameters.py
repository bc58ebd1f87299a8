"""Errors of initial states are eliminated as far as their priors allow."""

from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.inference.trial_parameters import plausible_inflation, without_trial_parameters

PROBLEM = SimpleNamespace(systematic=0, unconditional=1, confounded=np.ones(1, dtype=bool))
TIME = np.linspace(0, 1, 50)
WEIGHTS = [np.ones((50, 1, 1))] * 20
BASES = [20 * TIME[:, None, None, None]] * 20


def residuals(size, seed=0):
    """Return noise plus what errors of an initial speed make, of a size in standard deviations."""
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(50, 1, 1)) + size * rng.normal() * 20 * TIME[:, None, None] for _ in range(20)]


def left(size):
    """Return the RMS of the residuals after the elimination."""
    found = without_trial_parameters(residuals(size), WEIGHTS, BASES, PROBLEM)
    return np.sqrt(np.mean(np.square(found)))


def test_errors_of_their_stated_size_are_eliminated():
    assert plausible_inflation(residuals(1.0), WEIGHTS, BASES, PROBLEM) == pytest.approx(np.ones(1))
    assert left(1.0) < 1.1


def test_what_would_need_errors_far_beyond_their_priors_stays():
    assert plausible_inflation(residuals(30.0), WEIGHTS, BASES, PROBLEM)[0] > 10
    assert left(30.0) > 0.8 * np.sqrt(np.mean(np.square(residuals(30.0))))


def test_the_errors_that_are_used_agree_with_their_priors():
    rows, basis = residuals(30.0), BASES[0][:, 0, 0]
    factor = plausible_inflation(rows, WEIGHTS, BASES, PROBLEM)[0]
    used = [float(basis[:, 0] @ row[:, 0, 0]) / (basis[:, 0] @ basis[:, 0] + factor**2) for row in rows]
    assert 1.0 < np.mean(np.square(used)) < 2.0


def test_parameters_that_are_not_confounded_are_always_eliminated():
    free = SimpleNamespace(systematic=0, unconditional=1, confounded=np.zeros(1, dtype=bool))
    assert plausible_inflation(residuals(30.0), WEIGHTS, BASES, free) == pytest.approx(np.ones(1))
