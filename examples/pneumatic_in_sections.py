"""Describe a real pneumatic arm in three ways: in a plane, in space, and as two sections with their own pressures.

    python examples/pneumatic_in_sections.py ../shared/recordings/real-pneumatic

The recordings contain the commanded and the measured pressures of the sections. Chambers A and B of a section bend it towards +x
and -x: the torque is 0.09 N m/psi times the difference of their pressures, a value of the arm's authors. Chambers C are not used.
Each description is fitted as ``hsr-fit`` does, with two models: stiffness and damping; and stiffness, ``length_change`` and
``unequal_lag``.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hsr_pin.effects import parse_effect
from hsr_pin.identification.identify import identify
from hsr_pin.inference.residuals import rms
from hsr_pin.recordings.read import read_dataset

GAIN = 0.09 / 0.0689475729  # N m/bar: 0.09 N m/psi
MIDDLE, LENGTH = 0.153, 0.290  # m: arc length of the marker between the sections, and of the tip

ROBOT = """format = 2
name = "{name}"

[robot]
length = 0.290
mass = 0.293
diameter = 0.086
mount = "hanging"
bending = "space"
input = "{held}"
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
columns = ["{drive}{section}A", "{drive}{section}B"]  # opposite to one another, the first towards +x
gain = {gain!r}

[[measured]]
columns = [{others}]
"""


#: Fitted models: names of free parameters, and effects.
MODELS = {
    "stiffness, damping": (("keq", "damping"), ()),
    "stiffness, length_change, unequal_lag": (("keq", "length_change"), ("unequal_lag:rise=0.6,fall=2,delay=0.3",)),
}
#: Descriptions of the arm: whether it has sections, and which pressures drive it.
DESCRIPTIONS = {
    "one section": (False, "command"),
    "two sections": (True, "command"),
    "two sections, measured pressures": (True, "measured"),
}


def main(arguments: Sequence[str] | None = None) -> dict[tuple[str, str], float]:
    """Print and return the RMS distance [mm] of trials predicted by a fit to the others, by model and description."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", type=Path, help="the folder of real-pneumatic")
    parser.add_argument("--keep", type=Path, help="a new folder for the descriptions, which hsr-fit and hsr-diagnose can read")
    parser.add_argument("--quick", action="store_true", help="three trials, stiffness and damping alone")
    chosen = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        folders = written(chosen.recordings, chosen.keep or Path(scratch))
        folders = {"in a plane": chosen.recordings, **folders}
        found = {}
        for model, (free, laws) in list(MODELS.items())[: 1 if chosen.quick else 2]:
            print(f"{model:42} fitted   each trial by a fit to the others [mm]")
            for name, folder in folders.items():
                effects, train = [parse_effect(law) for law in laws], ("trial_0[147]",) if chosen.quick else ()
                answer = identify(read_dataset(folder), free=free, effects=effects, train=train, test=train and ("trial_02",))
                found[model, name] = 1e3 * rms(answer.heldout)
                print(f"    {name:38} {1e3 * rms(answer.after):6.2f}   {found[model, name]:6.2f}", flush=True)
    return found


def written(recordings: Path, output: Path) -> dict[str, Path]:
    """Write the descriptions in space as datasets, and return their folders."""
    found = {}
    for name, (by_section, drive) in DESCRIPTIONS.items():
        folder = output / name.replace(",", "").replace(" ", "-")
        folder.mkdir(parents=True)
        sections = "".join(_section(k, length, drive) for k, length in ((1, MIDDLE), (2, LENGTH - MIDDLE)))
        trials = sorted(recordings.glob("trial_*.csv"))
        declared = "".join(f'\n[[trial]]\nfile = "{path.name}"\n' for path in trials)
        robot = ROBOT.format(name=folder.name, held="held" if drive == "command" else "interpolated")
        (folder / "dataset.toml").write_text(robot + sections * by_section + declared, encoding="utf-8")
        for path in trials:
            _write(path, folder / path.name, by_section=by_section)
        found[name] = folder
    return found


def _section(section: int, length: float, drive: str) -> str:
    every = [f"{kind}{section}{chamber}" for kind in ("command", "measured") for chamber in "ABC"]
    others = ", ".join(f'"{name}"' for name in every if name not in (f"{drive}{section}A", f"{drive}{section}B"))
    return SECTION.format(length=length, section=section, gain=GAIN, drive=drive, others=others)


def _write(path: Path, target: Path, *, by_section: bool) -> None:
    """Write the motion of one trial, with the pressures of the sections or else with its torque."""
    with path.open() as motion, (path.parent / "pressures" / path.name).open() as pressures, target.open("w", newline="") as out:
        rows, given = csv.DictReader(motion), csv.DictReader(pressures)
        places = [name for name in rows.fieldnames or () if name not in ("t", "tau")]
        chambers = [name for name in given.fieldnames or () if name != "t"]
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["t", *(chambers if by_section else ("tau_x", "tau_y")), *places])
        for row, pressure in zip(rows, given, strict=True):
            drive = [pressure[name] for name in chambers] if by_section else [row["tau"], "0"]
            writer.writerow([row["t"], *drive, *(row[name] for name in places)])


if __name__ == "__main__":
    main()
