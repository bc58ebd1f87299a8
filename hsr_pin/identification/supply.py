"""The supply between a command and what was measured: delay, time constants of rise and fall, gain and offset of each channel.

A valve, a regulator or a drive delivers y for a command u, as y' = (gain u(t - delay) + offset - y) / T. T is one time constant
while y rises and another while it falls, because a chamber fills and vents through an orifice at different rates (J. L. Shearer,
Study of pneumatic processes in the continuous control of motion with compressed air, Trans. ASME 78, 1956). The command is held
between its instants, so the solution is a sequence of exponentials and is exact at any instant. A command may have been given up
to one sample before it was recorded, so the delay after that sample may be negative by one sample; it is reported as zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.identification.holds import is_held, repeated
from hsr_pin.inference.estimates import Estimate, number
from hsr_pin.recordings.sections import input_columns
from hsr_pin.trajectory import Array, Dataset

#: Numbers of delays and of time constants from which the fit starts, and number of the best of these that are refined.
_DELAYS, _CONSTANTS, _REFINED = 10, 8, 2
#: Number of samples with which these starts are compared.
_SEARCHED = 5000
#: Longest delay and time constant that are considered, as shares of a recording, and shortest time constant, of a sample.
_LONGEST, _SLOWEST, _FASTEST = 0.5, 10.0, 0.05
#: Change of a command, relative to its largest value, that is due to rounding.
_ROUNDED = 1e-9
#: Share of the variance of a channel from which a fit is reported as incomplete.
_INCOMPLETE = 0.02
_NAMES = ("delay", "rise", "fall", "gain", "offset")


@dataclass(frozen=True)
class Supply:
    """Response of what was measured in one channel to its command.

    Attributes:
        name: name of the channel.
        unit: unit of its values.
        delay: pure delay [s].
        rise: time constant while the value increases [s]; None if it never increases.
        fall: time constant while the value decreases [s]; None if it never decreases.
        gain: change of the value for one unit of command at rest.
        offset: value for a command of zero at rest [unit].
        rms: RMS difference of the fit from what was measured [unit].
        unexplained: share of the variance of what was measured that the fit leaves, including noise.
        step: sampling interval of the command [s].
    """

    name: str
    unit: str
    delay: Estimate
    rise: Estimate | None
    fall: Estimate | None
    gain: Estimate
    offset: Estimate
    rms: float
    unexplained: float
    step: float

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """The estimates that the recordings determine."""
        return tuple(each for each in (self.delay, self.rise, self.fall, self.gain, self.offset) if each is not None)

    def to_json(self) -> dict[str, Any]:
        """Return the estimates as plain numbers and texts; a time constant that the recordings do not determine is null."""
        found = {each.name: {"value": each.value, "unit": each.unit, "ci95": list(each.interval)} for each in self.estimates}
        summary = {
            "channel": self.name,
            "unit": self.unit,
            "late": self.is_late,
            "rms": self.rms,
            "unexplained": self.unexplained,
        }
        return {**summary, **{name: found.get(name) for name in _NAMES}}

    @property
    def lateness(self) -> float:
        """Delay plus the larger time constant [s]: the mean time by which the value follows a step."""
        return self.delay.value + max((each.value for each in (self.rise, self.fall) if each), default=0.0)

    @property
    def is_late(self) -> bool:
        """Whether the value follows its command by more than one sampling interval."""
        return self.lateness > self.step

    def __str__(self) -> str:
        """Return the response in words: ``0.24 s of delay, rises in 0.57 s, falls in 1.08 s``."""
        words = [f"{number(self.delay.value)} s of delay" if self.delay.interval[0] > 0 else "no delay"]
        for verb, each in (("rises", self.rise), ("falls", self.fall)):
            if each is not None:
                words.append(f"{verb} in {number(each.value)} s" if each.interval[0] > 0 else f"{verb} within a sample")
        if not self.is_late:
            words = [f"follows within a sample ({number(self.step)} s)"]
        if not self.gain.interval[0] <= 1.0 <= self.gain.interval[1]:
            words.append(f"gain {self.gain.rounded[0]}")
        if self.unexplained > _INCOMPLETE:
            words.append(f"{self.unexplained:.0%} of its variance follows another law")
        return ", ".join(words)


def supplies(dataset: Dataset) -> tuple[Supply, ...]:
    """Return the supply of each input channel that was recorded both as commanded and as measured, and that is driven."""
    series: dict[tuple[str, str], list[tuple[Array, Array, Array]]] = {}
    for trajectory in (trial.trajectory for trial in dataset.trials):
        if trajectory.commanded is None or trajectory.inputs is None:
            continue
        columns = zip(trajectory.commanded.T, trajectory.inputs.T, strict=True)
        for channel, (command, measured) in zip(input_columns(trajectory, dataset.channels), columns, strict=True):
            if np.isfinite(command).all():
                series.setdefault(channel, []).append((trajectory.time, command, measured))
    found = (identify_supply(each, *channel) for channel, each in series.items())
    return tuple(supply for supply in found if supply is not None)


def identify_supply(series: Sequence[tuple[Array, Array, Array]], name: str = "input", unit: str = "1") -> Supply | None:
    """Return the response of a measured value to its command; None if the command never changes.

    Args:
        series: for each recording the times (T,) [s], the command (T,) that is held from each time to the next, and the measured
            value (T,), NaN where there is none.
        name: name of the channel.
        unit: unit of command and value.
    """
    held = is_held([measured[:, None] for _, _, measured in series])
    takes = [_Take.of(time, command, measured, held) for time, command, measured in series]
    takes = [take for take in takes if len(take.times) > 1]
    if not any(len(take.targets) > 1 for take in takes):
        return None
    step = float(np.median(np.concatenate([np.diff(time) for time, _, _ in series])))
    fit, low, high = _fitted(takes, step)
    deviation = _deviations(fit, takes)
    deviation[0] = math.hypot(deviation[0], step / math.sqrt(12))  # a change is known to have occurred within one interval
    ends = [fit.x, np.maximum(fit.x - 1.96 * deviation, low), np.minimum(fit.x + 1.96 * deviation, high)]
    values = [[max(each[0], 0.0), *np.exp(each[1:3]), *each[3:5]] for each in ends]
    about = ("pure delay", "time constant of rise", "time constant of fall", "gain at rest", "value for a command of zero")
    delay, rise, fall, gain, offset = (
        Estimate(label, of, float(value), (float(least), float(most)), text, False)
        for label, of, value, least, most, text in zip(_NAMES, ("s", "s", "s", "1", unit), *values, about, strict=True)
    )
    up, down = _ways(takes, fit.x)
    rms, spread = float(np.sqrt(np.mean(fit.fun**2))), float(np.std(np.concatenate([take.values for take in takes])))
    unexplained = (rms / spread) ** 2 if spread > 0 else 0.0
    return Supply(name, unit, delay, rise if up else None, fall if down else None, gain, offset, rms, unexplained, step)


@dataclass(frozen=True, eq=False)
class _Take:
    """One recording of a channel.

    Attributes:
        times, values: (N,) times [s] and values that were measured.
        changes, targets: (J,) times [s] from which a command holds, the first before all others, and these commands.
    """

    times: Array
    values: Array
    changes: Array
    targets: Array

    @classmethod
    def of(cls, time: Array, command: Array, measured: Array, held: bool) -> _Take:
        kept = np.isfinite(measured) & ~(held & repeated(measured[:, None]))
        changed = np.abs(np.diff(command)) > _ROUNDED * np.abs(command).max()
        changes = np.flatnonzero(np.concatenate([[True], changed]))
        return cls(time[kept], measured[kept], time[changes], command[changes])

    def response(self, delay: float, rise: float, fall: float, gain: float, offset: float, start: float) -> Array:
        """Return the value (N,) that a supply delivers from a value at the beginning."""
        targets = gain * self.targets + offset
        instants = np.concatenate([self.times[:1], self.changes[1:] + delay])
        states, state = np.empty(len(targets)), start
        spans = np.maximum(np.diff(instants), 0.0)
        for index, (target, span) in enumerate(zip(targets.tolist(), [*spans.tolist(), 0.0], strict=True)):
            states[index] = state
            state = target + (state - target) * math.exp(-span / (rise if target > state else fall))
        place = np.searchsorted(instants, self.times, side="right") - 1
        gap = states[place] - targets[place]
        return np.asarray(targets[place] + gap * np.exp(-(self.times - instants[place]) / np.where(gap < 0, rise, fall)))


def _responses(takes: Sequence[_Take], values: Array) -> Array:
    delay, rise, fall, gain, offset = values[:5]
    rates = math.exp(rise), math.exp(fall)
    each: list[Array] = [take.response(delay, *rates, gain, offset, start) for take, start in zip(takes, values[5:], strict=True)]
    return np.concatenate(each)


def _fitted(takes: Sequence[_Take], step: float) -> tuple[Any, Array, Array]:
    """Return the least-squares fit of delay, logarithms of both time constants, gain, offset, and starts, and their bounds."""
    begun = np.cumsum([0, *(len(take.times) for take in takes[:-1])])
    few = [take for take, before in zip(takes, begun, strict=True) if before < _SEARCHED]
    measured = np.concatenate([take.values for take in few])
    longest = max(float(take.times[-1] - take.times[0]) for take in takes)
    begins = np.array([take.targets[0] for take in takes])
    trials = []
    for delay in np.concatenate([[-step / 2], np.geomspace(step / 2, _LONGEST * longest, _DELAYS - 1)]):
        for constant in np.log(np.geomspace(step / 2, longest, _CONSTANTS)):
            unit = _responses(few, np.array([delay, constant, constant, 1.0, 0.0, *begins[: len(few)]]))
            columns = np.stack([unit, np.ones_like(unit)], axis=1)
            (gain, offset), *_ = np.linalg.lstsq(columns, measured, rcond=None)
            missed = float(np.sum((columns @ (gain, offset) - measured) ** 2))
            trials.append((missed, [delay, constant, constant, gain, offset]))
    trials.sort(key=lambda each: each[0])
    scale = float(np.std(measured)) or 1.0
    sizes = np.array([step, 1.0, 1.0, max(abs(trials[0][1][3]), 1e-12), *[scale] * (1 + len(takes))])
    low = np.array([-step, *[math.log(_FASTEST * step)] * 2, *[-np.inf] * (2 + len(takes))])
    high = np.array([_LONGEST * longest, *[math.log(_SLOWEST * longest)] * 2, *[np.inf] * (2 + len(takes))])

    def refined(some: Sequence[_Take], start: Sequence[float]) -> Any:
        count = 5 + len(some)
        values = np.concatenate([take.values for take in some])
        first = np.array([*start, *(start[3] * begins + start[4])])[:count]
        return least_squares(
            lambda x: _responses(some, x) - values,
            np.clip(first, low[:count], high[:count]),
            lambda x: _slopes(some, x, sizes[:count]),
            (low[:count], high[:count]),
            x_scale=sizes[:count],
        )

    best = min((refined(few, start) for _, start in trials[:_REFINED]), key=lambda fit: fit.cost)
    return refined(takes, best.x[:5]), low, high


def _slopes(takes: Sequence[_Take], values: Array, sizes: Array) -> Array:
    """Return the central differences (N, P) of the responses; the start of a recording changes that recording only."""
    slopes = np.zeros((sum(len(take.times) for take in takes), len(values)))
    whose = np.repeat(np.arange(len(takes)), [len(take.times) for take in takes])
    for index in range(6):
        change = np.where(np.arange(len(values)) >= 5, 1.0, 0.0) if index == 5 else np.eye(len(values))[index]
        change = 1e-5 * change * sizes
        down, up = values - change, values + change
        each = (_responses(takes, up) - _responses(takes, down)) / (up - down)[index]
        if index < 5:
            slopes[:, index] = each
        else:
            slopes[np.arange(len(whose)), 5 + whose] = each
    return slopes


def _deviations(fit: Any, takes: Sequence[_Take]) -> Array:
    """Return the standard deviations (P,) of a fit whose errors last as long as their autocorrelation shows.

    The autocorrelation is used up to its first value that is not positive (C. J. Geyer, Practical Markov chain Monte Carlo,
    Statistical Science 7, 1992). No deviation is smaller than that for white noise.
    """
    ends = np.cumsum([len(take.times) for take in takes])
    scales = np.sqrt((fit.jac**2).sum(axis=0))
    slopes = fit.jac / np.where(scales > 0, scales, 1.0)
    missed, parts = np.split(fit.fun, ends[:-1]), np.split(slopes, ends[:-1])
    size = 2 * max(map(len, missed))
    along = np.fft.irfft(sum(np.abs(np.fft.rfft(each, size)) ** 2 for each in missed), size)[: size // 2]
    along[int(np.argmax(along <= 0)) or len(along) :] = 0.0
    kernel = np.concatenate([along, [0.0], along[:0:-1]]) / max(along[0], np.finfo(float).tiny)
    weights = np.fft.rfft(kernel)[:, None]
    lasting = [each.T @ np.fft.irfft(weights * np.fft.rfft(each, size, axis=0), size, axis=0)[: len(each)] for each in parts]
    inverse = np.linalg.pinv(slopes.T @ slopes, rcond=1e-12)
    variance = float(fit.fun @ fit.fun) / max(1, len(fit.fun) - slopes.shape[1])
    squares = np.maximum(np.diag(inverse @ np.sum(lasting, axis=0) @ inverse), np.diag(inverse))
    return np.asarray(np.sqrt(variance * squares) / np.where(scales > 0, scales, 1.0))


def _ways(takes: Sequence[_Take], values: Array) -> tuple[bool, bool]:
    """Return whether any command makes the value increase, and whether any makes it decrease."""
    changes = np.concatenate([np.diff(values[3] * take.targets) for take in takes])
    return bool((changes > 0).any()), bool((changes < 0).any())
