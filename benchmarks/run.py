"""Measure hsr_pin beside its peers, and write the table that README.md shows.

    python benchmarks/run.py                 everything, into benchmarks/results.md (about 6 minutes on an idle machine)
    python benchmarks/run.py --quick         a little of everything, printed only
    python benchmarks/run.py --only growth   one measurement, printed only
    python benchmarks/run.py --show          print what was written last

Then: python scripts/readme.py --only benchmarks. Peers: python3 scripts/install.py bench; those that are absent are left out.
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

MEASUREMENTS = ("work_precision", "growth", "throughput", "latency", "startup")
RESULTS = Path(__file__).with_name("results.md")
_LIBRARIES = ("pin", "numpy", "numba", "scipy", "mujoco", "pybullet")


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a little of everything")
    parser.add_argument("--only", choices=MEASUREMENTS, help="one measurement")
    parser.add_argument("--show", action="store_true", help="print what was written last")
    chosen = parser.parse_args()
    if chosen.show:
        print(RESULTS.read_text(encoding="utf-8"), end="")
        return
    rows = []
    for name in [chosen.only] if chosen.only else MEASUREMENTS:
        begin = perf_counter()
        for row in import_module(name).measure(chosen.quick):
            rows.append(row)
            print(row, end="", file=sys.stderr, flush=True)
        print(f"{name}: {perf_counter() - begin:.0f} s", file=sys.stderr)
    text = document(rows)
    if chosen.quick or chosen.only:
        print(text, end="")
    else:
        RESULTS.write_text(text, encoding="utf-8")


def document(rows: list[Row]) -> str:
    """The table, and where and with what it was measured."""
    return f"{HEADER}{''.join(map(str, rows))}\n{conditions()}\n"


def conditions() -> str:
    """One sentence."""
    libraries = ", ".join(f"{name} {found}" for name in _LIBRARIES if (found := _version(name)))
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    machine = f"{cores} cores ({platform.machine()}), {platform.system()}, Python {platform.python_version()}"
    return f"Medians of runs taken in turns, on {date.today():%d %B %Y}: {machine}, {libraries}."


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return ""


if __name__ == "__main__":
    main()
