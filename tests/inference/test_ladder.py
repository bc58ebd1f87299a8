"""The shares of the ladder add up to the squared gap."""

import itertools

import numpy as np
import pytest

from hsr_pin.inference.ladder import ladder

NOISE = 0.5e-3


def residuals(*sizes):
    """Return residuals of one marker, with a constant distance [m] from the measurement in each trial."""
    return [np.tile([0.0, 0.0, size], (10, 1, 1)) for size in sizes]


@pytest.fixture
def rungs():
    return ladder(
        [
            ("declared model", (), residuals(8e-3, 10e-3, 9e-3, 12e-3, 7e-3)),
            ("finer discretisation", (), residuals(6e-3, 6e-3, 7e-3, 8e-3, 5e-3)),
            ("stiffness and damping", (), residuals(6e-3, 7e-3, 7e-3, 8e-3, 5e-3)),
            ("dry_friction", ("dry_friction",), residuals(1e-3, 2e-3, 1e-3, 1e-3, 1e-3)),
        ],
        NOISE,
        seed=0,
    )


def test_shares_add_up_to_one_and_the_last_line_is_the_rest(rungs):
    assert sum(rung.share for rung in rungs) == pytest.approx(1.0)
    last, rest = rungs[-2], rungs[-1]
    drops = [max(0.0, before.rms**2 - after.rms**2) for before, after in itertools.pairwise(rungs)]
    assert rest.share == pytest.approx((last.rms**2 - NOISE**2) / sum(drops))
    assert (rest.rms, rest.interval, rest.effects) == (NOISE, (NOISE, NOISE), ())
    assert "remainder" in rest.name


def test_each_share_is_what_the_rung_takes_away_and_a_step_backwards_has_none(rungs):
    assert rungs[0].share == rungs[2].share == 0.0
    taken = {rung.name: before.rms**2 - rung.rms**2 for before, rung in itertools.pairwise(rungs)}
    assert taken["stiffness and damping"] < 0
    for rung in (rungs[1], rungs[3]):
        assert rung.share / rungs[4].share == pytest.approx(taken[rung.name] / taken[rungs[4].name])
    assert 0 < rungs[4].share < rungs[3].share < rungs[1].share


def test_what_does_not_repeat_has_a_row_of_its_own_above_the_noise():
    own = 1e-3
    *_, model, scatter, floor = ladder([("declared model", (), residuals(*[2e-3] * 5))], NOISE, 0, own)
    assert "not repeatable" in scatter.name and scatter.rms == pytest.approx(np.hypot(own, NOISE))
    assert (model.share, scatter.share, floor.share) == pytest.approx((0.0, (4 - 1 - 0.25) / 3.75, 1 / 3.75))


def test_how_far_the_arm_is_from_itself_is_no_floor_for_a_model_that_is_closer():
    rungs = ladder([("declared", (), residuals(*[3e-3] * 5)), ("finer", (), residuals(*[1e-3] * 5))], NOISE, 0, 2e-3)
    assert [rung.share for rung in rungs] == pytest.approx([0.0, 8 / 8.75, 0.75 / 8.75])
    assert not any("not repeatable" in rung.name for rung in rungs)


def test_every_interval_contains_its_estimate(rungs):
    for rung in rungs:
        assert rung.interval[0] <= rung.rms <= rung.interval[1]
    assert all(rung.interval[0] < rung.interval[1] for rung in rungs[:-1])


def test_names_effects_and_errors_are_those_of_the_models(rungs):
    assert [rung.name for rung in rungs[:-1]] == [
        "declared model",
        "finer discretisation",
        "stiffness and damping",
        "dry_friction",
    ]
    assert rungs[3].effects == ("dry_friction",)
    assert rungs[0].rms == pytest.approx(np.sqrt(np.mean(np.array([8, 10, 9, 12, 7]) ** 2)) * 1e-3)


def test_the_same_seed_gives_the_same_ladder():
    models = [("declared model", (), residuals(8e-3, 10e-3, 9e-3)), ("finer", (), residuals(6e-3, 6.5e-3, 7e-3))]
    assert ladder(models, NOISE, seed=4) == ladder(models, NOISE, seed=4)


def test_models_within_the_noise_that_take_nothing_away_have_nothing_to_share():
    rungs = ladder([("declared model", (), residuals(0.3e-3)), ("finer", (), residuals(0.3e-3))], NOISE, seed=0)
    assert [rung.share for rung in rungs] == [0.0, 0.0, 0.0]
