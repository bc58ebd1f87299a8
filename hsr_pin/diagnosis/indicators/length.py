"""Change of length: arc length of the backbone between the markers, computed from the chords between them.

An arc that turns by an angle is longer than its chord by the factor (angle / 2) / sin(angle / 2). Starting at the base, where the
direction of the arm is known, each chord determines the rotation of the arc up to the next marker: twice the angle between the
chord and the tangent at its start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.indicators.bending import bending
from hsr_pin.diagnosis.indicators.indicator import Indicator, rounded
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Least bending angle for this indicator [rad].
_BENDS = 0.2
#: Least significant relative change of length, because marker offsets, waves and shapes other than arcs cause smaller ones.
_WORTH = 0.01
#: Largest ratio of the motion out of the plane to that in the plane at which chords in the plane are valid.
_PLANE = 0.15
#: Samples below this share of the largest speed are used, because a moving arm is not an arc.
_SLOW = 0.1
_DOTS = 1500


@dataclass(frozen=True, eq=False)
class Length(Indicator):
    """Length of the backbone as a function of bending.

    Attributes:
        bent: relative change of length at the largest bending, symmetric in the direction of bending.
        sided: relative change of length at the largest positive bending, antisymmetric in the direction of bending.
        reach: largest bending angle [rad].
        offset: distance of a marker from the backbone, towards positive bending, that would cause ``sided`` [m].
        driven: whether the arm was driven by a command; otherwise it was released.
        declared: relative difference between the length of the straight arm and the declared length.
        points: (S, 2) bending angle [rad] and length over declared length.
    """

    bent: Estimate
    sided: Estimate
    reach: float
    offset: float
    driven: bool
    declared: float
    points: Array
    name: ClassVar[str] = "length"
    title: ClassVar[str] = "Length of the backbone"

    @property
    def changes(self) -> bool:
        """Whether the length changes significantly with bending."""
        return any(change.excludes_zero and abs(change.value) > _WORTH for change in (self.bent, self.sided))

    @property
    def kinds(self) -> tuple[str, ...]:
        if not self.changes:
            return ()
        sided = self.sided.excludes_zero and abs(self.sided.value) > max(_WORTH, abs(self.bent.value))
        return ("measurement",) if sided or not self.driven else ("actuation_map", "measurement")

    @property
    def sentence(self) -> str:
        bent, sided = 100 * self.bent.value, 100 * self.sided.value
        text = f"Bent by up to {rounded(self.reach)} rad the arm"
        if not self.changes:
            return f"{text} keeps its length to {rounded(max(abs(bent), abs(sided)))} %: no stretching is visible."
        if self.sided.excludes_zero and abs(sided) > max(100 * _WORTH, abs(bent)):
            off = f"a marker about {rounded(1e3 * abs(self.offset))} mm off the backbone"
            change = f"{rounded(abs(sided))} % longer"
            return f"Towards one side the arm looks {change}, towards the other shorter: this points to {off}."
        pressure = "a length that changes with the pressure, to " if self.driven else ""
        change = f"{rounded(abs(bent))} % {'longer' if bent > 0 else 'shorter'} than straight"
        return f"{text} is {change}: this points to {pressure}markers off the backbone, or to a shape that is not an arc."

    def numbers(self) -> dict[str, Any]:
        return {
            "bent": self.bent,
            "sided": self.sided,
            "reach_rad": self.reach,
            "offset_m": self.offset,
            "longer_than_declared": self.declared,
        }

    def draw(self, axes: Axes) -> None:
        """Draw the length against the bending angle."""
        angle, length = self.points.T
        axes.plot(angle, 100 * (length - 1), ".", ms=2.5, mew=0, color=ROLES["model"], alpha=0.6)
        at = np.linspace(angle.min(), angle.max(), 100)
        line = self.declared + self.bent.value * (at / self.reach) ** 2 + self.sided.value * at / self.reach
        axes.plot(at, 100 * line, color=ROLES["ink"], lw=1.0, ls=(0, (4, 3)))
        low, high = np.percentile(100 * (length - 1), [1, 99])
        reach = max(1.0, 0.75 * (high - low))
        axes.set_ylim((low + high) / 2 - reach, (low + high) / 2 + reach)
        axes.set(xlabel="bending [rad]", ylabel="longer than declared [%]")
        axes.grid()


def length(experiment: Experiment) -> Length | None:
    """Return the length as a function of bending; None if the arm hardly bends, or also moves out of the plane."""
    if _sideways(experiment) > _PLANE:
        return None
    angles, lengths, trials = [], [], []
    for run in experiment.runs:
        angle, arc = _lengths(run, experiment)
        angles.append(angle)
        lengths.append(arc)
        trials += [run.trial.name] * len(angle)
    angle, arc = np.concatenate(angles), np.concatenate(lengths)
    if not len(angle) or np.max(np.abs(angle)) < _BENDS:
        return None
    reach = float(np.max(np.abs(angle)))
    part = angle / reach
    two_sided = part.min() < -0.3 and part.max() > 0.3
    design = np.stack([np.ones(len(part)), part**2, *([part] if two_sided else [])], axis=1)
    if len(experiment.runs) < 3:
        fitted = tuple(Estimate(float(b), -np.inf, np.inf) for b in np.linalg.lstsq(design, arc, rcond=None)[0])
    else:
        fitted = coefficients_of(design, arc, trials)
    sided = fitted[2] if two_sided else Estimate(0.0, -np.inf, np.inf)
    reached = max(marker.arc_length for marker in experiment.markers)
    every = -(-len(angle) // _DOTS)
    return Length(
        bent=fitted[1],
        sided=sided,
        reach=reach,
        offset=-float(sided.value) * reached / reach,
        driven=any(np.ptp(run.torque) > 0 for run in experiment.runs),
        declared=fitted[0].value - 1,
        points=np.stack([angle, arc], axis=1)[::every],
    )


def _sideways(experiment: Experiment) -> float:
    """Return the ratio of RMS motion out of the plane to that in the plane."""
    squares = []
    for run in experiment.runs:
        marker = bending(run, experiment).marker
        shown = run.measured[np.isfinite(run.measured[:, marker, 0]), marker]
        squares.append(np.mean((shown - np.median(shown, axis=0)) ** 2, axis=0))
    square = np.mean(squares, axis=0)
    return float(np.sqrt(max(square[1] - float(np.max(experiment.noise)) ** 2, 0.0) / max(square[0] + square[2], 1e-30)))


def _lengths(run: Run, experiment: Experiment) -> tuple[Array, Array]:
    """Return (S,) bending angle [rad] and length over declared length where the arm moves slowly and all markers are visible."""
    motion = bending(run, experiment)
    order = np.argsort([marker.arc_length for marker in experiment.markers])
    order = order[: int(np.flatnonzero(order == motion.marker)[0]) + 1]
    along, across = (run.tracked[:, order] @ axis[list(run.axes)] for axis in mount_frame(experiment.dataset.mount))
    steps_along, steps_across = (np.diff(part, axis=1, prepend=0.0) for part in (along, across))
    tangent = np.zeros(len(along))
    arc = np.zeros(len(along))
    for index in range(len(order)):
        half = np.arctan2(steps_across[:, index], steps_along[:, index]) - tangent
        half = (half + np.pi) % (2 * np.pi) - np.pi
        arc += np.hypot(steps_along[:, index], steps_across[:, index]) / np.sinc(half / np.pi)
        tangent = tangent + 2 * half
    angle = 2 * np.arctan2(across[:, -1], along[:, -1])
    width = min(max(3, round(0.05 / run.step)), len(angle))
    speed = np.abs(np.gradient(np.convolve(angle, np.ones(width) / width, mode="same"), run.step))
    slow = speed < _SLOW * np.nanmax(speed) if np.isfinite(speed).any() else np.zeros(len(angle), dtype=bool)
    slow[:width] = slow[-width:] = False
    keep = slow & np.isfinite(arc)
    return angle[keep], arc[keep] / motion.arc_length
