"""Loops of bending over the input: whether the arm stands elsewhere, under the same command, by the side that it came from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.diagnosis.commands import plateaus
from hsr_pin.diagnosis.fingerprint.bending import Bending, bending
from hsr_pin.diagnosis.fingerprint.prints import Print, said
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of, mean_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Two plateaus are at the same command if they differ by less than this share of the command's range.
_SAME = 0.02
#: Part of a plateau over which it is seen whether a loop fades while the arm waits, beside the last part.
_EARLY = (0.4, 0.6)
#: It fades if it narrows between them by more than this share.
_FADES = 0.2
#: The arm stands still if it rings by less than so many noises, or this share of the bending's range.
_RINGS, _STILL = 2.0, 0.002
#: A loop narrower than this share of the bending's range, is none; nor one of cycles narrower than this of their height.
_NARROW, _NARROW_CYCLE = 0.01, 0.04
#: Cycles wider than this share of their height are too fast to tell what is left at no speed.
_FAST = 0.6
#: Fewer cycles cannot tell it either.
_CYCLES = 4


class Wait(NamedTuple):
    """The arm standing under a command that it reached from below and from above, in one trial.

    Attributes:
        trial: its name.
        command: [rad] torque over the declared stiffness.
        width: [rad] by which it is more bent having come from above; where a trial begins there, half of it shows: see ``first``.
        early: [rad] the same width sooner on the plateaus.
        first: one of the two was the rest that the trial begins with, which no side is known of.
        size: [rad] range of the bending in the trial.
    """

    trial: str
    command: float
    width: float
    early: float
    first: bool
    size: float


class Cycle(NamedTuple):
    """Command up and down again without a stop.

    Attributes:
        trial: its name.
        frequency: [Hz].
        width: [rad] of the loop at the middle of the command.
        height: [rad] of the loop.
    """

    trial: str
    frequency: float
    width: float
    height: float


@dataclass(frozen=True, eq=False)
class Loops(Print):
    """Loops of bending over the input.

    Attributes:
        waits, cycles: what they are told from.
        standing: width of the loop after waiting, over the range of the bending (whole widths: plateaus reached from both sides).
        returned: how far the arm stays, back at the first command, towards the side that it went to, over the range.
        faded: width at the end of the waits less that sooner, over the range.
        still: width of the cycles at no speed, over their height.
        lag: [s] by which cycles come later than the command, beside that.
        curves: (command [rad], bending [rad]) of each trial, and the names.
        points: (command [rad], bending [rad], side) at the ends of plateaus: 1 from below, -1 from above, 0 not known.
        noise: [rad] of the bending.
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
        """Whether a loop is left that waiting or slowness does not take away."""
        return _wide(self.standing) or _wide(self.still, _NARROW_CYCLE) or _wide(self.returned)

    @property
    def fades(self) -> bool:
        """Whether what is left narrows while the arm waits."""
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
            found.append(f"under the same command the arm stands {width} of its range farther bent if it comes from above")
        elif _wide(self.returned):
            width = _percent(self.returned)
            found.append(f"back at its first command the arm stands {width} of its range on the side that it was sent to")
        if not found and _wide(self.still, _NARROW_CYCLE):
            found.append(f"cycles of the command leave loops of {_percent(self.still)} of their height however slow they are")
        text = " and ".join(found)
        text = text[:1].upper() + text[1:]
        if self.fades:
            lately = said(-100 * self.faded.value)
            why = "creep, or to an input that goes on changing"
            return f"{text}; it narrows, lately by {lately} % of the range, while the arm waits: this points to {why}."
        if self.remains:
            return f"{text}; waiting does not take it away: this points to friction or hysteresis."
        widths = [abs(known.value) for known in (self.standing, self.returned, self.still) if np.isfinite(known.value)]
        largest = said(100 * max(widths))
        return f"Whatever side it comes from the arm stands alike (to {largest} % of its range): no loop that lasts."

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
        """Bending against command, with where the arm stood."""
        for command, angle in self.curves:
            axes.plot(command, angle, color=ROLES["faint"], lw=0.5, alpha=0.6)
        for side, marker, role, label in (
            (1, "^", "model", "stands, from below"),
            (-1, "v", "declared", "stands, from above"),
            (0, "s", "measured", "at first"),
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
    return f"{said(100 * width.value)} % ({said(100 * width.low)} to {said(100 * width.high)} %)"


def loops(experiment: Experiment) -> Loops | None:
    """Loops of bending over the input; None where no command is reached twice, from two sides."""
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
    """Command [rad], bending [rad] at the end and sooner, and side, of each plateau at whose end the arm stands still."""
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
            sign = -side  # more bent by so much, having come from above
            first = came == 0
            found.append(Wait(name, command, sign * (angle - there), sign * (early - (there if first else sooner)), first, size))
    return found


def _by_trial(waits: list[Wait]) -> Estimate:
    """Mean width over the range, with what leaving out one trial changes."""
    if not waits:
        return Estimate(np.nan, -np.inf, np.inf)
    shares = np.array([wait.width / wait.size for wait in waits])
    return coefficients_of(np.ones((len(waits), 1)), shares, [wait.trial for wait in waits])[0]


def _cycles(motion: Bending) -> list[Cycle]:
    run: Run = motion.run
    moving = np.ones(len(run.torque), dtype=bool)
    for plateau in plateaus(run):
        moving[plateau.first : plateau.last + 1] = False
    if moving.mean() < 0.5:  # steps and stairs
        return []
    time, middle = run.time - run.time[0], float(np.ptp(run.torque)) / 2 + float(run.torque.min())
    above = run.torque >= middle
    at = np.flatnonzero(np.diff(above))
    # A command that is held through each sample is, on the mean, half a sample late.
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
        # the middle crossing against the mean of those around it, so that a drift is no loop
        sign = 1.0 if above[at[index] + 1] else -1.0
        width = sign * float(angle[index + 1] - (angle[index] + angle[index + 2]) / 2)
        found.append(Cycle(run.trial.name, float(1 / (crossings[index + 2] - crossings[index])), width, height))
    return found


def _at_no_speed(cycles: list[Cycle]) -> tuple[Estimate, Estimate]:
    """Width over height that is left at no frequency, and the lag [s] that explains the rest."""
    nothing = Estimate(np.nan, -np.inf, np.inf)
    if len(cycles) < _CYCLES or np.ptp([cycle.frequency for cycle in cycles]) < 0.5 * min(cycle.frequency for cycle in cycles):
        return nothing, nothing
    frequency = np.array([cycle.frequency for cycle in cycles])
    angle = np.arcsin([cycle.width / cycle.height for cycle in cycles])  # by which an ellipse would be late
    design = np.stack([np.ones(len(cycles)), 2 * np.pi * frequency], axis=1)
    still, lag = coefficients_of(design, angle, [cycle.trial for cycle in cycles])
    return still, lag
