"""What makes a supply late is found again, and a beam that no damper damps."""

import numpy as np
import pytest

SCRIPT = "real_limits"


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


@pytest.mark.long
def test_both_are_told_of_the_recordings(script, shared, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["real_limits.py", str(shared / "recordings")])
    script.main()
    printed = capsys.readouterr().out
    assert "With 52 g at the tip" in printed and "a viscous damper's falls to" in printed and "Measured pressures come" in printed
