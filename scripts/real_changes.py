"""Diagnose known changes between recordings of real arms: undeclared payloads, repeated sessions, edited files.

    python scripts/real_changes.py ../shared/recordings [NAME ...]

This takes minutes. One line is printed for each change: the change, and the verdict.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import numpy as np

from hsr_pin import Dataset, diagnose_change, read_dataset
from hsr_pin.blind.real.edits import declare_payload, delay_motion, move_markers, turn_frame
from hsr_pin.trajectory import Trial


def chosen(dataset: Dataset, wanted: Callable[[Trial], bool]) -> Dataset:
    """Return the dataset with selected trials only."""
    return replace(dataset, trials=tuple(filter(wanted, dataset.trials)))


def trunk(recordings: Path, mass: float, first: int = 0, arm: float | None = None) -> Dataset:
    """Return six releases, every second one, with a payload [kg]; ``arm`` replaces the declared mass of the arm [kg]."""
    dataset = chosen(read_dataset(recordings / "real-trunk"), lambda trial: abs(trial.tip_mass - mass) < 0.01)
    return replace(dataset, trials=dataset.trials[first::2][:6], mass=arm or dataset.mass)


def beam(recordings: Path, mass: float) -> Dataset:
    """Return two releases with a payload [kg]."""
    return chosen(read_dataset(recordings / "real-beam"), lambda trial: abs(trial.tip_mass - mass) < 0.001)


def day(recordings: Path, number: int) -> Dataset:
    """Return three trials that repeat one command on one day: Jan 10-3, 10-4 or 10-5."""
    dataset = read_dataset(recordings / "real-pneumatic")
    return replace(dataset, trials=dataset.trials[3 * number - 9 : 3 * number - 6])


#: Change, later dataset, earlier dataset, and time after a release from which samples are used [s]; before, a hand may still
#: touch the trunk.
Case = tuple[str, Callable[[Path], Dataset], Callable[[Path], Dataset], float]
CASES: dict[str, Case] = {
    "trunk": ("300 g declared as 200 g", lambda at: declare_payload(trunk(at, 0.3), 0.1), partial(trunk, mass=0.2), 0.1),
    "trunk-lighter": (
        "the same, the arm 0.3 kg in place of the 0.5 kg that are a guess",
        lambda at: declare_payload(trunk(at, 0.3, arm=0.3), 0.1),
        partial(trunk, mass=0.2, arm=0.3),
        0.1,
    ),
    "trunk-same": ("nothing, other releases", partial(trunk, mass=0.2, first=1), partial(trunk, mass=0.2), 0.1),
    "beam": ("52 g not declared", lambda at: declare_payload(beam(at, 0.052), 0.052), partial(beam, mass=0.0), 0.0),
    "pneumatic-same": ("nothing, another day", partial(day, number=5), partial(day, number=4), 0.0),
    "pneumatic-late": ("seen 60 ms late", lambda at: delay_motion(day(at, 5), 0.06), partial(day, number=4), 0.0),
    "pneumatic-markers": ("markers moved by 5 mm", lambda at: move_markers(day(at, 5), 0.005), partial(day, number=4), 0.0),
    "pneumatic-frame": (
        "frame turned by 3 degrees",
        lambda at: turn_frame(day(at, 5), np.deg2rad(3)),
        partial(day, number=4),
        0.0,
    ),
}


def main(arguments: Sequence[str]) -> int:
    """Diagnose the named changes, or all of them, and return the exit code."""
    recordings, *names = arguments
    for name in names or CASES:
        done, new, old, delay = CASES[name]
        verdict = diagnose_change(new(Path(recordings)), old(Path(recordings)), delay=delay, jobs=1).verdict
        print(f"{name} ({done}): {verdict.status}. {verdict.sentence}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
