"""Run time of a whole `hsr-sim` process, compared with a process that only imports Pinocchio."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from functools import partial

from rows import Row, Title, seconds
from search import medians

_OURS = [sys.executable, "-m", "hsr_pin.cli.sim", "--links", "4", "--keq", "1.11"]
_PEER = [sys.executable, "-c", "import pinocchio"]


def titles() -> list[Title]:
    """Return the line of this measurement."""
    return [Title("`hsr-sim --links 4 --keq 1.11` as a process", "`import pinocchio` as a process", reach=0.25)]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured line."""
    run = partial(subprocess.run, stdout=subprocess.DEVNULL, check=True)
    times = medians({"ours": partial(run, _OURS), "theirs": partial(run, _PEER)}, 1 if quick else 11)
    (title,) = titles()
    yield Row(title, seconds(times["ours"]), seconds(times["theirs"]), times["theirs"] / times["ours"])
