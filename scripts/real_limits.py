"""Print what two real recordings show without a model of the arm, and thus what a model cannot be expected to predict.

Usage: scripts/real_limits.py [folder of recordings]. Default: ../shared/recordings next to the repository. Takes a few seconds.

For the beam: the decay of its oscillation, with and without a payload, as in the model-free indicators of a report. For the
pneumatic arm: the lag of its supply, from measured and commanded pressures, as a delay with one time constant for filling and one
for venting (the law of ``unequal_lag``).
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.diagnosis.indicators.decay import decay
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset

ROOT = Path(__file__).resolve().parent.parent
#: Supply: step of its simulation [s], chambers that bend the arm in its plane, initial rise, fall and delay of the fit [s].
STEP, CHAMBERS, START = 0.01, ("1A", "1B", "2A", "2B"), (0.3, 1.0, 0.2)


def supplied(time: np.ndarray, command: np.ndarray, rise: float, fall: float, delay: float) -> np.ndarray:
    """Return the response (T,) to a command after a delay and a first-order lag with time constants for rise and fall."""
    grid = np.arange(time[0], time[-1] + STEP, STEP)
    wanted = np.interp(grid - delay, time, command)
    here, values = wanted[0], np.empty_like(wanted)
    shares = {way: 1 - np.exp(-STEP / max(constant, 0.1 * STEP)) for way, constant in ((True, rise), (False, fall))}
    for k, value in enumerate(wanted):
        here += (value - here) * shares[value > here]
        values[k] = here
    return np.interp(time, grid, values)


def supply(trials: list[dict[str, np.ndarray]]) -> tuple[float, float, float, float, float]:
    """Return rise, fall and delay [s], and the RMS error of the pressures [bar] with and without this response."""

    def missed(values: np.ndarray) -> np.ndarray:
        rows = []
        for trial in trials:
            for chamber in CHAMBERS:
                model = supplied(trial["t"], trial[f"command{chamber}"], *values)
                seen = trial[f"measured{chamber}"]
                columns = np.stack([np.ones_like(model), model], axis=1)  # sensors have an offset and a gain error
                rows.append(seen - columns @ np.linalg.lstsq(columns, seen, rcond=None)[0])
        return np.concatenate(rows)

    found = least_squares(missed, START, bounds=([0, 0, 0], [5, 10, 2]), diff_step=1e-2)
    rise, fall, delay = map(float, found.x)
    left, none = (float(np.sqrt(np.mean(missed(values) ** 2))) for values in (found.x, np.zeros(3)))
    return rise, fall, delay, left, none


def pressures(folder: Path) -> list[dict[str, np.ndarray]]:
    """Return the columns of the pressures [bar] and times [s] of each trial."""
    trials = []
    for file in sorted(folder.glob("*.csv")):
        with file.open(encoding="utf-8") as text:
            rows = list(csv.DictReader(text))
        trials.append({name: np.array([float(row[name]) for row in rows]) for name in rows[0]})
    return trials


def main() -> None:
    """Print both results."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT.parent / "shared" / "recordings"
    swings = decay(prepare(read_dataset(folder / "real-beam")))
    print(swings.sentence if swings else "The beam does not swing.")
    rise, fall, delay, left, none = supply(pressures(folder / "real-pneumatic" / "pressures"))
    print(
        f"\nMeasured pressures come {delay:.2f} s after those commanded, filling with a time constant of {rise:.2f} s, "
        f"venting with {fall:.2f} s ({left:.3f} bar RMS are left of {none:.3f})."
    )


if __name__ == "__main__":
    main()
