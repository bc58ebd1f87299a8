"""Change of length: how long the backbone is between the markers, read off the chords between them.

An arc that turns by an angle is longer than its chord by (angle / 2) / sin(angle / 2). From the base, where the arm points
straight, each chord tells by how much the arc up to the next marker turns: twice the angle between the chord and the tangent
where it starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.fingerprint.bending import bending
from hsr_pin.diagnosis.fingerprint.prints import Print, said
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.identification.prepared import Run
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The arm must bend by so much [rad] for its length over bending to be told.
_BENDS = 0.2
#: A change of length counts from this share of the length on: markers, waves and arcs that are none make so much.
_WORTH = 0.01
#: More motion out of the plane than this share of that in it, and the chords in the plane are no chords.
_PLANE = 0.15
#: Samples this slow, by share of the fastest, are looked at: a moving arm is no arc.
_SLOW = 0.1
_DOTS = 1500


@dataclass(frozen=True, eq=False)
class Length(Print):
    """Length of the backbone over bending.

    Attributes:
        bent: share of its length by which the arm grows where it is bent most, to either side alike.
        sided: share by which it grows on the positive side and shrinks on the other.
        reach: [rad] the most that it is bent.
        offset: [m] by which a marker would stand off the backbone, towards positive bending, to look as ``sided`` does.
        driven: by a command; else released.
        declared: share by which it is longer than declared where it is straight.
        points: (S, 2) bending [rad] and length over declared length.
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
        """Whether the length certainly changes with bending."""
        return any(change.certain and abs(change.value) > _WORTH for change in (self.bent, self.sided))

    @property
    def kinds(self) -> tuple[str, ...]:
        if not self.changes:
            return ()
        sided = self.sided.certain and abs(self.sided.value) > max(_WORTH, abs(self.bent.value))
        return ("measurement",) if sided or not self.driven else ("actuation_map", "measurement")

    @property
    def sentence(self) -> str:
        bent, sided = 100 * self.bent.value, 100 * self.sided.value
        text = f"Bent by up to {said(self.reach)} rad the arm"
        if not self.changes:
            return f"{text} keeps its length to {said(max(abs(bent), abs(sided)))} %: it does not stretch to be seen."
        if self.sided.certain and abs(sided) > max(100 * _WORTH, abs(bent)):
            off = f"a marker about {said(1e3 * abs(self.offset))} mm off the backbone"
            return f"Towards one side the arm looks {said(abs(sided))} % longer, towards the other shorter: this points to {off}."
        pressure = "a length that changes with the pressure, to " if self.driven else ""
        change = f"{said(abs(bent))} % {'longer' if bent > 0 else 'shorter'} than straight"
        return f"{text} is {change}: this points to {pressure}markers off the backbone, or to a bend that is no arc."

    def numbers(self) -> dict[str, Any]:
        return {
            "bent": self.bent,
            "sided": self.sided,
            "reach_rad": self.reach,
            "offset_m": self.offset,
            "longer_than_declared": self.declared,
        }

    def draw(self, axes: Axes) -> None:
        """Length over bending."""
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
    """Length over bending; None where the arm hardly bends, or out of the plane as well."""
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
    """RMS motion out of the plane over that in it."""
    squares = []
    for run in experiment.runs:
        marker = bending(run, experiment).marker
        shown = run.measured[np.isfinite(run.measured[:, marker, 0]), marker]
        squares.append(np.mean((shown - np.median(shown, axis=0)) ** 2, axis=0))
    square = np.mean(squares, axis=0)
    return float(np.sqrt(max(square[1] - float(np.max(experiment.noise)) ** 2, 0.0) / max(square[0] + square[2], 1e-30)))


def _lengths(run: Run, experiment: Experiment) -> tuple[Array, Array]:
    """(S,) bending [rad] and length over declared length where the arm moves slowly and all markers are seen."""
    motion = bending(run, experiment)
    order = np.argsort([marker.arc_length for marker in experiment.markers])
    order = order[: int(np.flatnonzero(order == motion.marker)[0]) + 1]
    mount = experiment.dataset.mount
    plane = run.tracked[:, order]
    along, across = {
        "hanging": (-plane[..., 1], plane[..., 0]),
        "upright": (plane[..., 1], plane[..., 0]),
        "horizontal": (plane[..., 0], -plane[..., 1]),
    }[mount]
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
