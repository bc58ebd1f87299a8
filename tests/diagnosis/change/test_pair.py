"""A delayed command shifts the response of the arm, independently of any model."""

import numpy as np
import pytest

from hsr_pin.blind.real.edits import delay_motion
from hsr_pin.diagnosis.change.discrepancy import rows_of
from hsr_pin.diagnosis.change.pair import pair
from hsr_pin.identification.experiment import prepare

from .recorded import recorded


@pytest.fixture(scope="module")
def late():
    old = recorded(noise=0.0)
    return pair(prepare(old), prepare(delay_motion(old, 0.06)))


def test_what_was_seen_late_less_the_shift_is_what_was_seen_in_time(late):
    for old, new in zip(late.old_runs, late.new_runs, strict=True):
        in_time, seen = (late.bins[k](late.experiment.runs[k].compared) for k in (old, new))
        back = seen - late.later(new, np.array([0.06]))[..., 0]
        off, was = (float(np.sqrt(np.mean((each - in_time)[:-5] ** 2))) for each in (back, seen))
        assert off < 0.1 * was


def test_no_delay_shifts_nothing(late):
    assert late.later(0, np.zeros(2)) == pytest.approx(0.0, abs=1e-12)


def test_what_goes_together_at_all_markers_is_one_of_the_rows(late):
    rng = np.random.default_rng(0)
    shape = np.array([[0.3, -0.1], [0.9, -0.3]]) / np.linalg.norm([0.3, 0.1, 0.9, 0.3])
    sizes = [rng.standard_normal((len(bins.time), 1, 1)) for bins in late.bins]
    missed = [shape * each + 0.01 * rng.standard_normal((len(each), 2, 2)) for each in sizes]
    rows = rows_of(late, missed)
    mixes = np.array([each.mix.ravel() for each in rows])
    np.testing.assert_allclose(mixes @ mixes.T, np.eye(4), atol=1e-12)
    assert max(abs(each @ shape.ravel()) for each in mixes) > 0.999
    spread = sorted(float(each.of(missed).std()) for each in rows)
    assert spread[-2] < 0.1 * spread[-1]


def test_markers_that_are_often_seen_one_without_the_other_stand_alone():
    old = recorded()
    for trial in old.trials:
        positions = np.array(trial.trajectory.positions)
        positions[::2, 1] = np.nan
        object.__setattr__(trial.trajectory, "positions", positions)
    both = pair(prepare(old), prepare(old))
    rows = rows_of(both, [np.random.default_rng(0).standard_normal((len(bins.time), 2, 2)) for bins in both.bins])
    assert [each.mix.tolist() for each in rows] == np.eye(4).reshape(4, 2, 2).tolist()
