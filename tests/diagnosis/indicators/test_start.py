"""A slow release by a hand and a slack payload are visible in the motion; a free arm is recognised as free."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.start import start_stretch
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset

from .recorded import STEP, arcs, released, swing


def let_go(until, frequency=1.0, duration=4.0):
    """Return (T,) [rad] of an oscillator from 0.8 rad, held back by a hand whose force falls linearly to zero at ``until``."""
    fine, angle, rate, shown = 20, 0.8, 0.0, []
    step, spring = STEP / fine, (2 * np.pi * frequency) ** 2
    for index in range(round(duration / STEP) * fine):
        if index % fine == 0:
            shown.append(angle)
        grip = 0.0 if until == 0 else max(0.0, 1 - index * step / until)
        rate += step * (-spring * angle * (1 - grip) - 1.2 * rate)
        angle += step * rate
    return np.array(shown)


@pytest.mark.parametrize("until", [0.1, 0.15])
def test_a_hand_is_seen_for_about_as_long_as_it_acts(until):
    found = start_stretch(arcs(let_go(until), noise=2e-5).runs[0])
    assert found.known and found.seconds == pytest.approx(until, abs=0.06)
    assert "hand" in found.message


def test_a_free_arm_is_free():
    for run in (arcs(let_go(0.0), noise=2e-5).runs[0], arcs(swing(0.6, 1.5, 0.05), noise=2e-5).runs[0]):
        assert start_stretch(run).seconds == 0


@pytest.mark.parametrize("effect", ["tip_mass:mass=0.05", "dry_friction:level=0.06", "viscoelastic:ratio=0.4,time_constant=0.4"])
def test_no_law_of_the_arm_is_taken_for_a_hand(effect):
    assert {start_stretch(run).seconds for run in released(effect, damping=0.01).runs} == {0.0}


def test_a_fast_arm_that_is_seldom_seen_cannot_tell():
    found = start_stretch(arcs(swing(0.6, 12.0, 0.05)).runs[0])
    assert found.seconds == 0 and not found.known


def test_hands_and_slack_payloads_of_the_shared_recordings(shared):
    trunk = prepare(read_dataset(shared / "recordings" / "real-trunk"))
    assert 0.08 < np.median([start_stretch(run).seconds for run in trunk.runs]) < 0.2
    beam = [start_stretch(run).seconds for run in prepare(read_dataset(shared / "recordings" / "real-beam")).runs]
    assert beam[:2] == [0.0, 0.0] and all(0.03 < seconds < 0.09 for seconds in beam[2:])
