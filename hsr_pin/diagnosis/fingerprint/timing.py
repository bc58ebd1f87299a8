"""Times of rise and fall: how long after a step of the command the arm has gone a tenth, half and nine tenths of its way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.commands import Step, steps
from hsr_pin.diagnosis.fingerprint.bending import Bending, bending
from hsr_pin.diagnosis.fingerprint.prints import Print, counted, said
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, mean_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: A step is looked at if the arm goes by so many noises [rad], and by this share of the largest way.
_SURE, _LARGE = 25.0, 0.1
#: ... if it has settled at its end to within this share of its way, and if no gap hides this share of the time for half of it.
_SETTLED, _GAP = 0.05, 0.25
#: A tenth of the way takes a spring, a mass and a damper this share of the time for half of it, undamped; less by the second
#: number for every unit of the damping ratio, up to critical (two poles, the step response read off: right to 0.002).
_UNDAMPED, _BY_DAMPING = 0.431, 0.114
#: It is later if by more than this share of the time for half the way and this share of a sample: waves of the arm do so much.
_MARGIN, _SAMPLES = 0.02, 0.1
#: So many noises are no overshoot.
_NOISE = 4.0
#: Rise and fall are unequal if their times differ by more than this share: gravity makes them differ by less.
_UNEQUAL = 0.25
#: No more curves than these are drawn.
_CURVES = 24


@dataclass(frozen=True)
class StepTimes:
    """One step of the command and the arm's answer.

    Attributes:
        trial: its name.
        rises: the size of the command grows.
        way: [rad] of bending.
        start: [s] after the step at which a fiftieth of the way is gone.
        tenth, half, most: [s] for a tenth, half and nine tenths.
        allowed: the largest share of ``half`` that ``tenth`` may be for a spring, a mass and a damper that swing back as far.
        elapsed, share: (S,) [s] since the step, and how much of the way is gone then.
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
        """[s] from a tenth to nine tenths."""
        return self.most - self.tenth


@dataclass(frozen=True, eq=False)
class Timing(Print):
    """Times of rise and fall.

    Attributes:
        steps: those that can be looked at.
        resolution: [s] between samples.
        lateness: time for a tenth of the way over that for half of it.
        excess: by how much that is more than what a spring, a mass and a damper allow.
        rise, fall: [s] from a tenth to nine tenths.
        ratio: duration of a fall over that of a rise, by trial.
        half_ratio: the same of the times for half the way.
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
        """Whether the arm starts later than a spring, a mass and a damper would under a torque that comes at once."""
        half = float(np.median([step.half for step in self.steps]))
        return self.excess.low > 0 and self.excess.value > _MARGIN + _SAMPLES * self.resolution / half

    @property
    def unequal(self) -> bool:
        """Whether rise and fall take different times."""
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
                f"the arm {slow} {said(factor)} times as slowly as it {fast} (10 to 90 % of the way: {said(self.fall.value)} s "
                f"down, {said(self.rise.value)} s up)"
            )
        tenth, half = (float(np.median([getattr(step, name) for step in shown])) for name in ("tenth", "half"))
        share, most = said(self.lateness.value), said(self.lateness.value - self.excess.value)
        if not found and not self.late:
            steps = counted(len(shown), "step")
            return f"In {steps} the arm is half-way after {said(half)} s, a tenth at {share} of that: no torque that comes late."
        if self.late:
            found.append(
                f"{where} it takes {said(tenth)} s for a tenth of its way and {said(half)} s for half, later at first than a "
                f"spring, a mass and a damper can be (a tenth at {share} of the time for half, at most {most})"
            )
        text = " and ".join(found)
        why = "filling and venting that differ" if self.unequal else "a torque that comes late: a lag or a delay"
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
        """Share of the way against time since the step."""
        longest = 2.5 * max(step.most for step in self.steps)
        for rises, role, line, label in ((True, "model", "-", "rise"), (False, "declared", (0, (4, 2)), "fall")):
            chosen = [step for step in self.steps if step.rises is rises]
            for index, step in enumerate(chosen[:: max(1, -(-len(chosen) // _CURVES))]):
                shown = step.elapsed <= longest
                name = f"{label} ({len(chosen)})" if index == 0 else None
                axes.plot(step.elapsed[shown], step.share[shown], color=ROLES[role], ls=line, lw=1.1, label=name)
                axes.plot([step.tenth, step.half, step.most], [0.1, 0.5, 0.9], "o", ms=3, color=ROLES["ink"], mew=0)
        axes.set_xlim(0, longest)
        axes.set_ylim(-0.1, 1.35)
        axes.set(xlabel="time since the step [s]", ylabel="share of the way")
        axes.grid()
        axes.legend(loc="lower right")


def timing(experiment: Experiment) -> Timing | None:
    """Times of rise and fall; None without steps that the arm follows and settles after."""
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
    """When ``share`` first reaches a level, on the straight line between samples; None if it never does."""
    above = np.flatnonzero(share >= level)
    if not len(above):
        return None
    at = int(above[0])
    return float(time[0]) if at == 0 else _between(time, share, at - 1, level)


def _last(time: Array, share: Array, level: float) -> float | None:
    """When ``share`` was last below a level; the first time if it never was."""
    below = np.flatnonzero(share < level)
    if not len(below):
        return float(time[0]) if len(time) else None
    at = int(below[-1])
    return None if at + 1 == len(share) else _between(time, share, at, level)


def _between(time: Array, share: Array, at: int, level: float) -> float:
    part = (level - share[at]) / (share[at + 1] - share[at])
    return float(time[at] + part * (time[at + 1] - time[at]))


def _ratio(found: list[StepTimes], time: str) -> Estimate:
    """A time of a fall over that of a rise, of the trials that have both."""
    by_trial: dict[str, dict[bool, list[float]]] = {}
    for step in found:
        by_trial.setdefault(step.trial, {True: [], False: []})[step.rises].append(np.log(getattr(step, time)))
    paired = [float(np.mean(both[False]) - np.mean(both[True])) for both in by_trial.values() if both[True] and both[False]]
    return Estimate(*(float(np.exp(bound)) for bound in mean_of(paired)))
