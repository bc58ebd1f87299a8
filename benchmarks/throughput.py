"""Time to simulate 1 s of a thousand different arms on two cores.

Both simulators use two threads, and their models are set up beforehand. hsr_pin takes separate steps for every arm. Both use one
setting for all arms, the cheapest that is accurate for the extreme arms. MuJoCo's time is proportional to the number of arms, and
is measured on every twentieth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from exact import FINE
from ours import METHODS, TOLERANCES, Ours, tolerant
from problem import Solver, tip_error
from rows import Row, Title, seconds
from search import SUBSTEPS, cheapest, medians

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

CORES = 2
ARMS, LINKS = 1000, 4
ERRORS = (0.1, 0.01)  # [mm]
_SHARE = 20  # MuJoCo is timed on one arm in twenty
_NOMINAL = ArmSpecification(links=LINKS)
#: What may differ, and by how much from the nominal arm's.
_SPREAD = {"keq": 0.2, "damping": 0.2, "mass": 0.1, "length": 0.1}
_WORDS = {"keq": "stiffness"}


@dataclass(frozen=True)
class Fleet:
    """Arms that differ in some of their parameters."""

    numbers: tuple[str, ...]
    reach: float | None = None

    def title(self, error: float, count: int = ARMS) -> Title:
        """Return the line for an error [mm]."""
        *most, last = (_WORDS.get(name, name) for name in self.numbers)
        words = f"{', '.join(most)} and {last}"
        task = f"1 s of {count:,} arms that differ in {words} to {error:g} mm, N = {LINKS}, {CORES} cores"
        return Title(task, "mujoco.rollout", "mujoco", self.reach)

    def arms(self, count: int) -> list[ArmSpecification]:
        """Return arms with uniformly distributed parameters, the same at every call."""
        return self._arms(np.random.default_rng(4).uniform(-1, 1, (count, len(self.numbers))))

    def extremes(self) -> list[ArmSpecification]:
        """Return the arms at the corners of the parameter range."""
        return self._arms(np.array(list(product((-1.0, 1.0), repeat=len(self.numbers)))))

    def _arms(self, draws: Array) -> list[ArmSpecification]:
        factors = 1 + draws * [_SPREAD[name] for name in self.numbers]
        values = factors * [getattr(_NOMINAL, name) for name in self.numbers]
        return [replace(_NOMINAL, **dict(zip(self.numbers, row, strict=True))) for row in values.tolist()]


FLEETS = (Fleet(("keq", "damping"), reach=60.0), Fleet(("keq", "damping", "mass", "length"), reach=60.0))


def titles() -> list[Title]:
    """Return the lines of this measurement."""
    return [fleet.title(error) for fleet in FLEETS for error in ERRORS]


def measure(quick: bool) -> Iterator[Row]:
    """Yield the measured lines; quick: one of them, with 40 arms."""
    count = 40 if quick else ARMS
    for fleet in FLEETS[:1] if quick else FLEETS:
        for error in ERRORS[:1] if quick else ERRORS:
            yield _measured(fleet, error, fleet.arms(count))


def _measured(fleet: Fleet, error: float, arms: list[ArmSpecification]) -> Row:
    title, extremes = fleet.title(error, len(arms)), fleet.extremes()
    exact = Ours(extremes, FINE).run()

    def accurate(angles: Array) -> bool:
        return tip_error(extremes, angles[:, : len(extremes)], exact) <= error

    crowd = extremes + arms[:100]  # enough that what is cheapest for them is cheapest for all
    best = cheapest([partial(tolerant, crowd, method) for method in METHODS], TOLERANCES, accurate)
    assert isinstance(best, Ours)
    runs = {"ours": Ours(arms, best.method, threads=CORES).run}
    if title.installed:
        theirs = _rollout(extremes, arms[::_SHARE], accurate)
        runs["theirs"] = theirs.run
    times = medians(runs, 5)
    own = f"{seconds(times['ours'])} ({best.setting})"
    if not title.installed:
        return Row(title, own)
    taken = times["theirs"] * _SHARE
    return Row(title, own, f"{seconds(taken)} ({theirs.setting})", taken / times["ours"])


def _rollout(extremes: list[ArmSpecification], arms: list[ArmSpecification], accurate: Callable[[Array], bool]) -> Solver:
    """Return MuJoCo's cheapest accurate setting for these arms."""
    from peer_mujoco import METHODS, MujocoRollout

    best = cheapest([partial(MujocoRollout, extremes, CORES, method) for method in METHODS], SUBSTEPS, accurate)
    assert isinstance(best, MujocoRollout)
    return MujocoRollout(arms, CORES, best.method, best.substeps)
