"""Two rods in space, compared with their published solutions and with the chain that was published with them.

The reference is a Cosserat rod solved by SoroSim. Errors are the mean distance of the tip from it, in % of the rod's length, over
all shapes at rest, and over 10 s of the releases. The peer is a chain in MuJoCo, whose authors publish its errors and its speed
on their machine; it is not run here.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter

import numpy as np
from rows import Row, Title
from sorosim import FOLDER, RODS, Case, Rod, releases, shapes

from hsr_pin.robot.specification import Placement
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.result import SimulationResult

#: By rod: elements of the peer at rest, and the error that it prints [%]; then what it prints of releases, with 25.
_AT_REST = {"steel": {25: 0.67, 50: 0.19, 100: 0.098}, "TPU": {25: 0.68, 50: 0.20, 100: 0.105}}
_RELEASED = {"steel": 0.39, "TPU": 0.78}
#: Times real time, with 25 elements.
_SPEED = 47.0
#: What is asked at most [%], by our elements.
ASKED_AT_REST = {10: 0.2, 20: 0.06}
ASKED_RELEASED = {"steel": 0.4, "TPU": 0.5}
#: Beside each of ours at rest, the peer's elements.
_BESIDE = {10: 25, 20: 50}
FAST = 25
#: Placements and elements of ours.
_CHAINS = (("shifted", 10), ("shifted", 20), ("mid", 10), ("mid", 20))
_RELEASES = (("shifted", 10), ("shifted", FAST), ("mid", 10), ("mid", FAST))
_WORDS = {"shifted": "", "mid": ", every joint in the middle of its element"}
#: For all releases: they ring, but not for ever.
_METHOD = {"integrator": "extrapolated4", "tolerance": 1e-4}
#: Turns in which releases are timed.
_TURNS = 5


def absent() -> str:
    """Return why nothing can be measured; empty if it can."""
    return "" if FOLDER.is_dir() else "the folder `shared` with the published solutions is not beside the repository"


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    found = []
    for name in RODS:
        for placement, links in _CHAINS:
            reach = round(_AT_REST[name][_BESIDE[links]] / ASKED_AT_REST[links], 2)
            task = f"{name} rod in space, 250 shapes at rest: mean tip error, N = {links}{_WORDS[placement]}"
            found.append(Title(task, _peer(_BESIDE[links]), reach=reach))
        for placement, links in _RELEASES:
            reach = round(_RELEASED[name] / ASKED_RELEASED[name], 2) if links == 10 else None
            task = f"{name} rod in space, releases of 10 s: mean tip error, N = {links}{_WORDS[placement]}"
            found.append(Title(task, _peer(25), reach=reach))
        found.append(Title(f"{name} rod in space, releases: speed of a whole call, N = {FAST}", _peer(25), reach=1))
    return found


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: a few shapes and one release."""
    if reason := absent():
        yield from (Row(title, reason) for title in titles())
        return
    lines = iter(titles())
    for name, rod in RODS.items():
        for placement, links in _CHAINS:
            ours = tip_error_at_rest(rod, links, placement, 5 if quick else None)
            theirs = _AT_REST[name][_BESIDE[links]]
            yield Row(next(lines), f"{ours:.2g} %", f"{theirs:g} %", theirs / ours)
        for placement, links in _RELEASES:
            ours = tip_error_released(rod, links, placement, 1 if quick else None)
            yield Row(next(lines), f"{ours:.2g} %", f"{_RELEASED[name]:g} %", _RELEASED[name] / ours)
        speed = times_real_time(rod, FAST, 1 if quick else None)
        yield Row(next(lines), f"{speed:.0f} times real time", f"{_SPEED:g} times (its makers' machine)", speed / _SPEED)


def tip_error_at_rest(rod: Rod, links: int, placement: Placement = "shifted", count: int | None = None) -> float:
    """Return the mean tip error over the shapes [% of the length]; a shape that is not found counts as infinite."""
    cases = shapes(rod)[:count]
    results = simulate_batch([case.scenario(rod, links, placement) for case in cases])
    return float(np.mean([_tip_error(rod, case, result) for case, result in zip(cases, results, strict=True)]))


def tip_error_released(rod: Rod, links: int, placement: Placement = "shifted", count: int | None = None) -> float:
    """Return the mean tip error over all samples of all releases [% of the length]."""
    cases = releases(rod)[:count]
    results = simulate_batch([case.scenario(rod, links, placement) for case in cases], **_METHOD)
    return float(np.mean([_tip_error(rod, case, result) for case, result in zip(cases, results, strict=True)]))


def times_real_time(rod: Rod, links: int, count: int | None = None) -> float:
    """Return simulated time over median run time of calls that simulate one release each, including poses and markers."""
    cases = releases(rod)[:count]
    scenarios = [case.scenario(rod, links) for case in cases]
    times = []
    for _ in range(_TURNS):
        begin = perf_counter()
        for scenario in scenarios:
            simulate_batch([scenario], **_METHOD)
        times.append(perf_counter() - begin)
    return float(sum(case.time[-1] for case in cases) / np.median(times))


def _tip_error(rod: Rod, case: Case, result: SimulationResult) -> float:
    return float(case.errors(rod, result.trajectory.positions)[:, 1].mean()) if result.completed else float("inf")


def _peer(links: int) -> str:
    return f"published chain in MuJoCo, N = {links}"
