"""Damping ratios by payload beside a viscous damper's, and a supply that is late, found again."""

import numpy as np
import pytest

from hsr_pin.diagnosis.fingerprint.decay import Swing

SCRIPT = "real_limits"


def test_a_viscous_dampers_ratio_goes_with_the_frequency(script):
    swings = tuple(
        Swing("trial", (1.0, payload, 0.0), amplitude, frequency, ratio)
        for payload, frequency, ratio in ((0.0, 8.0, 0.06), (0.05, 4.0, 0.05))
        for amplitude, ratio in ((0.1, ratio), (0.05, ratio), (0.01, 2 * ratio))
    )
    light, heavy = script.beam_rows(swings)
    assert light == "| 0 g | 3 | 8.00 Hz | 0.060 | 0.120 | 0.060 |"
    assert heavy == "| 50 g | 3 | 4.00 Hz | 0.050 | 0.100 | 0.030 |"


def test_what_makes_a_supply_late_is_found_again(script):
    rng, time = np.random.default_rng(2), np.arange(0, 30, 0.03)
    trials = []
    for _ in range(2):
        trial = {"t": time}
        for chamber in script.CHAMBERS:
            command = np.repeat(rng.uniform(0, 1, 10), len(time) // 10)
            trial[f"command{chamber}"] = command
            seen = script.supplied(time, command, 0.4, 1.1, 0.15)
            trial[f"measured{chamber}"] = 0.05 + 0.9 * seen + 0.005 * rng.standard_normal(len(time))
        trials.append(trial)
    rise, fall, delay, left, none = script.supply(trials)
    assert (rise, fall, delay) == pytest.approx((0.4, 1.1, 0.15), rel=0.05)
    assert left == pytest.approx(0.005, rel=0.1)
    assert none > 10 * left


def test_both_are_told_of_the_recordings(script, shared, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["real_limits.py", str(shared / "recordings")])
    script.main()
    printed = capsys.readouterr().out
    assert printed.count("\n|") == 3 and "| 52 g |" in printed and "Measured pressures come" in printed
