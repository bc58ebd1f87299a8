"""Estimation of the delay between a command and the motion, by cross-correlation with the filtered command."""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hsr_pin.recordings.grid import hold
from hsr_pin.trajectory import Array

#: Number of natural frequencies of the filters, log-spaced between the limits set by the length and the step of the recording;
#: and their damping ratios, from weakly damped to overdamped.
FREQUENCIES, RATIOS = 12, (0.1, 0.4, 0.9, 3.0)
#: Smallest explained share of the motion's variance for which the motion is said to follow from the command.
FOLLOWS = 0.5
#: Longest lag of a command that was filtered before it was logged [s]; a longer lag is a clock offset.
FILTERED = 0.2
#: Segments of the command with less variance than this share of the largest one are ignored.
STILL = 0.01
#: Longest correlation that is computed [samples]; longer logs are resampled at coarser steps.
MOST = 1 << 18
#: Standard deviations of the interval, and of a reported lead (larger, as the interval is too narrow for slow commands).
INTERVAL_SIGMAS, LEAD_SIGMAS = 2.0, 5.0


@dataclass(frozen=True)
class Lag:
    """Estimated delay of a motion after its command.

    Attributes:
        value: delay of the motion after the command [s], in addition to that of mass, spring and damper; negative: a lead.
        sigma: standard deviation of the delay [s].
        share: share of the motion's variance that the command explains at this delay.
        share_without_lead: largest share that the command explains at delays of zero or more.
        ambiguous: whether other, separate delays explain nearly as much, as for periodic motion.
        step: step of the samples [s].
    """

    value: float
    sigma: float
    share: float
    share_without_lead: float
    ambiguous: bool
    step: float

    @property
    def follows(self) -> bool:
        """Whether the command explains the motion at all."""
        return self.share >= FOLLOWS

    @property
    def is_early(self) -> bool:
        """Whether the motion significantly leads its command: a lead halves the unexplained variance at least."""
        clear = self.value + LEAD_SIGMAS * self.sigma < 0 and 1 - self.share < (1 - self.share_without_lead) / 2
        return self.follows and clear and self.value < -max(FILTERED, 2 * self.step)

    def __str__(self) -> str:
        return f"{self.value:.3g} +- {self.sigma:.1g} s"


def find_lag(source: Array, command: Array, time: Array, motion: Array, *, signed: bool = False) -> Lag | None:
    """Estimate the delay of a motion after its command; None if one of them does not change.

    The command is filtered by second-order systems of many frequencies and damping ratios, and each output is correlated with the
    motion (normalised cross-correlation). The interval contains all delays whose residual is not significantly larger than the
    smallest one; the number of independent samples follows from the autocorrelation of the residual.

    Args:
        source: (R,) times of the command [s]; each row holds until the next.
        command: (R,) values; complex in space, like the motion.
        time: (T,) even times of the motion [s].
        motion: (T,) displacement along one direction; NaN where not seen.
        signed: the motion has the same sign as the command.
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
    answers = list(_filtered(given, step, len(moved)))
    matches = np.stack([_match(each, moved, signed) for each in answers])
    model, at = (int(place) for place in np.unravel_index(int(np.argmax(matches)), matches.shape))
    share = float(matches[model, at])
    alone = _independent(answers[model][at : at + len(moved)], moved)
    near = np.flatnonzero(1 - matches.max(axis=0) <= max(1 - share, 1e-9) * (1 + INTERVAL_SIGMAS**2 / alone))
    sigma = max(float(np.ptp(near)) * step / (2 * INTERVAL_SIGMAS), step / np.sqrt(12))
    lags = time[0] - begin - np.arange(matches.shape[1]) * step
    without_lead = float(matches[:, lags >= -step / 2].max(initial=0.0))
    return Lag(float(lags[at]), sigma, share, without_lead, bool(np.any(np.diff(near) * step > FILTERED)), step)


def _filtered(given: Array, step: float, count: int) -> Iterator[Array]:
    """Yield a command (N,) as it is, and the responses of second-order systems to it, starting from rest."""
    yield given
    for frequency in np.geomspace(2 * np.pi / (count * step), np.pi / (2 * step), FREQUENCIES):
        for ratio in RATIOS:
            yield second_order_response(given, step, frequency, ratio)


def second_order_response(given: Array, step: float, frequency: float, ratio: float) -> Array:
    """Return the response (N,) of a second-order system of unit gain, starting from rest, to a held input (N,).

    Args:
        given: input, zero at first; real or complex.
        step: step of the samples [s].
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
    """Return the share (N - n + 1,) of a motion's (n,) variance that a command (N,) explains, for each start sample."""
    size, count = len(given), len(moved)
    total, squares = (np.append(0.0, np.cumsum(values)) for values in (given, np.abs(given) ** 2))
    window = total[count:] - total[:-count]
    spread = squares[count:] - squares[:-count] - np.abs(window) ** 2 / count
    length = 1 << (size + count).bit_length()
    product = np.fft.ifft(np.fft.fft(given, length) * np.conj(np.fft.fft(moved, length)))[: size - count + 1]
    along = np.maximum(product.real, 0.0) if signed else np.abs(product)
    is_significant = spread > STILL * float(np.max(spread))
    return np.asarray(
        np.where(is_significant, along**2 / np.where(is_significant, spread, 1.0) / np.sum(np.abs(moved) ** 2), 0.0)
    )


def _independent(given: Array, moved: Array) -> float:
    """Return the effective number of independent samples of a residual (n,), from its lag-one autocorrelation."""
    given = given - given.mean()
    residual = moved - given * (np.vdot(given, moved) / np.vdot(given, given))
    whole, over_one = (float(np.vdot(residual[: len(residual) - by], residual[by:]).real) for by in (0, 1))
    near = min(max(over_one / max(whole, 1e-300), 0.0), 1 - 1e-9)
    return max(len(moved) * (1 - near) / (1 + near), 1.0)
