"""Creep: slow motion in the direction of a step or release after its transient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.indicators.bending import Bending, bending
from hsr_pin.diagnosis.indicators.decay import turning_points
from hsr_pin.diagnosis.indicators.indicator import Indicator, counted, logarithmic, rounded, thinned
from hsr_pin.diagnosis.indicators.timing import crossing
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, mean_by_trial
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The transient ends this many time constants after half the displacement (0.1 % of a first-order lag remains then) ...
_OVER = 6.2
#: ... of the first-order lag with the same time from a quarter to half of the displacement, which is this share of its time
#: constant,
_QUARTER = 0.405
#: ... and when the oscillation is below this share of the displacement.
_SWING = 0.02
#: The drift is measured if the record lasts until this multiple of the end of the transient.
_LASTS = 1.5
#: Least displacement, in standard deviations of noise.
_NOISES = 60.0
#: Least drift per decade of time that counts as creep, as a share of the displacement.
_CREEPS = 0.01
_CURVES = 24


@dataclass(frozen=True)
class Drift:
    """Drift after the transient of one step or release.

    Attributes:
        trial: name of the trial.
        released: whether it follows a release; otherwise it follows a step.
        begin, end: time interval after the step in which the drift is measured [s].
        decade: drift per decade of time, as a share of the displacement.
        elapsed, share: (S,) time since the step [s], and share of the displacement.
    """

    trial: str
    released: bool
    begin: float
    end: float
    decade: float
    elapsed: Array
    share: Array


@dataclass(frozen=True, eq=False)
class Creep(Indicator):
    """Slow drift after the transient, as a function of the logarithm of time.

    Attributes:
        drifts: drift after each step or release.
        decade: mean drift per decade of time, as a share of the displacement.
    """

    drifts: tuple[Drift, ...]
    decade: Estimate
    name: ClassVar[str] = "creep"
    title: ClassVar[str] = "After the transient"

    @property
    def creeps(self) -> bool:
        """Whether the drift in the direction of the displacement is significant."""
        middle = float(np.median([drift.decade for drift in self.drifts]))
        return (
            self.decade.low > 0 and self.decade.value > _CREEPS and middle > _CREEPS / 2
        )  # the median excludes a drift of a few steps only

    @property
    def kinds(self) -> tuple[str, ...]:
        if not self.creeps:
            return ()
        return ("creep",) if all(drift.released for drift in self.drifts) else ("creep", "actuation_time")

    @property
    def sentence(self) -> str:
        begin, end = (float(np.median([getattr(drift, name) for drift in self.drifts])) for name in ("begin", "end"))
        after = " and ".join(
            counted(count, thing)
            for thing, released in (("step", False), ("release", True))
            if (count := sum(drift.released is released for drift in self.drifts))
        )
        text = f"From {rounded(begin)} to {rounded(end)} s after {after} the arm"
        share = f"{rounded(100 * abs(self.decade.value))} % of its displacement per decade of time"
        if self.creeps:
            also = "" if self.kinds == ("creep",) else ", or to a supply that is still filling"
            low, high = rounded(100 * self.decade.low), rounded(100 * self.decade.high)
            return f"{text} continues to move by {share} ({low} to {high} %): this points to creep{also}."
        if not np.isfinite(self.decade.low):
            return f"{text} moves by {share}: a single observation is not conclusive."
        if self.decade.high < 0 and -self.decade.value > _CREEPS:
            return f"{text} moves back by {share}: this is not creep; the input or the measurement may drift."
        reach = rounded(100 * max(abs(self.decade.low), abs(self.decade.high)))
        return f"{text} does not move (to within {reach} % of its displacement per decade of time): no creep is visible."

    def numbers(self) -> dict[str, Any]:
        return {
            "decade": self.decade,
            "drifts": [
                {name: getattr(drift, name) for name in ("trial", "released", "begin", "end", "decade")} for drift in self.drifts
            ],
        }

    def draw(self, axes: Axes) -> None:
        """Draw the share of the displacement against the logarithm of time; creep is a rising line."""
        for drift in thinned(self.drifts, _CURVES):
            late = drift.elapsed >= drift.begin
            axes.plot(drift.elapsed, drift.share, color=ROLES["faint"], lw=0.5, alpha=0.6)
            axes.plot(drift.elapsed[late], drift.share[late], color=ROLES["model"], lw=1.0)
        axes.axhline(1.0, color=ROLES["noise"], lw=1, ls=(0, (4, 3)))
        seen = np.concatenate([drift.share[drift.elapsed >= drift.begin] for drift in self.drifts])
        low, high = np.percentile(seen, [1, 99])
        middle, reach = (low + high) / 2, max(0.03, 1.5 * (high - low))
        axes.set_ylim(middle - reach, middle + reach)
        logarithmic(axes)
        axes.set_xlim(min(drift.begin for drift in self.drifts) / 6, 1.05 * max(drift.end for drift in self.drifts))
        axes.set(xlabel="time since the step or release [s], logarithmic", ylabel="share of the displacement")
        axes.grid()


def creep(experiment: Experiment) -> Creep | None:
    """Return the drift after transients; None if no plateau or release lasts long enough."""
    drifts: list[Drift] = []
    for run in experiment.runs:
        motion, before = bending(run, experiment), None
        for plateau in plateaus(run):
            released = before is None and run.start_pose is not None
            first, last = motion.span(plateau)
            time, angle = motion.between(first, last)
            origin = motion.start if released else before
            if origin is not None and len(time) > 20:
                drift = _drift(motion, time, angle, origin, released)
                drifts += [drift] if drift is not None else []
            before = motion.settled(plateau)
    if not drifts:
        return None
    return Creep(tuple(drifts), mean_by_trial([drift.decade for drift in drifts], [drift.trial for drift in drifts]))


def _drift(motion: Bending, time: Array, angle: Array, origin: float, released: bool) -> Drift | None:
    displacement = float(np.median(angle[-max(3, len(angle) // 10) :])) - origin
    if not abs(displacement) > _NOISES * motion.noise:
        return None
    elapsed, share = time - time[0] + motion.run.step / 2, (angle - origin) / displacement
    quarter, half = crossing(elapsed, share, 0.25), crossing(elapsed, share, 0.5)
    if quarter is None or half is None:
        return None
    begin = half + _OVER * (half - quarter) / _QUARTER
    turns, where = turning_points(time, angle, motion)
    if len(turns) > 1:
        large = np.flatnonzero(np.abs(np.diff(where)) > _SWING * abs(displacement))
        if len(large):  # until the cycle after the last large one ends
            begin = max(begin, float(turns[large[-1] + 1] - time[0]) + 2 * float(np.median(np.diff(turns))))
    late = elapsed >= begin
    if not elapsed[-1] > _LASTS * begin or late.sum() < 10:
        return None
    slope = float(np.polyfit(np.log10(elapsed[late]), share[late], 1)[0])
    return Drift(motion.run.trial.name, released, begin, float(elapsed[-1]), slope, elapsed, share)
