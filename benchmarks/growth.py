"""How the cost of one arm grows with its links, at 0.1 mm.

Models, Pinocchio's workspace (N^3 memory: 4 GB at 500 links) and MuJoCo's are set up beforehand. Beyond 64 links, where 1 s takes
MuJoCo minutes, ten of its steps are timed, and it is charged as many as it needs at 64 links.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from problem import DURATION, SAMPLE, exact_motion, tip_error
from rows import Row, Title, seconds
from search import SUBSTEPS, cheapest, medians

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

LINKS = (4, 16, 64, 256, 500)
ERROR = 0.1  # [mm]
_WHOLE, _FEW = 64, 10


def titles() -> list[Title]:
    """The lines: the larger arms, then the exponent."""
    tasks = [f"1 s of the step to {ERROR:g} mm, N = {links}" for links in LINKS[2:]]
    tasks.append(f"growth of that from N = {LINKS[0]} to {LINKS[-1]} (ours at most N^1.1)")
    return [Title(task, "MuJoCo", "mujoco") for task in tasks]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the lines; quick: the exponent up to 16 links."""
    *single, last = titles()
    wanted = dict(zip(LINKS[2:], single, strict=True))
    chosen = LINKS[:2] if quick else LINKS
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
        times = medians(runs, 3 if quick else 11, 8.0)
        ours.append(times["ours"])
        theirs.append(share * times.get("theirs", np.nan))
        if links in wanted:
            yield _row(wanted[links], (ours[-1], theirs[-1]), seconds)
    yield _row(last, [_exponent(chosen, cost) for cost in (ours, theirs)], lambda exponent: f"N^{exponent:.2f}")


def _ours(links: int) -> Callable[[], object]:
    """Order 4 throughout, at the largest step that is accurate."""
    from ours import Ours

    solver = cheapest([partial(Ours, [ArmSpecification(links=links)], "extrapolated4")], SUBSTEPS, _accurate(links))
    assert solver is not None
    return solver.run


def _steps(links: int) -> int:
    """Steps per sample with which MuJoCo's Euler, its cheapest method at this accuracy, is accurate."""
    from peer_mujoco import MujocoChain

    solver = cheapest([partial(MujocoChain, ArmSpecification(links=links), "Euler")], SUBSTEPS, _accurate(links))
    assert isinstance(solver, MujocoChain)
    return solver.substeps


def _accurate(links: int) -> Callable[[Array], bool]:
    arm, exact = ArmSpecification(links=links), exact_motion(links)
    return lambda angles: tip_error([arm], angles, exact) <= ERROR


def _exponent(links: Sequence[int], cost: Sequence[float]) -> float:
    """Slope on log-log axes."""
    return float(np.polyfit(np.log(links), np.log(cost), 1)[0])


def _row(title: Title, values: Sequence[float], words: Callable[[float], str]) -> Row:
    ours, theirs = values
    return Row(title, words(ours), words(theirs), theirs / ours) if title.installed else Row(title, words(ours))
