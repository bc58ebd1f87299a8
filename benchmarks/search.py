"""Search for the cheapest accurate setting of each solver, and measurement of run times in turns."""

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
    """Return the fastest of the coarsest accurate settings of several families; None if none is accurate within ``PATIENCE``.

    Args:
        families: functions that make a solver from a setting, such as one for each integrator.
        ladder: settings from coarse to fine.
        accurate: function that returns whether joint angles (T, B, N) are accurate.
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
    """Return the median time [s] of each of several runs, measured in turns.

    There are ``repeats`` turns, or as many as ``budget`` [s] allows, but at least 3. A turn contains as many runs as ``TURN`` [s]
    allows, at least one, and counts with their mean. Single runs of some 0.1 ms would depend on the caches that the solver before
    them has filled.
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
    """Return the coarsest accurate solver, by growing strides and bisection; None if a run takes longer than ``limit`` [s]."""
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
    """Return the mean time [s] of the runs in one turn."""
    count, elapsed = 0, 0.0
    while elapsed < TURN:
        elapsed += _seconds(run)
        count += 1
    return elapsed / count


def _seconds(run: Callable[[], object]) -> float:
    begin = perf_counter()
    run()
    return perf_counter() - begin
