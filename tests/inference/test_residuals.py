"""The correlated part of residuals is distinguished from white noise."""

import numpy as np
import pytest

from hsr_pin.inference.residuals import lasting_square

from .fabricated import noise, trials_of


def mean_square(residual):
    return float(np.mean((residual**2).sum(axis=-1)))


@pytest.mark.parametrize("size", [1e-5, 3e-4, 0.02])
def test_the_lasting_square_does_not_see_white_noise_of_any_size(size):
    assert lasting_square(noise(size)) < 0.02 * 3 * size**2


@pytest.mark.parametrize("size", [0.0, 1e-4, 2e-3])
def test_the_lasting_square_finds_a_constant_under_any_noise(size):
    constant = np.array([1e-3, 0.0, -2e-3])
    found = lasting_square([part + constant for part in noise(size)])
    assert found == pytest.approx(5e-6, abs=0.02 * size**2 + 0.05 * 2e-3 * size + 1e-15)


def test_the_lasting_square_of_a_slow_swing_is_its_mean_square_times_the_cosine_of_a_sample():
    turn = 2 * np.pi / 50
    swing = np.zeros((50 * 40 + 1, 1, 3))
    swing[:, 0, 0] = 1e-3 * np.sin(turn * np.arange(len(swing)))
    assert lasting_square([swing]) == pytest.approx(0.5e-6 * np.cos(turn), rel=1e-9)


@pytest.mark.parametrize("frequency", [0.02, 0.08, 0.125, 0.17, 0.25, 0.33, 0.375, 0.42, 0.5])
def test_the_lasting_square_finds_a_swing_however_few_samples_it_has_a_cycle(frequency):
    """Near the Nyquist frequency, neighbouring samples of an oscillation have opposite signs."""
    swing = 1e-3 * np.cos(2 * np.pi * frequency * np.arange(3000) + 0.3)[:, None, None] * np.ones((3000, 2, 3))
    assert 0.69 * mean_square(swing) < lasting_square([swing]) < 1.01 * mean_square(swing)


def test_the_lasting_square_is_zero_where_there_are_no_samples():
    assert lasting_square([np.full((30, 2, 3), np.nan)]) == 0.0
    assert lasting_square([]) == 0.0


def test_the_lasting_square_counts_only_neighbours_that_were_both_seen():
    residual = np.zeros((6, 1, 3))
    residual[:, 0, 0] = [1e-3, 1e-3, np.nan, 5e-3, np.nan, 2e-3]
    assert lasting_square([residual]) == pytest.approx(1e-6)


def test_a_single_spike_hardly_changes_the_lasting_square():
    lasting = trials_of(1e-3, samples=400)
    spiked = [lasting[0].copy()]
    spiked[0][200, 0, 1] = 0.03
    assert lasting_square(spiked) == pytest.approx(lasting_square(lasting))
    assert mean_square(spiked[0]) > 3 * mean_square(lasting[0])
