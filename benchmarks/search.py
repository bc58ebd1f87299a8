"""For each solver the cheapest of its settings that is accurate, and times taken side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from time import perf_counter
from typing import Any, TypeAlias

import numpy as np
from problem import Solver

from hsr_pin.trajectory import Array

#: Steps per sample, 5 % apart.
SUBSTEPS = tuple(dict.fromkeys(round(1.05**k) for k in range(200)))
#: Tolerances of adaptive solvers.
TOLERANCES = tuple(10.0 ** (-k / 4) for k in range(4, 44))
#: No single run of a search may take longer [s].
PATIENCE = 4.0
#: What a turn of a solver takes at least [s].
TURN = 0.02
_LONGEST_STRIDE = 14  # rungs: half the step
#: Makes a solver from a rung of a ladder of settings.
Make: TypeAlias = Callable[[Any], Solver]


def cheapest(families: Iterable[Make], ladder: Sequence[float], accurate: Callable[[Array], bool]) -> Solver | None:
    """The quickest of the coarsest accurate settings of several families; None if none is accurate within ``PATIENCE``.

    Args:
        families: such as differ in the integrator.
        ladder: from coarse to fine.
        accurate: whether joint angles (T, B, N) are.
    """
    best, quickest = None, PATIENCE
    for make in families:
        solver = _coarsest(make, ladder, accurate, quickest)
        if solver is None:
            continue
        elapsed = min(_seconds(solver.run) for _ in range(3))
        if best is None or elapsed < quickest:
            best, quickest = solver, elapsed
    return best


def medians(runs: Mapping[str, Callable[[], object]], repeats: int = 21, budget: float = 12.0) -> dict[str, float]:
    """Median time [s] of each of several runs, taken in turns: ``repeats`` times, or (at least 3) what ``budget`` [s] allows.

    A turn is as many runs as ``TURN`` [s] holds, at least one, and counts with their mean: single runs of some 0.1 ms would be
    timed in caches that the solver before them has filled.
    """
    times: dict[str, list[float]] = {name: [] for name in runs}
    begin = perf_counter()
    for repeat in range(repeats):
        if repeat >= 3 and perf_counter() - begin > budget:
            break
        for name, run in runs.items():
            times[name].append(_seconds_each(run))
    return {name: float(np.median(taken)) for name, taken in times.items()}


def _coarsest(make: Make, ladder: Sequence[float], accurate: Callable[[Array], bool], limit: float) -> Solver | None:
    """By strides that grow, then by bisection; gives up where a run takes longer than ``limit`` [s]."""
    low, high, stride = -1, 0, 1
    while True:
        solver = make(ladder[high])
        begin = perf_counter()
        angles = solver.run()
        elapsed = perf_counter() - begin
        if accurate(angles):
            break
        if elapsed > limit or high == len(ladder) - 1:
            return None
        low, high, stride = high, min(high + stride, len(ladder) - 1), min(2 * stride, _LONGEST_STRIDE)
    while high - low > 1:
        middle = (low + high) // 2
        trial = make(ladder[middle])
        if accurate(trial.run()):
            high, solver = middle, trial
        else:
            low = middle
    return solver


def _seconds_each(run: Callable[[], object]) -> float:
    """Mean of as many as a turn holds."""
    count, elapsed = 0, 0.0
    while elapsed < TURN:
        elapsed += _seconds(run)
        count += 1
    return elapsed / count


def _seconds(run: Callable[[], object]) -> float:
    begin = perf_counter()
    run()
    return perf_counter() - begin
