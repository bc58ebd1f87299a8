"""What has changed between recordings of real arms, where it is known: payloads not declared, sessions repeated, files edited.

    python scripts/real_changes.py [NAME ...]

Reads ../shared/recordings; takes minutes. One line for each: what was done, what was said.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import numpy as np

from hsr_pin import Dataset, diagnose_change, read_dataset
from hsr_pin.blind.real.edits import declare_payload, delay_motion, move_markers, turn_frame
from hsr_pin.trajectory import Trial

RECORDINGS = Path(__file__).resolve().parents[2] / "shared" / "recordings"
#: A hand may still touch the trunk for so long after its release [s].
TOUCHED = {"delay": 0.1}


def numbered(name: str, numbers: Sequence[int]) -> Dataset:
    """Some trials of a recording, by number."""
    return chosen(name, lambda trial: int(trial.name[-2:]) in numbers)


def chosen(name: str, wanted: Callable[[Trial], bool]) -> Dataset:
    """Some trials of a recording."""
    dataset = read_dataset(RECORDINGS / name)
    return replace(dataset, trials=tuple(filter(wanted, dataset.trials)))


def trunk(heavy: bool) -> Dataset:
    """Six releases with 300 g, or with 200 g."""
    dataset = chosen("real-trunk", lambda trial: (trial.tip_mass > 0.25) == heavy)
    return replace(dataset, trials=dataset.trials[::2][:6])


def session(number: int) -> Dataset:
    """Three trials of one day that repeat one command: Jan 10-3, 10-4 or 10-5."""
    return numbered("real-pneumatic", range(3 * number - 8, 3 * number - 5))


CASES: dict[str, tuple[str, Callable[[], tuple[Dataset, Dataset]], dict[str, float]]] = {
    "trunk": ("300 g declared as 200 g", lambda: (declare_payload(trunk(True), 0.1), trunk(False)), TOUCHED),
    "trunk-same": ("nothing, other releases", lambda: (_other_releases(), trunk(False)), TOUCHED),
    "beam": (
        "52 g not declared",
        lambda: (declare_payload(numbered("real-beam", (3, 4)), 0.052), numbered("real-beam", (1, 2))),
        {},
    ),
    "pneumatic-same": ("nothing, another day", lambda: (session(5), session(4)), {}),
    "pneumatic-late": ("seen 60 ms late", lambda: (delay_motion(session(5), 0.06), session(4)), {}),
    "pneumatic-markers": ("markers moved by 5 mm", lambda: (move_markers(session(5), 0.005), session(4)), {}),
    "pneumatic-frame": ("frame turned by 3 degrees", lambda: (turn_frame(session(5), np.deg2rad(3)), session(4)), {}),
}


def _other_releases() -> Dataset:
    dataset = chosen("real-trunk", lambda trial: trial.tip_mass < 0.25)
    return replace(dataset, trials=dataset.trials[1::2][:6])


def main(names: Sequence[str]) -> int:
    """Entry point."""
    for name in names or CASES:
        done, recorded, how = CASES[name]
        new, old = recorded()
        verdict = diagnose_change(new, old, jobs=1, **how).verdict
        print(f"{name} ({done}): {verdict.status}. {verdict.sentence}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
