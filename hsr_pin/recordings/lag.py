"""How long after its command a motion comes, from the two alone: cross-correlation with a command that passed through an arm."""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hsr_pin.recordings.grid import hold
from hsr_pin.trajectory import Array

#: Natural frequencies that are tried, evenly in their logarithm between what the recording's length and its samples can show; and
#: damping ratios, from one that rings to one that creeps.
FREQUENCIES, RATIOS = 12, (0.1, 0.4, 0.9, 3.0)
#: Less of the motion's variance than this, and the motion does not follow from the command.
FOLLOWS = 0.5
#: A command that was filtered before it was logged lags by up to so much [s]; more is a clock's.
FILTERED = 0.2
#: A stretch of the command that varies less than this share of the most varied one tells nothing.
STILL = 0.01
#: Longest correlation that is computed [samples]; longer logs are looked at in coarser steps.
MOST = 1 << 18
#: Standard deviations of an interval, and of a lead that is reported: where the command is slow, the interval is too short.
CLEAR, CERTAIN = 2.0, 5.0


@dataclass(frozen=True)
class Lag:
    """What a motion and its command tell of their clocks.

    Attributes:
        value: [s] by which the motion comes after the command, beyond what mass, spring and damper take; below zero: before.
        sigma: its standard deviation [s].
        share: of the motion's variance that the command then explains.
        unless: the share that it explains if the motion does not come before it.
        apart: whether other lags, apart from this one, explain nearly as much: a motion that repeats itself.
        step: [s] of the samples.
    """

    value: float
    sigma: float
    share: float
    unless: float
    apart: bool
    step: float

    @property
    def follows(self) -> bool:
        """Whether the motion follows from the command at all."""
        return self.share >= FOLLOWS

    @property
    def is_early(self) -> bool:
        """Whether the motion clearly comes before its command: that explains at least half of what else is left."""
        clear = self.value + CERTAIN * self.sigma < 0 and 1 - self.share < (1 - self.unless) / 2
        return self.follows and clear and self.value < -max(FILTERED, 2 * self.step)

    def __str__(self) -> str:
        return f"{self.value:.3g} +- {self.sigma:.1g} s"


def find_lag(source: Array, command: Array, time: Array, motion: Array, *, signed: bool = False) -> Lag | None:
    """Find by how much a motion lags behind its command; None where one of them does not change.

    The command passes through second-order systems of many frequencies and damping ratios, and each is slid along the motion
    (normalised cross-correlation). The interval holds all lags whose residual is not clearly larger than the least one's, which
    counts as many independent samples as its autocorrelation leaves.

    Args:
        source: (R,) [s] when the command was given; each row holds until the next.
        command: (R,); complex in space, as the motion.
        time: (T,) [s] of the motion, even.
        motion: (T,) along one direction; NaN where not seen.
        signed: the motion goes where the command does, not the other way.
    """
    seen = np.isfinite(motion)
    if seen.sum() < 3 or np.ptp(motion[seen]) == 0 or np.ptp(command) == 0:
        return None
    count = len(time)
    span = time[-1] - time[0]
    step = max(span / (count - 1), (source[-1] - source[0] + 3 * span) / MOST)
    instants = np.arange(time[0], time[-1] + step / 2, step)
    moved = np.interp(instants, time[seen], motion[seen])
    moved = np.asarray(moved - moved.mean())
    begin = source[0] - span
    given = hold(source, command, np.arange(begin, source[-1] + span + step, step) + 1e-9 * step)
    given = given - given[0]
    answers = list(_passed(given, step, len(moved)))
    matches = np.stack([_match(each, moved, signed) for each in answers])
    model, at = (int(place) for place in np.unravel_index(int(np.argmax(matches)), matches.shape))
    share = float(matches[model, at])
    alone = _independent(answers[model][at : at + len(moved)], moved)
    near = np.flatnonzero(1 - matches.max(axis=0) <= max(1 - share, 1e-9) * (1 + CLEAR**2 / alone))
    sigma = max(float(np.ptp(near)) * step / (2 * CLEAR), step / np.sqrt(12))
    lags = time[0] - begin - np.arange(matches.shape[1]) * step
    unless = float(matches[:, lags >= -step / 2].max(initial=0.0))
    return Lag(float(lags[at]), sigma, share, unless, bool(np.any(np.diff(near) * step > FILTERED)), step)


def _passed(given: Array, step: float, count: int) -> Iterator[Array]:
    """A command (N,) as it is, and behind second-order systems, from rest."""
    yield given
    for frequency in np.geomspace(2 * np.pi / (count * step), np.pi / (2 * step), FREQUENCIES):
        for ratio in RATIOS:
            yield passed(given, step, frequency, ratio)


def passed(given: Array, step: float, frequency: float, ratio: float) -> Array:
    """(N,) what a second-order system of unit gain, at rest, makes of an input (N,) that is held from sample to sample.

    Args:
        given: zero at first; real or complex.
        step: [s].
        frequency: natural frequency [rad/s].
        ratio: damping ratio.
    """
    turn = cmath.sqrt(ratio**2 - 1) or 1e-6
    first, second = (-frequency * (ratio + sign * turn) for sign in (1, -1))
    time = step * np.arange(len(given))
    to_a_step = (1 + (second * np.exp(first * time) - first * np.exp(second * time)) / (first - second)).real
    length = 1 << (2 * len(given)).bit_length()
    answer = np.fft.ifft(np.fft.fft(given, length) * np.fft.fft(np.diff(to_a_step, prepend=0.0), length))[: len(given)]
    return np.asarray(answer if np.iscomplexobj(given) else answer.real)


def _match(given: Array, moved: Array, signed: bool) -> Array:
    """(N - n + 1,) share of the variance of a motion (n,) that a command (N,) explains, from each of its samples on."""
    size, count = len(given), len(moved)
    total, squares = (np.append(0.0, np.cumsum(values)) for values in (given, np.abs(given) ** 2))
    window = total[count:] - total[:-count]
    spread = squares[count:] - squares[:-count] - np.abs(window) ** 2 / count
    length = 1 << (size + count).bit_length()
    product = np.fft.ifft(np.fft.fft(given, length) * np.conj(np.fft.fft(moved, length)))[: size - count + 1]
    along = np.maximum(product.real, 0.0) if signed else np.abs(product)
    tells = spread > STILL * float(np.max(spread))
    return np.asarray(np.where(tells, along**2 / np.where(tells, spread, 1.0) / np.sum(np.abs(moved) ** 2), 0.0))


def _independent(given: Array, moved: Array) -> float:
    """How many independent samples the residual (n,) of a motion counts as, from its autocorrelation over one sample."""
    given = given - given.mean()
    residual = moved - given * (np.vdot(given, moved) / np.vdot(given, given))
    whole, over_one = (float(np.vdot(residual[: len(residual) - by], residual[by:]).real) for by in (0, 1))
    near = min(max(over_one / max(whole, 1e-300), 0.0), 1 - 1e-9)
    return max(len(moved) * (1 - near) / (1 + near), 1.0)
