"""Held-out errors have intervals, and a gain is significant if it holds in most of the trials."""

import numpy as np
import pytest

from hsr_pin.inference.resampling import draws, gain_interval, interval, significantly_better, squares

from .fabricated import noise, trials_of


@pytest.mark.parametrize(("trials", "blocks"), [(1, 8), (2, 8), (3, 9), (4, 8), (5, 5), (12, 12)])
def test_a_block_is_a_trial_or_with_fewer_than_five_a_piece_of_one(trials, blocks):
    parts = squares(trials_of(*[1e-3] * trials))
    assert len(parts.sums) == len(parts.counts) == blocks


def test_blocks_hold_every_marker_that_was_seen_and_nothing_else():
    residuals = noise(1e-3, samples=41)
    residuals[0][:20, 1] = np.nan
    residuals[2][5, 0, 2] = np.nan  # a marker without one coordinate was not seen
    distances = np.concatenate([(part**2).sum(axis=2).ravel() for part in residuals])
    parts = squares(residuals)
    assert parts.counts.sum() == np.isfinite(distances).sum() == 4 * 82 - 21
    assert parts.mean == pytest.approx(np.nanmean(distances))


def test_a_trial_without_a_seen_marker_is_no_block():
    residuals = [*trials_of(1e-3, 1e-3, 1e-3, 1e-3), np.full((40, 1, 3), np.nan)]
    assert len(squares(residuals).sums) == 4


def test_every_resample_draws_as_many_blocks_as_there_are_and_the_same_ones_for_the_same_seed():
    assert np.all(draws(7, seed=3).sum(axis=1) == 7)
    assert np.array_equal(draws(7, seed=3), draws(7, seed=3))
    assert not np.array_equal(draws(7, seed=3), draws(7, seed=4))


def test_the_interval_contains_the_estimate_and_widens_with_the_spread_between_trials():
    def width(*sizes):
        parts = squares(trials_of(*sizes))
        low, high = interval(parts, seed=0)
        assert low <= parts.mean**0.5 * (1 + 1e-12) and parts.mean**0.5 <= high * (1 + 1e-12)
        return high - low

    assert width(*[1e-3] * 6) == pytest.approx(0.0, abs=1e-12)
    assert 0 < width(*np.linspace(0.9e-3, 1.1e-3, 6)) < width(*np.linspace(0.2e-3, 1.8e-3, 6))


def test_the_interval_holds_the_truth_about_as_often_as_it_says():
    generator = np.random.default_rng(8)
    held = 0
    for seed in range(200):
        sizes = np.abs(generator.normal(1e-3, 0.2e-3, 20))
        low, high = interval(squares(trials_of(*sizes, samples=2)), seed)
        held += low <= np.sqrt(1e-6 + 0.04e-6) <= high
    assert 0.86 < held / 200 < 0.99


def test_an_equal_gain_in_every_trial_is_certain_however_much_the_trials_differ():
    before = np.array([1e-3, 5e-3, 2e-3, 9e-3, 3e-3])
    after = np.sqrt(before**2 - 0.25e-6)
    low, high = gain_interval(squares(trials_of(*before)), squares(trials_of(*after)), seed=0)
    assert low == pytest.approx(0.25e-6) and high == pytest.approx(0.25e-6)


def test_a_large_gain_in_one_trial_alone_is_not_certain():
    before = squares(trials_of(9e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3))
    after = squares(trials_of(1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3))
    low, high = gain_interval(before, after, seed=0)
    assert low < 0 < before.mean - after.mean < high


def test_what_shows_in_two_trials_of_six_is_certain_and_in_one_alone_is_not():
    same = trials_of(*[1e-3] * 6)
    assert significantly_better(same, trials_of(2e-3, 2e-3, *[1e-3] * 4), seed=0)
    assert not significantly_better(same, trials_of(9e-3, *[1e-3] * 5), seed=0)
    assert not significantly_better(same, same, seed=0)


def test_a_loss_is_a_gain_below_zero():
    before, after = squares(trials_of(*[1e-3] * 5)), squares(trials_of(*[2e-3] * 5))
    assert gain_interval(before, after, seed=0) == pytest.approx((-3e-6, -3e-6))
