"""Write a real pneumatic arm's recordings as those of an arm in space: of two sections, and of one under their mean torque.

    python examples/pneumatic_in_sections.py ../shared/recordings/real-pneumatic pneumatic
    hsr-fit pneumatic/two-sections --free keq,length_change --effect unequal_lag:rise=0.6,fall=2,delay=0.3

The sections' pressures stand beside the recordings, commanded and measured. Chambers A and B of a section bend it towards +x and
-x by what its makers' torque of 0.09 N m/psi makes of their difference; chambers C stay as they are.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from pathlib import Path

GAIN = 0.09 / 0.0689475729  # N m/bar: 0.09 N m/psi
MIDDLE, LENGTH = 0.153, 0.290  # m: the marker between the sections, and the tip's

ROBOT = """format = 2
name = "{name}"

[robot]
length = 0.290
mass = 0.293
diameter = 0.086
mount = "hanging"
bending = "space"
keq = 1.0
damping = 0.1

[[marker]]
name = "base"
arc_length = 0.0

[[marker]]
name = "mid"
arc_length = 0.153

[[marker]]
name = "tip"
arc_length = 0.29
"""
SECTION = """
[[section]]
length = {length:.3f}

[[input]]
section = {section}
columns = ["command{section}A", "command{section}B"]  # opposite to one another, the first towards +x
gain = {gain!r}

[[measured]]
columns = [{others}]
"""


def main(arguments: Sequence[str] | None = None) -> list[Path]:
    """The folders that were written."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", type=Path, help="the folder of real-pneumatic")
    parser.add_argument("output", type=Path, help="a new folder")
    chosen = parser.parse_args(arguments)
    sections = "".join(
        SECTION.format(length=length, section=section, gain=GAIN, others=", ".join(f'"{name}"' for name in _others(section)))
        for section, length in ((1, MIDDLE), (2, LENGTH - MIDDLE))
    )
    written = []
    for name, more in (("one-section", ""), ("two-sections", sections)):
        folder = chosen.output / name
        folder.mkdir(parents=True)
        trials = sorted(chosen.recordings.glob("trial_*.csv"))
        declared = "".join(f'\n[[trial]]\nfile = "{path.name}"\n' for path in trials)
        (folder / "dataset.toml").write_text(ROBOT.format(name=name) + more + declared, encoding="utf-8")
        for path in trials:
            _write(path, folder / path.name, by_section=bool(more))
        written.append(folder)
        print(folder)
    return written


def _others(section: int) -> list[str]:
    return [f"command{section}C", *(f"measured{section}{chamber}" for chamber in "ABC")]


def _write(path: Path, target: Path, *, by_section: bool) -> None:
    with path.open() as motion, (path.parent / "pressures" / path.name).open() as pressures, target.open("w", newline="") as out:
        rows = csv.DictReader(motion)
        places = [name for name in rows.fieldnames or () if name not in ("t", "tau")]
        chambers = [f"command{s}{c}" for s in "12" for c in "AB"] + _others(1) + _others(2)
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["t", *(chambers if by_section else ("tau_x", "tau_y")), *places])
        for row, given in zip(rows, csv.DictReader(pressures), strict=True):
            drive = [given[name] for name in chambers] if by_section else [row["tau"], "0"]
            writer.writerow([row["t"], *drive, *(row[name] for name in places)])


if __name__ == "__main__":
    main()
