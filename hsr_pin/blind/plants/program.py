"""Programs of trials that are recorded: steps, staircase, chirp, releases, payload.

Commands are torques [N m] held between samples at 100 Hz. Stiffness, damping and torques are those of
Tables I and II of the paper; pressures follow from its Eqs. (1), (4) and (5).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.errors import InputError

from .arm import Array

RATE = 100  # samples per second
#: Keq [Nm/rad] -> (C [Nm s/rad], the three torques of Table II [N m])
LEVELS: dict[float, tuple[float, tuple[float, float, float]]] = {
    1.11: (0.05, (0.250, 0.625, 1.000)),
    2.33: (0.10, (0.100, 1.800, 3.500)),
}


@dataclass(frozen=True)
class Trial:
    """One recording.

    Attributes:
        keq: declared stiffness [Nm/rad].
        damping: declared damping of the whole arm [Nm s/rad].
        command: torque at each sample [N m], or empty for a recording without input.
        duration: duration [s].
        tip_mass: known payload [kg].
        hold_torque: uniform moment that holds the arm until `release` [N m].
        hold_force: force along x of the arm frame that holds the arm until `release` [N].
        hold_at: place of the force, relative to the length.
        release: time of the release after the first sample [s].
        release_duration: time over which the holding loads fall to zero [s].
        start_error: error of the declared instant of release [s]; positive: too late.
        clock: start of the recording in session time [s].
    """

    keq: float
    damping: float
    duration: float
    command: tuple[float, ...] = ()
    tip_mass: float = 0.0
    hold_torque: float = 0.0
    hold_force: float = 0.0
    hold_at: float = 1.0
    release: float = 0.0
    release_duration: float = 0.0
    start_error: float = 0.0
    clock: float = 0.0

    @property
    def samples(self) -> int:
        """Number of samples, including both ends."""
        return round(self.duration * RATE) + 1

    def torque(self) -> Array:
        """Return the commanded torque at each sample, (T,) [N m]; zeros without input."""
        return np.array(self.command) if self.command else np.zeros(self.samples)


@dataclass(frozen=True)
class Program:
    """Trials on one mount; `given` is the input in the files: ``pressures`` or ``tau``."""

    mount: str
    trials: tuple[Trial, ...]
    given: str = "pressures"


def pressures(torque: Array, keq: float) -> tuple[Array, Array]:
    """Return P1 and P2, each (T,) [bar], for a stiffness `keq` and a torque: Eqs. (1), (4), (5) inverted."""
    coefficients = np.array([[0.8183, 1.415], [-0.2892, 0.7321]])
    right = np.stack([np.full_like(torque, keq + 2.594), torque / keq + 0.7742])
    p1, p2 = np.linalg.solve(coefficients, right)
    return p1, p2


def steps(keq: float) -> list[Trial]:
    """Return steps from rest to each torque of Table II at 0.3 s, 2 s each."""
    t = np.arange(2 * RATE + 1) / RATE
    return [trial_of(keq, np.where(t >= 0.3, tau, 0.0)) for tau in LEVELS[keq][1]]


def staircase(keq: float) -> list[Trial]:
    """Return a staircase: up in four stairs, down past zero and back, 0.7 s for each stair."""
    stairs = np.array([0, 0.25, 0.5, 0.75, 1, 0.75, 0.5, 0.25, 0, -0.2, 0, 0.5, 0]) * LEVELS[keq][1][2]
    tau = np.repeat(stairs, round(0.7 * RATE))
    return [trial_of(keq, np.append(tau, tau[-1]))]


def chirp(keq: float) -> list[Trial]:
    """Return a chirp from 0.2 to 4 Hz in 6 s about a mean torque that is approached slowly."""
    return [trial_of(keq, sweep(LEVELS[keq][1][2] * 0.45)[1])]


def releases(keq: float) -> list[Trial]:
    """Return two releases at 0.2 s without input, 1.5 s each: bent by a couple, and bent by a force at the tip."""
    bare = trial_of(keq, np.zeros(round(1.5 * RATE) + 1), release=0.2)
    bare = replace(bare, command=())
    pull = 1.2 * keq / 0.24
    return [replace(bare, hold_torque=0.7 * keq), replace(bare, hold_force=pull)]


def payload(keq: float) -> list[Trial]:
    """Return the two larger steps with a known 50 g at the tip."""
    return [replace(trial, tip_mass=0.05) for trial in steps(keq)[1:]]


KINDS: dict[str, Callable[[float], list[Trial]]] = {
    "chirp": chirp, "payload": payload, "releases": releases, "staircase": staircase, "steps": steps,
}  # fmt: skip


def program(kinds: str = "steps", mount: str = "hanging", given: str = "pressures") -> Program:
    """Return a program on both stiffness levels; `kinds` joins names of `KINDS` by ``+`` (``steps+chirp``).

    There is a pause of 20 s after each trial.
    """
    if given not in ("pressures", "tau"):
        raise InputError("input", expected="pressures or tau", received=given)
    return Program(mount, in_session(kinds, KINDS, sorted(LEVELS)), given)


def in_session(kinds: str, known: Mapping[str, Callable[[float], list[Trial]]], levels: Sequence[float]) -> tuple[Trial, ...]:
    """Return the trials of ``known`` kinds, joined by ``+``, on each stiffness level, with a pause of 20 s after each trial."""
    names = kinds.split("+")
    if unknown := [name for name in names if name not in known]:
        raise InputError("program", expected=f"names of {sorted(known)} joined by +", received=unknown)
    clock, trials = 0.0, []
    for trial in (trial for keq in levels for name in names for trial in known[name](keq)):
        trials.append(replace(trial, clock=clock))
        clock += trial.duration + 20.0
    return tuple(trials)


def trial_of(keq: float, tau: Array, release: float = 0.0) -> Trial:
    """Return a trial with a torque at each sample, (T,) [N m]; complex, x + i y, for an arm in space."""
    return Trial(keq, LEVELS[keq][0], (len(tau) - 1) / RATE, tuple(tau.tolist()), release=release)


def sweep(mean: float) -> tuple[Array, Array]:
    """Return times (T,) [s] and torques [N m] of a chirp from 0.2 to 4 Hz in 6 s about a mean that is approached slowly."""
    t = np.arange(6 * RATE + 1) / RATE
    phase = 2 * np.pi * (0.2 * t + (4 - 0.2) / 12 * t**2)
    return t, mean * (1 - np.exp(-t)) * (1 + 0.7 * np.sin(phase))
