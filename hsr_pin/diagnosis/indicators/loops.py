"""Hysteresis loops of bending over the command: whether the equilibrium depends on the direction of approach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.indicators.bending import Bending, bending
from hsr_pin.diagnosis.indicators.indicator import Indicator, rounded
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of, mean_by_trial, mean_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Two plateaus have the same command if they differ by less than this share of its range.
_SAME = 0.02
#: Part of a plateau that is compared with its last part to detect whether a loop fades.
_EARLY = (0.4, 0.6)
#: Least relative decrease of the width of a fading loop.
_FADES = 0.2
#: Largest oscillation of an arm at rest: in standard deviations of noise, or as a share of the range of bending.
_RINGS, _STILL = 2.0, 0.002
#: Least width of a loop as a share of the range of bending, and least width of cycles as a share of their height.
_NARROW, _NARROW_CYCLE = 0.01, 0.04
#: Cycles wider than this share of their height are too fast for the extrapolation to zero speed.
_FAST = 0.6
#: Least number of cycles for the extrapolation.
_CYCLES = 4


class Wait(NamedTuple):
    """Equilibrium under a command that was approached from below and from above, in one trial.

    Attributes:
        trial: name of the trial.
        command: torque over the declared stiffness [rad].
        width: additional bending when approached from above [rad]; half of the width if ``first``.
        early: the same width earlier on the plateaus [rad].
        first: whether one of the two is the initial equilibrium of the trial, whose direction of approach is unknown.
        size: range of the bending angle in the trial [rad].
    """

    trial: str
    command: float
    width: float
    early: float
    first: bool
    size: float


class Cycle(NamedTuple):
    """One cycle of a command without a plateau.

    Attributes:
        trial: name of the trial.
        frequency: frequency [Hz].
        width: width of the loop at the middle of the command [rad].
        height: height of the loop [rad].
    """

    trial: str
    frequency: float
    width: float
    height: float


@dataclass(frozen=True, eq=False)
class Loops(Indicator):
    """Hysteresis loops of bending over the command.

    Attributes:
        waits, cycles: the observations.
        standing: width of the loop in equilibrium over the range of bending, from plateaus approached from both sides.
        returned: displacement after returning to the first command, towards the side of the motion, over the range of bending.
        faded: width at the end of the plateaus minus that earlier, over the range of bending.
        still: width of the cycles extrapolated to zero speed, over their height.
        lag: additional delay of the cycles relative to the command [s].
        curves: (command [rad], bending [rad]) of each trial.
        points: (command [rad], bending [rad], side) at the ends of plateaus; side 1 from below, -1 from above, 0 unknown.
        noise: standard deviation of the bending angle [rad].
    """

    waits: tuple[Wait, ...]
    cycles: tuple[Cycle, ...]
    standing: Estimate
    returned: Estimate
    faded: Estimate
    still: Estimate
    lag: Estimate
    curves: tuple[tuple[Array, Array], ...]
    points: tuple[tuple[float, float, int], ...]
    noise: float
    name: ClassVar[str] = "loops"
    title: ClassVar[str] = "Bending over the command"

    @property
    def remains(self) -> bool:
        """Whether a loop remains at zero speed or in equilibrium."""
        return _wide(self.standing) or _wide(self.still, _NARROW_CYCLE) or _wide(self.returned)

    @property
    def fades(self) -> bool:
        """Whether the remaining loop narrows during the plateaus."""
        widths = [wait.width / wait.size for wait in self.waits]
        return (
            self.remains and self.faded.high < 0 and -self.faded.value > _FADES * (float(np.mean(widths)) - self.faded.value) > 0
        )

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("creep",) if self.fades else ("friction",) * self.remains

    @property
    def sentence(self) -> str:
        found = []
        if _wide(self.standing):
            width = _percent(self.standing)
            found.append(f"under the same command the arm is bent farther by {width} of its range if it is approached from above")
        elif _wide(self.returned):
            width = _percent(self.returned)
            found.append(
                f"after its return to the first command the arm stays displaced by {width} of its range to the side of the motion"
            )
        if not found and _wide(self.still, _NARROW_CYCLE):
            found.append(f"cycles of the command leave loops with a width of {_percent(self.still)} of their height at any speed")
        text = " and ".join(found)
        text = text[:1].upper() + text[1:]
        if self.fades:
            lately = rounded(-100 * self.faded.value)
            why = "creep, or to an input that still changes"
            return f"{text}; the loop narrows by {lately} % of the range towards the end of the plateaus: this points to {why}."
        if self.remains:
            return f"{text}; it does not fade during the plateaus: this points to friction or hysteresis."
        widths = [abs(known.value) for known in (self.standing, self.returned, self.still) if np.isfinite(known.value)]
        largest = rounded(100 * max(widths))
        return (
            f"The equilibrium does not depend on the side of approach (to {largest} % of the range): no lasting hysteresis loop."
        )

    def numbers(self) -> dict[str, Any]:
        return {
            "standing": self.standing,
            "returned": self.returned,
            "faded": self.faded,
            "still": self.still,
            "lag_s": self.lag,
            "waits": [wait._asdict() for wait in self.waits],
            "cycles": [cycle._asdict() for cycle in self.cycles],
        }

    def draw(self, axes: Axes) -> None:
        """Draw bending against command, with the equilibrium points."""
        for command, angle in self.curves:
            axes.plot(command, angle, color=ROLES["faint"], lw=0.5, alpha=0.6)
        for side, marker, role, label in (
            (1, "^", "model", "equilibrium, from below"),
            (-1, "v", "declared", "equilibrium, from above"),
            (0, "s", "measured", "initial"),
        ):
            here = [(command, angle) for command, angle, known in self.points if known == side]
            if here:
                axes.plot(*np.transpose(here), marker, ms=5, mew=0, color=ROLES[role], label=label, ls="none")
        axes.set(xlabel="command: torque over declared stiffness [rad]", ylabel="bending [rad]")
        axes.grid()
        if self.points:
            axes.legend(loc="upper left")


def _wide(width: Estimate, least: float = _NARROW) -> bool:
    return bool(width.low > 0 and width.value > least)


def _percent(width: Estimate) -> str:
    return f"{rounded(100 * width.value)} % ({rounded(100 * width.low)} to {rounded(100 * width.high)} %)"


def loops(experiment: Experiment) -> Loops | None:
    """Return hysteresis loops of bending over the command; None if no command is reached from two sides."""
    waits: list[Wait] = []
    cycles: list[Cycle] = []
    curves, points = [], []
    for run in experiment.runs:
        if not np.ptp(run.torque) > 0:
            continue
        motion = bending(run, experiment)
        stood = _stood(motion)
        waits += _waits(motion, stood)
        cycles += _cycles(motion)
        command = np.interp(motion.time, run.time - run.time[0], run.torque) / run.trial.keq
        curves.append((command, motion.angle))
        points += [(command, angle, side) for command, angle, _, side in stood]
    enough = [cycle for cycle in cycles if abs(cycle.width) < _FAST * cycle.height]
    whole = _by_trial([wait for wait in waits if not wait.first])
    back = _by_trial([wait for wait in waits if wait.first])
    faded = mean_of([(wait.width - wait.early) / wait.size for wait in waits])
    still, lag = _at_no_speed(enough)
    noise = float(np.median([bending(run, experiment).noise for run in experiment.runs]))
    if not waits and not np.isfinite(still.value):
        return None
    return Loops(tuple(waits), tuple(cycles), whole, back, faded, still, lag, tuple(curves), tuple(points), noise)


def _stood(motion: Bending) -> list[tuple[float, float, float, int]]:
    """Return command [rad], final and earlier bending [rad] and side of each plateau at whose end the arm is at rest."""
    found, before = [], None
    quiet = max(_RINGS * motion.noise, _STILL * float(np.ptp(motion.angle)))
    for plateau in plateaus(motion.run):
        first, last = motion.span(plateau)
        sooner = motion.between(*(first + part * (last - first) for part in _EARLY))[1]
        side = 0 if before is None else int(np.sign(plateau.torque - before))
        early = float(np.median(sooner)) if len(sooner) else np.nan
        if motion.ringing(plateau) < quiet:
            found.append((plateau.torque / motion.run.trial.keq, motion.settled(plateau), early, side))
        before = plateau.torque
    return found


def _waits(motion: Bending, stood: list[tuple[float, float, float, int]]) -> list[Wait]:
    reach = float(np.ptp([command for command, *_ in stood])) if stood else 0.0
    size = float(np.ptp([angle for _, angle, *_ in stood])) if stood else 0.0
    if not size > 50 * motion.noise:
        return []
    name, found = motion.run.trial.name, []
    for index, (command, angle, early, side) in enumerate(stood):
        for other, there, sooner, came in stood[:index]:
            if abs(command - other) > _SAME * reach or side * came > 0:
                continue
            sign = -side  # additional bending when approached from above
            first = came == 0
            found.append(Wait(name, command, sign * (angle - there), sign * (early - (there if first else sooner)), first, size))
    return found


def _by_trial(waits: list[Wait]) -> Estimate:
    """Return the mean width over the range of bending, with an interval from leaving out single trials."""
    if not waits:
        return Estimate(np.nan)
    return mean_by_trial([wait.width / wait.size for wait in waits], [wait.trial for wait in waits])


def _cycles(motion: Bending) -> list[Cycle]:
    run: Run = motion.run
    moving = np.ones(len(run.torque), dtype=bool)
    for plateau in plateaus(run):
        moving[plateau.first : plateau.last + 1] = False
    if moving.mean() < 0.5:  # steps and staircases
        return []
    time, middle = run.time - run.time[0], float(np.ptp(run.torque)) / 2 + float(run.torque.min())
    above = run.torque >= middle
    at = np.flatnonzero(np.diff(above))
    # A held command is late by half a sample on average.
    crossings = time[at] + run.step * (
        (middle - run.torque[at]) / (run.torque[at + 1] - run.torque[at]) + 0.5 * (not run.interpolated)
    )
    angle = np.interp(crossings, motion.time, motion.angle)
    found = []
    for index in range(len(at) - 1):
        shown = motion.between(crossings[index], crossings[index + 1])[1]
        if len(shown) < 3:
            continue
        later = index + 2 < len(at)
        before = motion.between(crossings[index + 1], crossings[index + 2])[1] if later else shown
        height = float(np.ptp(np.concatenate([shown, before])))
        if not later or not height > 25 * motion.noise:
            continue
        # the middle crossing minus the mean of its neighbours, so that a drift does not count as a loop
        sign = 1.0 if above[at[index] + 1] else -1.0
        width = sign * float(angle[index + 1] - (angle[index] + angle[index + 2]) / 2)
        found.append(Cycle(run.trial.name, float(1 / (crossings[index + 2] - crossings[index])), width, height))
    return found


def _at_no_speed(cycles: list[Cycle]) -> tuple[Estimate, Estimate]:
    """Return the ratio of width to height extrapolated to zero frequency, and the delay [s] that explains the rest."""
    nothing = Estimate(np.nan)
    if len(cycles) < _CYCLES or np.ptp([cycle.frequency for cycle in cycles]) < 0.5 * min(cycle.frequency for cycle in cycles):
        return nothing, nothing
    frequency = np.array([cycle.frequency for cycle in cycles])
    angle = np.arcsin([cycle.width / cycle.height for cycle in cycles])  # phase lag of an ellipse of this width
    design = np.stack([np.ones(len(cycles)), 2 * np.pi * frequency], axis=1)
    still, lag = coefficients_of(design, angle, [cycle.trial for cycle in cycles])
    return still, lag
