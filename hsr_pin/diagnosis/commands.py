"""Plateaus of a command, and the steps between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

#: A command is constant while it changes by less than this share of its largest size, for at least this time [s] and number of
#: samples.
_HELD, _LEAST, _FEWEST = 0.01, 0.2, 5


@dataclass(frozen=True)
class Plateau:
    """A period in which the command is constant.

    Attributes:
        first, last: indices of its first and last sample.
        torque: commanded torque [N m]; complex for an arm in space; the mean along an arm of sections.
        command: (S,) command of each section.
    """

    first: int
    last: int
    torque: Any
    command: Array


@dataclass(frozen=True)
class Step:
    """A step of the command from one plateau to the next.

    Attributes:
        before, after: the plateaus.
        instant: equivalent time of the step [s]: an ideal step at this time has the same integral as the recorded transition.
    """

    before: Plateau
    after: Plateau
    instant: float

    @property
    def size(self) -> Any:
        """Signed size of the step [N m]; complex for an arm in space."""
        return self.after.torque - self.before.torque


def plateaus(run: Run) -> tuple[Plateau, ...]:
    """Return the plateaus of a run in order; a run without input is one plateau."""
    size = _HELD * max(float(np.max(np.abs(run.command))), 1e-12)
    breaks = np.flatnonzero((np.abs(np.diff(run.command, axis=0)) > size).any(axis=1)) + 1
    bounds = [0, *breaks.tolist(), len(run.torque)]
    found = []
    for first, end in pairwise(bounds):
        long = end - first >= _FEWEST and (end - first) * run.step >= _LEAST
        settled = first == 0 and run.start_pose is None
        if (long or settled) and _spread(run.command[first:end]) <= 2 * size:
            middle = _middle(run.command[first:end])
            found.append(Plateau(first, end - 1, _middle(run.torque[first:end, None])[0], middle))
    return tuple(_merged(found, size))


def _spread(command: Array) -> float:
    """Return the largest spread of the command (T, S) of any section."""
    return float(np.hypot(np.ptp(command.real, axis=0), np.ptp(command.imag, axis=0)).max())


def _middle(command: Array) -> Array:
    """Return the median command (S,) of (T, S)."""
    middle = np.median(command.real, axis=0)
    return np.asarray(middle + 1j * np.median(command.imag, axis=0) if np.iscomplexobj(command) else middle)


def _merged(found: list[Plateau], size: float) -> list[Plateau]:
    """Return the plateaus with neighbours of equal command merged, which are separated only by noise."""
    merged: list[Plateau] = []
    for plateau in found:
        if merged and np.abs(merged[-1].command - plateau.command).max() <= size:
            merged[-1] = replace(merged[-1], last=plateau.last)
        else:
            merged.append(plateau)
    return merged


def steps(run: Run) -> tuple[Step, ...]:
    """Return the steps between plateaus of a run, where the transition is shorter than a plateau."""
    held = plateaus(run)
    found = []
    for before, after in pairwise(held):
        change = after.command - before.command
        most = int(np.argmax(np.abs(change)))  # the section with the largest step
        between = run.command[before.last + 1 : after.first, most] - before.command[most]
        if len(between) * run.step >= max(_LEAST, _FEWEST * run.step):
            continue
        given = float(np.real(np.sum(between) * run.step / change[most]))
        instant = float(run.time[after.first]) - float(np.clip(given, 0.0, len(between) * run.step))
        found.append(Step(before, after, instant))
    return tuple(found)
