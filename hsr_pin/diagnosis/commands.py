"""What a command is made of: stretches in which it is held, and the steps between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

#: A command is held while it changes by less than this share of its largest size, for at least so long [s] and so many samples.
_HELD, _LEAST, _FEWEST = 0.01, 0.2, 5


@dataclass(frozen=True)
class Plateau:
    """A stretch in which the command is held.

    Attributes:
        first, last: its samples.
        torque: [N m]; in space complex. Of an arm of sections the mean along it.
        command: (S,) that of each section.
    """

    first: int
    last: int
    torque: Any
    command: Array


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
    """Of the section whose command (T, S) spreads most."""
    return float(np.hypot(np.ptp(command.real, axis=0), np.ptp(command.imag, axis=0)).max())


def _middle(command: Array) -> Array:
    """(S,) of (T, S)."""
    middle = np.median(command.real, axis=0)
    return np.asarray(middle + 1j * np.median(command.imag, axis=0) if np.iscomplexobj(command) else middle)


def _merged(found: list[Plateau], size: float) -> list[Plateau]:
    """Plateaus at the same command that nothing but a flicker parts are one."""
    merged: list[Plateau] = []
    for plateau in found:
        if merged and np.abs(merged[-1].command - plateau.command).max() <= size:
            merged[-1] = replace(merged[-1], last=plateau.last)
        else:
            merged.append(plateau)
    return merged


def steps(run: Run) -> tuple[Step, ...]:
    """The steps between plateaus of a run: what lies between must be shorter than a plateau."""
    held = plateaus(run)
    found = []
    for before, after in pairwise(held):
        change = after.command - before.command
        most = int(np.argmax(np.abs(change)))  # of the sections
        between = run.command[before.last + 1 : after.first, most] - before.command[most]
        if len(between) * run.step >= max(_LEAST, _FEWEST * run.step):
            continue
        given = float(np.real(np.sum(between) * run.step / change[most]))
        instant = float(run.time[after.first]) - float(np.clip(given, 0.0, len(between) * run.step))
        found.append(Step(before, after, instant))
    return tuple(found)
