"""Creep: how the arm goes on bending, the same way, long after it has gone to where a step or a release sent it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.fingerprint.bending import Bending, bending
from hsr_pin.diagnosis.fingerprint.decay import turning_points
from hsr_pin.diagnosis.fingerprint.prints import Print, counted, logarithmic, said
from hsr_pin.diagnosis.fingerprint.timing import crossing
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The transient is over so many time constants after half the way (a lag leaves 0.1 % of it then) ...
_OVER = 6.2
#: ... of the lag that takes as long from a quarter of the way to half of it: this share of its time constant.
_QUARTER = 0.405
#: ... and once it swings by less than this share of the way.
_SWING = 0.02
#: What follows is looked at if it lasts until so many times as long after the step.
_LASTS = 1.5
#: The way is long enough to tell if it is so many noises.
_SURE = 60.0
#: It is creep if the arm goes on by this share of its way in a decade of time.
_CREEPS = 0.01
_CURVES = 24


@dataclass(frozen=True)
class Drift:
    """What follows the transient of one step or release.

    Attributes:
        trial: its name.
        released: after a release; else after a step.
        begin, end: [s] after it between which it is looked at.
        decade: share of the way by which the arm goes on in a decade of time.
        elapsed, share: (S,) [s] since then, and share of the way gone.
    """

    trial: str
    released: bool
    begin: float
    end: float
    decade: float
    elapsed: Array
    share: Array


@dataclass(frozen=True, eq=False)
class Creep(Print):
    """Slow drift after the transient, over the logarithm of time.

    Attributes:
        drifts: after each step or release.
        decade: mean share of the way by which the arm goes on in a decade of time.
    """

    drifts: tuple[Drift, ...]
    decade: Estimate
    name: ClassVar[str] = "creep"
    title: ClassVar[str] = "After the transient"

    @property
    def creeps(self) -> bool:
        """Whether the arm certainly goes on the way that it was sent."""
        middle = float(np.median([drift.decade for drift in self.drifts]))
        return self.decade.low > 0 and self.decade.value > _CREEPS and middle > _CREEPS / 2  # not of a few steps only

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
        text = f"From {said(begin)} to {said(end)} s after {after} the arm"
        share = f"{said(100 * abs(self.decade.value))} % of its way in a decade of time"
        if self.creeps:
            also = "" if self.kinds == ("creep",) else ", or to a supply that goes on filling"
            low, high = said(100 * self.decade.low), said(100 * self.decade.high)
            return f"{text} goes on by {share} ({low} to {high} %): this points to creep{also}."
        if not np.isfinite(self.decade.low):
            return f"{text} moves by {share}: once only, too little to tell."
        if self.decade.high < 0 and -self.decade.value > _CREEPS:
            return f"{text} comes back by {share}: not the way of creep; the input or the measurement may drift."
        reach = said(100 * max(abs(self.decade.low), abs(self.decade.high)))
        return f"{text} stays where it is (to {reach} % of its way in a decade of time): no creep to be seen."

    def numbers(self) -> dict[str, Any]:
        return {
            "decade": self.decade,
            "drifts": [
                {name: getattr(drift, name) for name in ("trial", "released", "begin", "end", "decade")} for drift in self.drifts
            ],
        }

    def draw(self, axes: Axes) -> None:
        """Share of the way against time since the step, logarithmic: creep is a line that rises."""
        for drift in self.drifts[:: max(1, -(-len(self.drifts) // _CURVES))]:
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
        axes.set(xlabel="time since the step or release [s], logarithmic", ylabel="share of the way")
        axes.grid()


def creep(experiment: Experiment) -> Creep | None:
    """Slow drift after the transients; None where no plateau or release goes on long enough after them."""
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
    decades = np.array([drift.decade for drift in drifts])
    return Creep(tuple(drifts), coefficients_of(np.ones((len(drifts), 1)), decades, [drift.trial for drift in drifts])[0])


def _drift(motion: Bending, time: Array, angle: Array, origin: float, released: bool) -> Drift | None:
    way = float(np.median(angle[-max(3, len(angle) // 10) :])) - origin
    if not abs(way) > _SURE * motion.noise:
        return None
    elapsed, share = time - time[0] + motion.run.step / 2, (angle - origin) / way
    quarter, half = crossing(elapsed, share, 0.25), crossing(elapsed, share, 0.5)
    if quarter is None or half is None:
        return None
    begin = half + _OVER * (half - quarter) / _QUARTER
    turns, where = turning_points(time, angle, motion)
    if len(turns) > 1:
        large = np.flatnonzero(np.abs(np.diff(where)) > _SWING * abs(way))
        if len(large):  # until the swing after the last large one is over
            begin = max(begin, float(turns[large[-1] + 1] - time[0]) + 2 * float(np.median(np.diff(turns))))
    late = elapsed >= begin
    if not elapsed[-1] > _LASTS * begin or late.sum() < 10:
        return None
    slope = float(np.polyfit(np.log10(elapsed[late]), share[late], 1)[0])
    return Drift(motion.run.trial.name, released, begin, float(elapsed[-1]), slope, elapsed, share)
