"""Frequency and damping over amplitude, from free decays: after a release, or after the last change of a command.

An amplitude is half the distance of a turning point from the middle of its neighbours, so that neither the place of rest nor a
steady drift of it plays a part. Viscous damping takes the same share of every cycle; dry friction takes the same amount, and so
the larger a share the smaller the cycle; damping that grows with speed takes more of large ones (B. F. Feeny, J. W. Liang,
A decrement method for the simultaneous estimation of Coulomb and viscous friction, Journal of Sound and Vibration 195, 1996).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.fingerprint.bending import Bending, bending
from hsr_pin.diagnosis.fingerprint.prints import Print, counted, logarithmic, said
from hsr_pin.diagnosis.smooth import smoothed
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, slope_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Turning points count while neighbours are so many noises apart, and so much of the largest distance.
_SURE, _SMALLEST = 12.0, 0.02
#: A trend needs so many cycles, over amplitudes that differ by this factor.
_CYCLES, _RANGE = 5, 2.0
#: Damping changes with amplitude if doubling it changes the damping ratio by more than this share; frequency likewise.
_DAMPING, _FREQUENCY = 0.12, 0.015
#: A payload slows the swing to this share of its frequency, or less, before damping ratios are held against one another, over so
#: many cycles; of a damper's it is more than chance by this many standard errors.
_SLOWED, _ENOUGH, _CERTAIN = 0.8, 5, 3.0
#: Sign of the change of damping and of frequency with amplitude -> what it points to.
_MEANING = {
    (1, 0): "damping that grows with speed, or hysteresis that slips in large cycles only",
    (-1, 0): "friction, which takes more of small cycles",
    (0, 1): "a stiffness that grows with bending, or a contact",
    (0, -1): "hysteresis, or a stiffness that falls with bending",
    (1, 1): "damping that grows with speed beside a stiffness that grows with bending, or to a contact",
    (1, -1): "hysteresis, or damping that grows with speed beside a stiffness that falls with bending",
    (-1, 1): "friction beside a stiffness that grows with bending, or play",
    (-1, -1): "friction or hysteresis, which hold small cycles faster and take more of them",
}


class Swing(NamedTuple):
    """One cycle of a decay.

    Attributes:
        trial: its name.
        group: declared stiffness [Nm/rad], payload [kg] and command [N m]: cycles of one group should be alike.
        amplitude: [rad] of bending.
        frequency: [Hz].
        damping: damping ratio.
    """

    trial: str
    group: tuple[float, float, float]
    amplitude: float
    frequency: float
    damping: float


class Loaded(NamedTuple):
    """Cycles of like amplitudes without a payload, or with a light one, and with a heavier one, whose damping no damper can do.

    Attributes:
        light, heavy: [kg].
        frequencies: [Hz] medians of both.
        ratios: damping ratios, medians of both.
    """

    light: float
    heavy: float
    frequencies: tuple[float, float]
    ratios: tuple[float, float]

    @property
    def damper(self) -> float:
        """Damping ratio with the heavier payload of a viscous damper that has the other's without: it goes with the frequency."""
        return self.ratios[0] * self.frequencies[1] / self.frequencies[0]

    @property
    def sentence(self) -> str:
        """What it points to."""
        light, heavy = (f"{1e3 * mass:.0f} g" for mass in (self.light, self.heavy))
        fast, slow, before, after = map(said, (*self.frequencies, *self.ratios))
        return (
            f" With {heavy} at the tip in place of {light} it swings at {slow} Hz, not {fast}, and the damping ratio of like "
            f"cycles is {after}, not {before}, where a viscous damper's falls to {said(self.damper)}: this points to relaxation, "
            "or friction."
        )


@dataclass(frozen=True, eq=False)
class Decay(Print):
    """Frequency and damping over amplitude.

    Attributes:
        swings: cycles.
        damping_trend: by what share of its mean the damping ratio grows where the amplitude doubles.
        frequency_trend: the same of the frequency.
        loaded: where a payload slows the arm, and its damping ratio does not fall as a viscous damper's.
    """

    swings: tuple[Swing, ...]
    damping_trend: Estimate
    frequency_trend: Estimate
    loaded: Loaded | None = None
    name: ClassVar[str] = "decay"
    title: ClassVar[str] = "Free decay: damping and frequency over amplitude"

    @property
    def damps(self) -> int:
        """1: more at large amplitudes, -1: more at small ones, 0: neither is certain."""
        return _sign(self.damping_trend, _DAMPING)

    @property
    def hardens(self) -> int:
        """1: faster at large amplitudes, -1: faster at small ones, 0: neither is certain."""
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
            f"In {counted(len(self.swings), 'cycle')} the arm swings at {_range(low, high)} Hz with a damping ratio of "
            f"{said(float(np.median(damping)))}"
        )
        if not np.isfinite(self.damping_trend.low):
            return f"{text}: too few cycles or amplitudes too alike to tell how they change with amplitude."
        changes = []
        if self.damps:
            changes.append(f"the damping ratio changes by {said(100 * self.damping_trend.value)} %")
        if self.hardens:
            changes.append(f"the frequency {'' if changes else 'changes '}by {said(100 * self.frequency_trend.value)} %")
        after = self.loaded.sentence if self.loaded else ""
        if not changes:
            return f"{text}, whatever the amplitude{'' if after else ': as a spring and a viscous damper would'}.{after}"
        meaning = _MEANING[self.damps, self.hardens]
        return f"{text}; where the amplitude doubles {' and '.join(changes)}: this points to {meaning}.{after}"

    def numbers(self) -> dict[str, Any]:
        return {
            "swings": [{**swing._asdict(), "group": list(swing.group)} for swing in self.swings],
            "damping_trend": self.damping_trend,
            "frequency_trend": self.frequency_trend,
            "loaded": {**self.loaded._asdict(), "damper": self.loaded.damper} if self.loaded else None,
        }

    def draw(self, axes: Axes) -> None:
        """Damping ratio against amplitude (dots), frequency on the other axis (rings)."""
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
    """Frequency and damping over amplitude; None where nothing swings freely through four turning points."""
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
    falls = experiment.dataset.mount != "upright"  # there a payload takes from what brings the arm back
    return Decay(tuple(swings), damping, frequency, _loaded(swings) if falls else None)


def _loaded(swings: list[Swing]) -> Loaded | None:
    """Two payloads of one stiffness and command, of which the heavier has a damping ratio that is clearly no damper's."""
    alike: dict[tuple[float, float], dict[float, list[Swing]]] = {}
    for swing in swings:
        keq, payload, command = swing.group
        alike.setdefault((keq, command), {}).setdefault(payload, []).append(swing)
    for of_payload in alike.values():
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
    """When a motion turns [s], and where [rad]: alternately up and down, as long as it is told from noise."""
    if len(time) < 8:
        return np.empty(0), np.empty(0)
    step = motion.run.step
    even = np.arange(time[0], time[-1] + step / 2, step)
    values = np.interp(even, time, angle)
    least = max(_SURE * motion.noise, _SMALLEST * float(np.ptp(values)))
    at = _alternating(values, least)
    if len(at) > 2:  # with the noise evened out over a sixth of a cycle
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
    """Indices of highest and lowest points in turn, neighbours at least so far apart; the first and the last may be ends."""
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
    """Amplitude, frequency and damping ratio from every four turning points."""
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
    """By what share of their mean values grow where the amplitude doubles, groups apart."""
    groups = [swing.group for swing in swings]
    doubled = np.log2([swing.amplitude for swing in swings])
    shares, apart = np.array(values, dtype=float), doubled.copy()
    for group in set(groups):
        members = np.array([each == group for each in groups])
        shares[members] = shares[members] / np.median(shares[members]) - 1
        apart[members] -= doubled[members].mean()
    if len(swings) < _CYCLES or np.ptp(apart) < np.log2(_RANGE):
        return Estimate(np.nan, -np.inf, np.inf)
    trials = [swing.trial for swing in swings]
    slope, own = slope_of(apart, shares, trials), []
    for name in dict.fromkeys(trials):  # what is so in one trial only is not certain
        inside = np.array([trial == name for trial in trials])
        if inside.sum() >= _CYCLES and np.ptp(apart[inside]) >= np.log2(_RANGE):
            own.append(slope_of(apart[inside], shares[inside], range(int(inside.sum()))).value)
    return Estimate(slope.value, min(slope.low, *own, slope.low), max(slope.high, *own, slope.high))


def _sign(trend: Estimate, least: float) -> int:
    return int(np.sign(trend.value)) if trend.certain and abs(trend.value) > least else 0


def _range(low: float, high: float) -> str:
    return said(low) if said(low) == said(high) else f"{said(low)} to {said(high)}"
