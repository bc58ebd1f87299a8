"""Run times of whole commands on two cores, compared with their targets and with the same fit by MuJoCo and SciPy.

Commands are measured as processes, from start to end, on recordings in the folder ``shared`` next to the repository. The blind
cases are newly made (none is of an opened check), and their rate is that of ``hsr-blind run``.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from rows import Row, Title, seconds
from search import medians

from hsr_pin.trajectory import Dataset

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "recordings"
#: Recordings and the time [s] in which they should be diagnosed.
ASKED = {"sample-steps": 6.0, "sample-rich-dirty": 20.0, "real-trunk": 20.0, "real-pneumatic": 60.0}
#: The time [s] in which the first of them should be fitted.
ASKED_FIT = 1.5
#: Cases of a blind check, the time in which so many should be diagnosed [s], and how many are (seed: none of a sealed check's).
ALL, ASKED_ALL, SOME, _SEED = 200, 2400.0, 20, 1_000_003
_ASKED = "what is asked"
_FITTED, *_ = ASKED
#: So many processes, and medians of so many runs.
_CORES, _RUNS = 2, 3


def absent() -> str:
    """Return why no recordings can be measured; empty if they can."""
    return "" if FOLDER.is_dir() else "the folder `shared` with the recordings is not beside the repository"


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    diagnoses = [Title(f"`hsr-diagnose {name}` as a process, {_CORES} cores", _ASKED, reach=1) for name in ASKED]
    fit = f"`hsr-fit {_FITTED}` as a process"
    cases = f"{ALL} blind cases diagnosed, {_CORES} cores (told from {SOME})"
    beside = Title(fit, "MuJoCo and SciPy, after imports, models set up", "mujoco")
    return [*diagnoses, Title(fit, _ASKED, reach=1), beside, Title(cases, _ASKED, reach=1)]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines, without those whose recordings or engines are absent; quick: the fit and one blind case."""
    *diagnoses, asked, beside, cases = titles()
    if absent():
        print(f"diagnosis: {absent()}", file=sys.stderr)
    else:
        for title, (name, limit) in zip(diagnoses, ASKED.items(), strict=True):
            if not quick:
                yield _beside_asked(title, _median(_command("diagnose", FOLDER / name, "--jobs", _CORES), _RUNS), limit)
        yield from _fits(asked, beside, 1 if quick else _RUNS)
    if missing := [module for module in ("mujoco", "elastica") if find_spec(module) is None]:
        print(f"diagnosis: no blind cases without {' and '.join(missing)}", file=sys.stderr)
    else:
        yield _beside_asked(cases, _cases(1 if quick else SOME), ASKED_ALL)


def _fits(asked: Title, beside: Title, runs: int) -> Iterator[Row]:
    ours = _median(_command("fit", FOLDER / _FITTED), runs)
    yield _beside_asked(asked, ours, ASKED_FIT)
    if not beside.installed:
        yield Row(beside, seconds(ours))
        return
    from peer_fit import cheapest_fit

    from hsr_pin.identification.experiment import prepare

    peer = cheapest_fit(prepare(recordings()))
    theirs = _median(peer.run, runs)
    yield Row(beside, seconds(ours), f"{seconds(theirs)} ({peer.setting})", theirs / ours)


def recordings() -> Dataset:
    """Return the recordings that are fitted."""
    from hsr_pin.recordings.read import read_dataset

    return read_dataset(FOLDER / _FITTED)


def _median(run: Callable[[], object], repeats: int) -> float:
    return medians({"it": run}, repeats, 600.0)["it"]


def _beside_asked(title: Title, ours: float, asked: float) -> Row:
    return Row(title, _long(ours), _long(asked), asked / ours)


def _long(time: float) -> str:
    return f"{time / 60:.3g} min" if time >= 600 else seconds(time)


def _command(name: str, *words: object) -> partial[object]:
    """Return a function that runs a command to its end and discards its output."""
    program = Path(sys.executable).with_name(f"hsr-{name}")
    return partial(subprocess.run, [*map(str, (program, *words))], stdout=subprocess.DEVNULL, check=True)


def _cases(count: int) -> float:
    """Return the time to diagnose all blind cases [s], extrapolated from a number of cases."""
    with TemporaryDirectory() as folder:
        check = Path(folder) / "check"
        tiers = ["--tier", "clean=1"] if count == 1 else ["--cases", count]
        _command("blind", "make", "--seed", _SEED, *tiers, "--jobs", _CORES, "-o", check)()
        begin = perf_counter()
        _command("blind", "run", check, "--jobs", _CORES)()
        return (perf_counter() - begin) * ALL / count
