"""Growth of run time and memory of one arm with its number of links, at an error of 0.1 mm.

Models and MuJoCo's workspace are set up beforehand. Beyond 64 links, where 1 s takes MuJoCo minutes, ten of its steps are timed,
and the number of steps is assumed to be that for 64 links. Memory is what a separate process takes in addition to that for four
links. Its growth is measured for a hundred arms, because that of one arm is too small, and for Pinocchio's workspace with half as
many links.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from exact import exact_motion
from ours import TOLERANCES, tolerant
from problem import DURATION, SAMPLE, tip_error
from rows import Row, Title, seconds
from search import SUBSTEPS, cheapest, medians

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

LINKS = (4, 16, 64, 256, 500)
ERROR = 0.1  # [mm]
_WHOLE, _FEW = 64, 10
#: Links of an arm whose memory is measured; and where the measurement is quick.
_LARGE, _SMALL = 250, 50
#: Arms whose memory is followed over their links, the links, and those of Pinocchio's workspace.
_ARMS, _OURS, _THEIRS = 100, (125, 250, 500), (125, 250)
_MEMORY = """
from pathlib import Path
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import step_scenario

def status(name):
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith(name)).split()[1]) / 1024  # [MB]; Linux counts in kB

def ours(links):
    simulate_batch([step_scenario(ArmSpecification(links=links), 1.0, rest=0.0, duration=1.0, step=0.02)] * {arms})

def theirs(links):
    build_model(ArmSpecification(links=links)).model.createData()

{who}(4)
Path("/proc/self/clear_refs").write_text("5")  # the peak so far, of loading and compiling, is forgotten
before = status("VmRSS")
{who}({links})
print(status("VmHWM") - before)
"""


def titles() -> list[Title]:
    """Return the lines of this measurement: first the larger arms, then the exponent."""
    tasks = [f"1 s of the step to {ERROR:g} mm, N = {links}" for links in LINKS[2:]]
    tasks.append(f"growth of that from N = {LINKS[0]} to {LINKS[-1]} (ours at most N^1.1)")
    return [*(Title(task, "MuJoCo", "mujoco") for task in tasks), _memory_title(_LARGE), _GROWTH]


_GROWTH = Title(
    f"memory for 1 s of the step of {_ARMS} arms, N = {_OURS[-1]}, and its growth from N = {_OURS[0]} (ours at most N^1.1)",
    f"`pin.Data`, by itself, N = {_THEIRS[-1]}, from N = {_THEIRS[0]}",
)


def _memory_title(links: int) -> Title:
    return Title(f"memory for 1 s of the step, N = {links}", "`pin.Data`, by itself")


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: those up to 64 links."""
    *single, last, _, _ = titles()
    wanted = dict(zip(LINKS[2:], single, strict=True))
    chosen = (LINKS[0], _WHOLE) if quick else LINKS
    ours, theirs = [], []
    steps = 0  # of MuJoCo, per sample
    for links in chosen:
        runs, share = {"ours": _ours(links)}, 1.0
        if last.installed:
            from peer_mujoco import MujocoChain

            steps = _steps(links) if links <= _WHOLE else steps
            chain = MujocoChain(ArmSpecification(links=links), "Euler", steps)
            runs["theirs"] = chain.run if links <= _WHOLE else partial(chain.advance, _FEW)
            share = 1.0 if links <= _WHOLE else steps * DURATION / SAMPLE / _FEW
        times = medians(runs, 11, 8.0)
        ours.append(times["ours"])
        theirs.append(share * times.get("theirs", np.nan))
        if links in wanted:
            yield _row(wanted[links], (ours[-1], theirs[-1]), seconds)
    yield _row(last, [_exponent(chosen, cost) for cost in (ours, theirs)], lambda exponent: f"N^{exponent:.2f}")
    size = _SMALL if quick else _LARGE
    memory = [_memory(who, size) for who in ("ours", "theirs")]
    yield Row(_memory_title(size), *(f"{value:.3g} MB" for value in memory), memory[1] / memory[0])
    if not quick:
        yield _memory_growth()


def _memory_growth() -> Row:
    ours = [_memory("ours", links, _ARMS) for links in _OURS]
    theirs = [_memory("theirs", links) for links in _THEIRS]
    powers = _exponent(_OURS, ours), _exponent(_THEIRS, theirs)
    told = [f"{memory[-1]:.3g} MB, N^{power:.2f}" for memory, power in zip((ours, theirs), powers, strict=True)]
    return Row(_GROWTH, *told, powers[1] / powers[0])


def _memory(who: str, links: int, arms: int = 1) -> float:
    """Return the memory [MB] that a simulation or a workspace needs; at least 0.1 MB, because less cannot be measured."""
    code = _MEMORY.format(who=who, links=links, arms=arms)
    told = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=True).stdout
    return max(0.1, float(told))


def _ours(links: int) -> Callable[[], object]:
    """Return the simulation by hsr_pin with order 4 throughout, at the largest accurate tolerance."""
    solver = cheapest([partial(tolerant, [ArmSpecification(links=links)], "extrapolated4")], TOLERANCES, _accurate(links))
    assert solver is not None
    return solver.run


def _steps(links: int) -> int:
    """Return the number of steps per sample at which MuJoCo's Euler, its cheapest method for this accuracy, is accurate."""
    from peer_mujoco import MujocoChain

    solver = cheapest([partial(MujocoChain, ArmSpecification(links=links), "Euler")], SUBSTEPS, _accurate(links))
    assert isinstance(solver, MujocoChain)
    return solver.substeps


def _accurate(links: int) -> Callable[[Array], bool]:
    arm, exact = ArmSpecification(links=links), exact_motion(links)
    return lambda angles: tip_error([arm], angles, exact) <= ERROR


def _exponent(links: Sequence[int], cost: Sequence[float]) -> float:
    """Return the slope of cost over links on log-log axes."""
    return float(np.polyfit(np.log(links), np.log(cost), 1)[0])


def _row(title: Title, values: Sequence[float], words: Callable[[float], str]) -> Row:
    ours, theirs = values
    return Row(title, words(ours), words(theirs), theirs / ours) if title.installed else Row(title, words(ours))
