"""Frequency and damping as functions of the amplitude, from free decays after a release or after the last step of a command.

The amplitude of a turning point is half of its distance from the mean of its neighbours, so that neither the equilibrium nor a
steady drift of it matters. Viscous damping removes the same share of every cycle. Dry friction removes the same amount, which is
a larger share of smaller cycles. Damping that grows with speed removes a larger share of larger cycles (B. F. Feeny, J. W. Liang,
A decrement method for the simultaneous estimation of Coulomb and viscous friction, Journal of Sound and Vibration 195, 1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.indicators.bending import Bending, bending
from hsr_pin.diagnosis.indicators.indicator import Indicator, counted, logarithmic, rounded, rounded_range
from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, slope_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Least distance between neighbouring turning points: in standard deviations of noise, and as a share of the largest distance.
_NOISES, _SMALLEST = 12.0, 0.02
#: Least number of cycles, and least ratio of amplitudes, for a trend.
_CYCLES, _RANGE = 5, 2.0
#: Least relative change of the damping ratio, and of the frequency, for a doubled amplitude that is significant.
_DAMPING, _FREQUENCY = 0.12, 0.015
#: Damping ratios with two payloads are compared if the heavier one lowers the frequency to at most this share, with at least this
#: number of cycles; a significant difference from a viscous damper exceeds this many standard errors.
_SLOWED, _ENOUGH, _CERTAIN = 0.8, 5, 3.0
#: Signs of the trends of damping and frequency with amplitude -> the conclusion.
_MEANING = {
    (1, 0): "damping that grows with speed, or hysteresis that slips in large cycles only",
    (-1, 0): "friction, which damps small cycles more",
    (0, 1): "a stiffness that grows with bending, or a contact",
    (0, -1): "hysteresis, or a stiffness that falls with bending",
    (1, 1): "damping that grows with speed and a stiffness that grows with bending, or to a contact",
    (1, -1): "hysteresis, or to damping that grows with speed and a stiffness that falls with bending",
    (-1, 1): "friction and a stiffness that grows with bending, or to backlash",
    (-1, -1): "friction or hysteresis, which stiffen and damp small cycles more",
}


class Swing(NamedTuple):
    """One cycle of a decay.

    Attributes:
        trial: name of the trial.
        group: declared stiffness [Nm/rad], payload [kg] and command [N m]; cycles of one group are comparable.
        amplitude: amplitude of the bending angle [rad].
        frequency: frequency [Hz].
        damping: damping ratio.
    """

    trial: str
    group: tuple[float, float, float]
    amplitude: float
    frequency: float
    damping: float


class Loaded(NamedTuple):
    """Cycles of similar amplitudes with a light (or no) and a heavier payload, with damping ratios that no viscous damper has.

    Attributes:
        light, heavy: payloads [kg].
        frequencies: median frequencies with both payloads [Hz].
        ratios: median damping ratios with both payloads.
    """

    light: float
    heavy: float
    frequencies: tuple[float, float]
    ratios: tuple[float, float]

    @property
    def damper(self) -> float:
        """Damping ratio that a viscous damper would have with the heavier payload; it is proportional to the frequency."""
        return self.ratios[0] * self.frequencies[1] / self.frequencies[0]

    @property
    def sentence(self) -> str:
        """The numbers and the conclusion in one sentence."""
        light, heavy = (f"{1e3 * mass:.0f} g" for mass in (self.light, self.heavy))
        fast, slow, before, after = map(rounded, (*self.frequencies, *self.ratios))
        return (
            f" With {heavy} at the tip instead of {light} the frequency is {slow} Hz instead of {fast} Hz, and the damping ratio "
            f"of cycles with similar amplitude is {after} instead of {before}, whereas that of a viscous damper would fall to "
            f"{rounded(self.damper)}: this points to relaxation, or friction."
        )


@dataclass(frozen=True, eq=False)
class Decay(Indicator):
    """Frequency and damping as functions of the amplitude.

    Attributes:
        swings: all cycles.
        damping_trend: relative change of the damping ratio when the amplitude doubles.
        frequency_trend: relative change of the frequency when the amplitude doubles.
        loaded: comparison of two payloads, if the damping ratio does not fall as that of a viscous damper would; otherwise None.
    """

    swings: tuple[Swing, ...]
    damping_trend: Estimate
    frequency_trend: Estimate
    loaded: Loaded | None = None
    name: ClassVar[str] = "decay"
    title: ClassVar[str] = "Free decay: damping and frequency over amplitude"

    @property
    def damps(self) -> int:
        """Sign of the trend of damping with amplitude: 1, -1, or 0 if it is not significant."""
        return _sign(self.damping_trend, _DAMPING)

    @property
    def hardens(self) -> int:
        """Sign of the trend of the frequency with amplitude: 1, -1, or 0 if it is not significant."""
        return _sign(self.frequency_trend, _FREQUENCY)

    @property
    def kinds(self) -> tuple[str, ...]:
        kinds: list[str] = []
        if self.damps < 0 or self.hardens < 0 or (self.damps > 0 and not self.hardens):
            kinds.append("friction")
        if self.damps > 0:
            kinds.append("damping")
        if self.hardens > 0 or (self.hardens < 0 and self.damps >= 0):
            kinds.append("elastic")
        return tuple(kinds)

    @property
    def sentence(self) -> str:
        damping = np.array([swing.damping for swing in self.swings])
        frequency = np.array([swing.frequency for swing in self.swings])
        low, high = np.percentile(frequency, [10, 90])
        text = (
            f"In {counted(len(self.swings), 'cycle')} the arm swings at {rounded_range(low, high)} Hz with a damping ratio of "
            f"{rounded(float(np.median(damping)))}"
        )
        if not np.isfinite(self.damping_trend.low):
            return f"{text}: the cycles are too few, or their amplitudes too similar, to determine a dependence on amplitude."
        changes = []
        if self.damps:
            changes.append(f"the damping ratio changes by {rounded(100 * self.damping_trend.value)} %")
        if self.hardens:
            changes.append(f"the frequency {'' if changes else 'changes '}by {rounded(100 * self.frequency_trend.value)} %")
        after = self.loaded.sentence if self.loaded else ""
        if not changes:
            return f"{text}, independent of the amplitude{'' if after else ', as for a spring and a viscous damper'}.{after}"
        meaning = _MEANING[self.damps, self.hardens]
        return f"{text}; if the amplitude doubles, {' and '.join(changes)}: this points to {meaning}.{after}"

    def numbers(self) -> dict[str, Any]:
        return {
            "swings": [{**swing._asdict(), "group": list(swing.group)} for swing in self.swings],
            "damping_trend": self.damping_trend,
            "frequency_trend": self.frequency_trend,
            "loaded": {**self.loaded._asdict(), "damper": self.loaded.damper} if self.loaded else None,
        }

    def draw(self, axes: Axes) -> None:
        """Draw damping ratio (dots) and frequency (squares, second axis) against the amplitude."""
        amplitude = [swing.amplitude for swing in self.swings]
        axes.plot(amplitude, [s.damping for s in self.swings], "o", ms=3.5, mew=0, color=ROLES["model"], label="damping ratio")
        logarithmic(axes)
        damping = [swing.damping for swing in self.swings]
        axes.set_ylim(min(0.0, *damping), 1.4 * max(damping))
        axes.set(xlabel="amplitude of the bending [rad], logarithmic", ylabel="damping ratio")
        axes.grid()
        other = axes.twinx()
        other.plot(
            amplitude,
            [s.frequency for s in self.swings],
            "s",
            ms=4,
            mfc="none",
            mec=ROLES["declared"],
            ls="none",
            label="frequency",
        )
        other.set_ylim(0, 1.4 * max(swing.frequency for swing in self.swings))
        other.set_ylabel("frequency [Hz]")
        handles, labels = (
            a + b for a, b in zip(axes.get_legend_handles_labels(), other.get_legend_handles_labels(), strict=True)
        )
        axes.legend(handles, labels, loc="upper right", ncols=2)


def decay(experiment: Experiment) -> Decay | None:
    """Return frequency and damping of free decays; None if no decay has four turning points."""
    swings: list[Swing] = []
    for run in experiment.runs:
        motion = bending(run, experiment)
        for plateau in plateaus(run):
            if plateau.first == 0 and run.start_pose is None:
                continue
            first, last = motion.span(plateau)
            time, angle = motion.between(first, last)
            group = (run.trial.keq, run.trial.tip_mass, float(np.round(plateau.torque, 6)))
            swings += [Swing(run.trial.name, group, *cycle) for cycle in _cycles(*turning_points(time, angle, motion))]
    swings = [swing for swing in swings if swing.damping > -0.05]
    if not swings:
        return None
    damping, frequency = (_trend(swings, [getattr(s, name) for s in swings]) for name in ("damping", "frequency"))
    falls = experiment.dataset.mount != "upright"  # on an upright arm a payload reduces the restoring moment
    return Decay(tuple(swings), damping, frequency, _loaded(swings) if falls else None)


def _loaded(swings: list[Swing]) -> Loaded | None:
    """Return two payloads with equal stiffness and command whose damping ratios contradict a viscous damper; None without any."""
    comparable: dict[tuple[float, float], dict[float, list[Swing]]] = {}
    for swing in swings:
        keq, payload, command = swing.group
        comparable.setdefault((keq, command), {}).setdefault(payload, []).append(swing)
    for of_payload in comparable.values():
        light, heavy = min(of_payload), max(of_payload)
        least = max(min(swing.amplitude for swing in of_payload[mass]) for mass in (light, heavy))
        most = min(max(swing.amplitude for swing in of_payload[mass]) for mass in (light, heavy))
        both = [[swing for swing in of_payload[mass] if least <= swing.amplitude <= most] for mass in (light, heavy)]
        if light == heavy or min(map(len, both)) < _ENOUGH:
            continue
        fast, slow = [float(np.median([swing.frequency for swing in cycles])) for cycles in both]
        before, after = [np.array([swing.damping for swing in cycles]) for cycles in both]
        found = Loaded(light, heavy, (fast, slow), (float(np.median(before)), float(np.median(after))))
        chance = np.hypot(before.std() / np.sqrt(len(before)) * slow / fast, after.std() / np.sqrt(len(after)))
        if slow <= _SLOWED * fast and found.ratios[1] - found.damper > max(_CERTAIN * float(chance), _DAMPING * found.damper):
            return found
    return None


def turning_points(time: Array, angle: Array, motion: Bending) -> tuple[Array, Array]:
    """Return times [s] and angles [rad] of alternating maxima and minima, as long as they exceed the noise."""
    if len(time) < 8:
        return np.empty(0), np.empty(0)
    step = motion.run.step
    even = np.arange(time[0], time[-1] + step / 2, step)
    values = np.interp(even, time, angle)
    least = max(_NOISES * motion.noise, _SMALLEST * float(np.ptp(values)))
    at = _alternating(values, least)
    if len(at) > 2:  # smooth the noise over a sixth of a cycle
        width = max(5, int(np.median(np.diff(at)) / 3) // 2 * 2 + 1)
        if len(values) > width:
            values = smoothed(values, width, 3)
            at = _alternating(values, least)
    inner = at[(at > 0) & (at < len(values) - 1)]
    before, here, after = values[inner - 1], values[inner], values[inner + 1]
    bend = before - 2 * here + after
    offset = np.where(np.abs(bend) > 1e-15, 0.5 * (before - after) / np.where(bend == 0, 1, bend), 0.0).clip(-1, 1)
    return even[inner] + offset * step, here - 0.25 * (before - after) * offset


def _alternating(values: Array, least: float) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the indices of alternating maxima and minima that differ by at least ``least``; the ends may be among them."""
    found, high, low, rising = [], 0, 0, 0
    for index, value in enumerate(values):
        if value > values[high]:
            high = index
        if value < values[low]:
            low = index
        if rising >= 0 and values[high] - value > least:
            found.append(high)
            rising, low = -1, index
        elif rising <= 0 and value - values[low] > least:
            found.append(low)
            rising, high = 1, index
    return np.array(found, dtype=np.intp)


def _cycles(time: Array, angle: Array) -> list[tuple[float, float, float]]:
    """Return amplitude, frequency and damping ratio from every four consecutive turning points."""
    if len(time) < 4:
        return []
    sizes = np.abs(angle[1:-1] - (angle[:-2] + angle[2:]) / 2) / 2
    found = []
    for k in range(len(sizes) - 1):
        fall = float(np.log(sizes[k] / sizes[k + 1]))
        cycle = float(time[k + 3] - time[k]) / 1.5
        found.append((float(np.sqrt(sizes[k] * sizes[k + 1])), 1 / cycle, fall / float(np.hypot(np.pi, fall))))
    return found


def _trend(swings: list[Swing], values: list[float]) -> Estimate:
    """Return the relative change of values when the amplitude doubles, relative to the mean of each group."""
    groups = [swing.group for swing in swings]
    doubled = np.log2([swing.amplitude for swing in swings])
    shares, centred = np.array(values, dtype=float), doubled.copy()
    for group in set(groups):
        members = np.array([each == group for each in groups])
        shares[members] = shares[members] / np.median(shares[members]) - 1
        centred[members] -= doubled[members].mean()
    if len(swings) < _CYCLES or np.ptp(centred) < np.log2(_RANGE):
        return Estimate(np.nan)
    trials = [swing.trial for swing in swings]
    slope, own = slope_of(centred, shares, trials), []
    for name in dict.fromkeys(trials):  # a trend in a single trial is not significant
        inside = np.array([trial == name for trial in trials])
        if inside.sum() >= _CYCLES and np.ptp(centred[inside]) >= np.log2(_RANGE):
            own.append(slope_of(centred[inside], shares[inside], range(int(inside.sum()))).value)
    return Estimate(slope.value, min(slope.low, *own, slope.low), max(slope.high, *own, slope.high))


def _sign(trend: Estimate, least: float) -> int:
    return int(np.sign(trend.value)) if trend.excludes_zero and abs(trend.value) > least else 0
