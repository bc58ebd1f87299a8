"""A command that comes late shifts what the arm did, whatever any model makes of it."""

import numpy as np
import pytest

from hsr_pin.blind.real.edits import delay_motion
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
