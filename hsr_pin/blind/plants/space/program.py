"""Programs of trials for arms in space: torques in all directions, complex, x + i y [N m], and releases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..program import RATE, Program, Trial, in_session, sweep, trial_of

#: Size relative to Keq and direction [rad] of the first step of each trial.
_STEPS = ((0.9, 0.3), (0.6, 2.2), (0.75, -2.5), (0.4, -1.0))


def steps(keq: float) -> list[Trial]:
    """Return four steps from rest to one direction at 0.3 s and to another direction at 1.3 s; 2.3 s each."""
    t = np.arange(round(2.3 * RATE) + 1) / RATE
    found = []
    for size, side in _STEPS:
        way = size * keq * np.exp(1j * side)
        found.append(trial_of(keq, np.select([t < 0.3, t < 1.3], [0.0, way], way * np.exp(1.3j))))
    return found


def circle(keq: float) -> list[Trial]:
    """Return a circle in stairs of 30 degrees, forth and back, after 2 s of approach; 10 s."""
    t = np.arange(10 * RATE + 1) / RATE
    turn = np.pi / 6 * np.round(np.interp(t, [2.0, 6.0, 10.0], [0.0, 12.0, 0.0]))
    return [trial_of(keq, 0.7 * keq * np.minimum(t / 2, 1.0) * np.exp(1j * turn))]


def chirp(keq: float) -> list[Trial]:
    """Return a chirp from 0.2 to 4 Hz in 6 s in a rotating direction, about a mean torque that is approached slowly."""
    t, torque = sweep(0.4 * keq)
    return [trial_of(keq, torque * np.exp(1j * (0.5 + 0.6 * t)))]


def releases(keq: float) -> list[Trial]:
    """Return three releases at 0.2 s without input, 1.5 s each: two from a couple, one from a force at the tip."""
    bare = replace(trial_of(keq, np.zeros(round(1.5 * RATE) + 1), release=0.2), command=())
    ways = [np.exp(1j * side) for side in (0.5, 2.6, -1.6)]
    couples = [replace(bare, hold_torque=0.7 * keq * way) for way in ways[:2]]
    return [*couples, replace(bare, hold_force=0.8 * keq / 0.24 * ways[2])]


def payload(keq: float) -> list[Trial]:
    """Return two of the steps with a known 50 g at the tip."""
    return [replace(trial, tip_mass=0.05) for trial in steps(keq)[:2]]


KINDS: dict[str, Callable[[float], list[Trial]]] = {
    "chirp": chirp, "circle": circle, "payload": payload, "releases": releases, "steps": steps,
}  # fmt: skip


def program(kinds: str = "steps", mount: str = "hanging", keq: float = 1.11) -> Program:
    """Return a program on one stiffness level; `kinds` joins names of `KINDS` by ``+``; pauses between trials are 20 s."""
    return Program(mount, in_session(kinds, KINDS, [keq]), "tau")
