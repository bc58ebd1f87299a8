"""What a command is made of: stretches in which it is held, and the steps between them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from hsr_pin.identification.experiment import Run
from hsr_pin.trajectory import Array

#: A command is held while it changes by less than this share of its largest size, for at least so long [s] and so many samples.
_HELD, _LEAST, _FEWEST = 0.01, 0.2, 5


@dataclass(frozen=True)
class Plateau:
    """A stretch in which the command is held.

    Attributes:
        first, last: its samples.
        torque: [N m]; in space complex.
    """

    first: int
    last: int
    torque: Any


@dataclass(frozen=True)
class Step:
    """From one plateau to the next.

    Attributes:
        before, after: the plateaus.
        instant: [s] at which a step at once would have brought as much command as was given: what flickers in between is
            averaged.
    """

    before: Plateau
    after: Plateau
    instant: float

    @property
    def size(self) -> Any:
        """[N m], signed; in space complex."""
        return self.after.torque - self.before.torque


def plateaus(run: Run) -> tuple[Plateau, ...]:
    """Where the command of a run is held, in order; a run without input holds it throughout."""
    size = _HELD * max(float(np.max(np.abs(run.torque))), 1e-12)
    breaks = np.flatnonzero(np.abs(np.diff(run.torque)) > size) + 1
    bounds = [0, *breaks.tolist(), len(run.torque)]
    found = []
    for first, end in pairwise(bounds):
        long = end - first >= _FEWEST and (end - first) * run.step >= _LEAST
        settled = first == 0 and run.start_pose is None
        if (long or settled) and _spread(run.torque[first:end]) <= 2 * size:
            found.append(Plateau(first, end - 1, _middle(run.torque[first:end])))
    return tuple(_merged(found, size))


def _spread(torque: Array) -> float:
    return float(np.hypot(np.ptp(torque.real), np.ptp(torque.imag)))


def _middle(torque: Array) -> Any:
    middle = float(np.median(torque.real))
    return complex(middle, float(np.median(torque.imag))) if np.iscomplexobj(torque) else middle


def _merged(found: list[Plateau], size: float) -> list[Plateau]:
    """Plateaus at the same command that nothing but a flicker parts are one."""
    merged: list[Plateau] = []
    for plateau in found:
        if merged and abs(merged[-1].torque - plateau.torque) <= size:
            merged[-1] = Plateau(merged[-1].first, plateau.last, merged[-1].torque)
        else:
            merged.append(plateau)
    return merged


def steps(run: Run) -> tuple[Step, ...]:
    """The steps between plateaus of a run: what lies between must be shorter than a plateau."""
    held = plateaus(run)
    found = []
    for before, after in pairwise(held):
        between = run.torque[before.last + 1 : after.first]
        if len(between) * run.step >= max(_LEAST, _FEWEST * run.step):
            continue
        given = float(np.real(np.sum(between - before.torque) * run.step / (after.torque - before.torque)))
        instant = float(run.time[after.first]) - float(np.clip(given, 0.0, len(between) * run.step))
        found.append(Step(before, after, instant))
    return tuple(found)
