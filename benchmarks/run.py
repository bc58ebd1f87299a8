"""Measure hsr_pin and its peers, and write the table that README.md shows.

    python benchmarks/run.py                 everything, into benchmarks/results.md (some 20 minutes on an idle machine)
    python benchmarks/run.py --quick         a small part of everything, printed only
    python benchmarks/run.py --only growth   one measurement, printed only
    python benchmarks/run.py --renew growth  one measurement, in place of its lines in results.md (same day, same machine)
    python benchmarks/run.py --show          print the table that was written last

Then: python scripts/readme.py --only benchmarks. Peers: python3 scripts/install.py bench; absent peers are left out.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from datetime import date
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter

from rows import HEADER, Row

MEASUREMENTS = ("work_precision", "growth", "throughput", "latency", "startup", "diagnosis", "space")
RESULTS = Path(__file__).with_name("results.md")
_LIBRARIES = ("pin", "numpy", "numba", "scipy", "mujoco", "pybullet")


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a little of everything")
    parser.add_argument("--only", choices=MEASUREMENTS, help="one measurement")
    parser.add_argument("--renew", choices=MEASUREMENTS, help="one measurement, into the table")
    parser.add_argument("--show", action="store_true", help="print what was written last")
    chosen = parser.parse_args()
    if chosen.show:
        print(RESULTS.read_text(encoding="utf-8"), end="")
        return
    rows = []
    one = chosen.only or chosen.renew
    for name in [one] if one else MEASUREMENTS:
        begin = perf_counter()
        for row in import_module(name).measure(chosen.quick):
            rows.append(row)
            print(row, end="", file=sys.stderr, flush=True)
        print(f"{name}: {perf_counter() - begin:.0f} s", file=sys.stderr)
    text = renewed(chosen.renew, rows) if chosen.renew else document(rows)
    if chosen.quick or chosen.only:
        print(text, end="")
    else:
        RESULTS.write_text(text, encoding="utf-8")


def document(rows: list[Row]) -> str:
    """Return the table with the conditions of the measurement."""
    return f"{HEADER}{''.join(map(str, rows))}\n{conditions()}\n"


def renewed(name: str, rows: list[Row]) -> str:
    """Return the table that was written last, with the lines of one measurement replaced."""
    table, _, told = RESULTS.read_text(encoding="utf-8").partition("\n\n")
    if told.strip() != conditions():
        raise SystemExit(f"cannot renew {name}: the other lines were measured elsewhere or on another day; run everything")
    lines = {each: [] for each in MEASUREMENTS}
    place = {f"| {title.task} |": each for each in MEASUREMENTS for title in import_module(each).titles()}
    for line in table.splitlines(keepends=True)[2:]:
        lines[place[next(start for start in place if line.startswith(start))]].append(line.rstrip("\n") + "\n")
    lines[name] = [str(row) for row in rows]
    return f"{HEADER}{''.join(line for each in MEASUREMENTS for line in lines[each])}\n{told}"


def conditions() -> str:
    """Return one sentence on method, date, machine and versions of the measurement."""
    libraries = ", ".join(f"{name} {found}" for name in _LIBRARIES if (found := _version(name)))
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    machine = f"{cores} cores ({platform.machine()}), {platform.system()}, Python {platform.python_version()}"
    how = "Medians of runs taken in turns (short ones again and again for 20 ms)"
    return f"{how}, on {date.today():%d %B %Y}: {machine}, {libraries}."


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return ""


if __name__ == "__main__":
    main()
