"""Smoothing, derivatives and ranks are equal to those of SciPy, to the last digit where a diagnosis depends on them."""

import subprocess
import sys

import numpy as np
import pytest
from scipy import stats
from scipy.signal import savgol_filter

from hsr_pin.diagnosis.smooth import rank_correlation, smoothed


@pytest.mark.parametrize("deriv", [0, 1, 2])
@pytest.mark.parametrize(("shape", "window", "degree"), [((40,), 5, 2), ((31, 3), 7, 3), ((9, 2, 2), 9, 3)])
def test_smoothed_motion_and_its_derivatives_are_scipys_at_the_ends_too(shape, window, degree, deriv):
    values = np.random.default_rng(0).normal(size=shape)
    expected = savgol_filter(values, window, degree, deriv=deriv, delta=0.02, axis=0)
    np.testing.assert_allclose(smoothed(values, window, degree, deriv, 0.02), expected, rtol=1e-12, atol=1e-9)


def test_a_polynomial_of_the_degree_is_left_as_it_is_and_its_derivative_is_exact():
    time = 0.1 * np.arange(20)
    np.testing.assert_allclose(smoothed(time**3 - time, 7, 3), time**3 - time, atol=1e-12)
    np.testing.assert_allclose(smoothed(time**3 - time, 7, 3, 1, 0.1), 3 * time**2 - 1, atol=1e-11)


def test_a_rank_correlation_is_scipys_with_equal_values_too():
    draw = np.random.default_rng(1)
    one, other = draw.integers(0, 9, 60).astype(float), draw.normal(size=60)
    for second in (other, one + other, np.repeat(other[:30], 2)):
        assert rank_correlation(one, second) == pytest.approx(stats.spearmanr(one, second).statistic, abs=1e-14)


def test_a_diagnosis_loads_neither_statistics_nor_signals():
    code = (
        "import sys, hsr_pin.diagnosis.diagnose; from hsr_pin import sample; "
        "from hsr_pin.identification.experiment import prepare; "
        "prepare(sample('valve-arm')); print({'scipy.stats', 'scipy.signal', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
