"""Rise and fall times: the times after a step of the command for 10, 50 and 90 % of the displacement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.commands import Step, steps
from hsr_pin.diagnosis.indicators.bending import Bending, bending
from hsr_pin.diagnosis.indicators.indicator import Indicator, counted, rounded, thinned
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, mean_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: A step is used if its displacement exceeds this multiple of the noise, and this share of the largest displacement ...
_SURE, _LARGE = 25.0, 0.1
#: ... if the arm settles to within this share of it, and no gap is longer than this share of the time for half of it.
_SETTLED, _GAP = 0.05, 0.25
#: Ratio of the times for 10 and 50 % of the displacement of an undamped mass-spring-damper system, and its decrease per unit of
#: the damping ratio up to critical damping (from the step response of two poles, accurate to 0.002).
_UNDAMPED, _BY_DAMPING = 0.431, 0.114
#: Least significant excess of this ratio, and in samples, because waves along the arm cause smaller ones.
_MARGIN, _SAMPLES = 0.02, 0.1
#: Least overshoot, in standard deviations of noise.
_NOISE = 4.0
#: Least significant relative difference between rise and fall times, because gravity causes smaller ones.
_UNEQUAL = 0.25
#: Largest number of curves in the figure.
_CURVES = 24


@dataclass(frozen=True)
class StepTimes:
    """One step of the command and the response of the arm.

    Attributes:
        trial: name of the trial.
        rises: whether the magnitude of the command increases.
        way: displacement of the bending angle [rad].
        start: time after the step for 2 % of the displacement [s].
        tenth, half, most: times for 10, 50 and 90 % of the displacement [s].
        allowed: largest ratio of ``tenth`` to ``half`` of a mass-spring-damper system with the same overshoot.
        elapsed, share: (S,) time since the step [s], and share of the displacement.
    """

    trial: str
    rises: bool
    way: float
    start: float
    tenth: float
    half: float
    most: float
    allowed: float
    elapsed: Array
    share: Array

    @property
    def duration(self) -> float:
        """Time from 10 to 90 % of the displacement [s]."""
        return self.most - self.tenth


@dataclass(frozen=True, eq=False)
class Timing(Indicator):
    """Rise and fall times.

    Attributes:
        steps: the steps that can be evaluated.
        resolution: sampling interval [s].
        lateness: ratio of the times for 10 and 50 % of the displacement.
        excess: lateness minus the largest value of a mass-spring-damper system.
        rise, fall: times from 10 to 90 % [s].
        ratio: duration of a fall over that of a rise, by trial.
        half_ratio: the same ratio for the times for half the displacement.
    """

    steps: tuple[StepTimes, ...]
    resolution: float
    lateness: Estimate
    excess: Estimate
    rise: Estimate
    fall: Estimate
    ratio: Estimate
    half_ratio: Estimate
    name: ClassVar[str] = "timing"
    title: ClassVar[str] = "Times of rise and fall"

    @property
    def late(self) -> bool:
        """Whether the response starts later than that of a mass-spring-damper system without a delay."""
        half = float(np.median([step.half for step in self.steps]))
        return self.excess.low > 0 and self.excess.value > _MARGIN + _SAMPLES * self.resolution / half

    @property
    def unequal(self) -> bool:
        """Whether rise and fall have different durations."""
        both = (self.ratio, self.half_ratio)
        return all(ratio.low > 1 and ratio.value > 1 + _UNEQUAL for ratio in both) or all(
            ratio.high < 1 and ratio.value < 1 / (1 + _UNEQUAL) for ratio in both
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("actuation_time",) if self.late or self.unequal else ()

    @property
    def sentence(self) -> str:
        shown, where, found = self.steps, "after a step", []
        if self.unequal:
            slow, fast = ("falls", "rises") if self.ratio.value > 1 else ("rises", "falls")
            factor = max(self.ratio.value, 1 / self.ratio.value)
            shown = tuple(step for step in self.steps if step.rises is (fast == "rises"))
            where = f"even where it {fast}"
            found.append(
                f"the arm {slow} {rounded(factor)} times as slowly as it {fast} (10 to 90 % of the step: "
                f"{rounded(self.fall.value)} s down, {rounded(self.rise.value)} s up)"
            )
        tenth, half = (float(np.median([getattr(step, name) for step in shown])) for name in ("tenth", "half"))
        share, most = rounded(self.lateness.value), rounded(self.lateness.value - self.excess.value)
        if not found and not self.late:
            text = f"In {counted(len(shown), 'step')} the arm moves half-way in {rounded(half)} s"
            return f"{text}, and a tenth in {share} of this time: the torque is not late."
        if self.late:
            found.append(
                f"{where} the arm takes {rounded(tenth)} s for a tenth of its displacement and {rounded(half)} s for half, "
                f"a later onset than that of a mass-spring-damper system (ratio {share}, at most {most})"
            )
        text = " and ".join(found)
        why = "different filling and venting" if self.unequal else "a lag or a delay of the torque"
        return f"{text[0].upper()}{text[1:]}: this points to {why}."

    def numbers(self) -> dict[str, Any]:
        return {
            "steps": [
                {
                    "trial": step.trial,
                    "rises": step.rises,
                    "way_rad": step.way,
                    "start_s": step.start,
                    "tenth_s": step.tenth,
                    "half_s": step.half,
                    "most_s": step.most,
                }
                for step in self.steps
            ],
            "lateness": self.lateness,
            "excess": self.excess,
            "rise_s": self.rise,
            "fall_s": self.fall,
            "fall_over_rise": self.ratio,
            "half_fall_over_rise": self.half_ratio,
        }

    def draw(self, axes: Axes) -> None:
        """Draw the share of the displacement against the time since the step."""
        longest = 2.5 * max(step.most for step in self.steps)
        for rises, role, line, label in ((True, "model", "-", "rise"), (False, "declared", (0, (4, 2)), "fall")):
            chosen = [step for step in self.steps if step.rises is rises]
            for index, step in enumerate(thinned(chosen, _CURVES)):
                shown = step.elapsed <= longest
                name = f"{label} ({len(chosen)})" if index == 0 else None
                axes.plot(step.elapsed[shown], step.share[shown], color=ROLES[role], ls=line, lw=1.1, label=name)
                axes.plot([step.tenth, step.half, step.most], [0.1, 0.5, 0.9], "o", ms=3, color=ROLES["ink"], mew=0)
        axes.set_xlim(0, longest)
        axes.set_ylim(-0.1, 1.35)
        axes.set(xlabel="time since the step [s]", ylabel="share of the displacement")
        axes.grid()
        axes.legend(loc="lower right")


def timing(experiment: Experiment) -> Timing | None:
    """Return rise and fall times; None without steps that the arm follows and after which it settles."""
    found: list[StepTimes] = []
    for run in experiment.runs:
        motion = bending(run, experiment)
        found += [times for step in steps(run) if (times := _times(motion, step)) is not None]
    if not found:
        return None
    largest = max(abs(step.way) for step in found)
    found = [step for step in found if abs(step.way) >= _LARGE * largest]
    rise, fall = (mean_of([step.duration for step in found if step.rises is rises]) for rises in (True, False))
    resolution = max(run.step for run in experiment.runs)
    lateness, excess = ([s.tenth / s.half - s.allowed * beyond for s in found] for beyond in (0, 1))
    ratios = (_ratio(found, "duration"), _ratio(found, "half"))
    return Timing(tuple(found), resolution, mean_of(lateness), mean_of(excess), rise, fall, *ratios)


def _times(motion: Bending, step: Step) -> StepTimes | None:
    before, after = motion.settled(step.before), motion.settled(step.after)
    instant, end = step.instant - float(motion.run.time[0]), motion.span(step.after)[1]
    time, angle = motion.between(instant, end)
    way = after - before
    if not abs(way) > _SURE * motion.noise or len(time) < 5:
        return None
    elapsed, share = time - instant, (angle - before) / way
    late = share[elapsed > 0.8 * elapsed[-1]]
    if len(late) < 2 or abs(np.polyfit(np.arange(len(late)), late, 1)[0]) * len(late) > _SETTLED:
        return None
    half = crossing(elapsed, share, 0.5)
    if half is None or not half > 0:
        return None
    early = elapsed <= half + 1e-9
    tenth, start = (_last(elapsed[: early.sum() + 1], share[: early.sum() + 1], level) for level in (0.1, 0.02))
    most = crossing(elapsed[~early], share[~early], 0.9)
    if tenth is None or most is None or start is None:
        return None
    gaps = np.diff(elapsed[elapsed <= most], prepend=0.0)
    if gaps.max() > max(_GAP * half, 1.5 * motion.run.step):
        return None
    back = max(0.0, float((np.maximum.accumulate(share) - share).max()) - _NOISE * motion.noise / abs(way))
    allowed = _UNDAMPED - _BY_DAMPING * _damping_ratio(back)
    rises = bool(abs(step.after.torque) > abs(step.before.torque))
    name = motion.run.trial.name
    return StepTimes(name, rises, way, start, tenth, half, most, allowed, elapsed, share)


def _damping_ratio(overshoot: float) -> float:
    if overshoot <= 0:
        return 1.0
    fall = -np.log(min(overshoot, 1.0))
    return float(fall / np.hypot(np.pi, fall))


def crossing(time: Array, share: Array, level: float) -> float | None:
    """Return when ``share`` first reaches a level, interpolated linearly; None if it never does."""
    above = np.flatnonzero(share >= level)
    if not len(above):
        return None
    at = int(above[0])
    return float(time[0]) if at == 0 else _between(time, share, at - 1, level)


def _last(time: Array, share: Array, level: float) -> float | None:
    """Return when ``share`` was last below a level, or the first time if it never was."""
    below = np.flatnonzero(share < level)
    if not len(below):
        return float(time[0]) if len(time) else None
    at = int(below[-1])
    return None if at + 1 == len(share) else _between(time, share, at, level)


def _between(time: Array, share: Array, at: int, level: float) -> float:
    part = (level - share[at]) / (share[at + 1] - share[at])
    return float(time[at] + part * (time[at + 1] - time[at]))


def _ratio(found: list[StepTimes], time: str) -> Estimate:
    """Return the ratio of a time of a fall to that of a rise, from trials that have both."""
    by_trial: dict[str, dict[bool, list[float]]] = {}
    for step in found:
        by_trial.setdefault(step.trial, {True: [], False: []})[step.rises].append(np.log(getattr(step, time)))
    paired = [float(np.mean(both[False]) - np.mean(both[True])) for both in by_trial.values() if both[True] and both[False]]
    return Estimate(*(float(np.exp(bound)) for bound in mean_of(paired)))
