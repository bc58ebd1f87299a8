"""Frequency and damping of an arm in space as functions of the direction in which it oscillates.

An axisymmetric arm has the same frequency in every direction. An arm with direction-dependent stiffness has frequencies f with
f^2 = mean (1 + x cos 2 a + y sin 2 a), where a is the angle of the line on which it oscillates, because the stiffness and the
squared frequency are tensors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.indicators.decay import decay
from hsr_pin.diagnosis.indicators.indicator import Indicator, counted, rounded, rounded_range
from hsr_pin.diagnosis.indicators.lines import Lines
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Least angle between the lines of two trials [rad], and least number of trials.
_SEPARATION, _TRIALS = 0.35, 5
#: Least spread of the lines in a direction for the stiffness in that direction.
_SPREAD = 0.1
#: Least significant relative change of the stiffness with the direction.
_LEAST = 0.03


@dataclass(frozen=True, eq=False)
class Sides(Indicator):
    """Frequency and damping as functions of the direction.

    Attributes:
        angles: (n,) angles of the lines on which trials oscillate, from x towards y of the base, 0 to pi [rad].
        frequencies: (n,) median frequency of each trial [Hz].
        dampings: (n,) median damping ratio of each trial.
        along_x, diagonal: relative increase of the squared frequency towards x, and towards the bisector of x and y.
    """

    angles: Array
    frequencies: Array
    dampings: Array
    along_x: Estimate
    diagonal: Estimate
    name: ClassVar[str] = "sides"
    title: ClassVar[str] = "Frequency by the direction of oscillation"

    @property
    def share(self) -> float:
        """Relative increase of the stiffness in the stiffest direction above the mean."""
        return float(np.hypot(self.along_x.value, self.diagonal.value))

    @property
    def stiffest(self) -> float:
        """Stiffest direction from x towards y, 0 to 180 [degrees]."""
        return float(np.degrees(np.arctan2(self.diagonal.value, self.along_x.value)) / 2 % 180)

    @property
    def unequal(self) -> bool:
        """Whether the stiffness depends significantly on the direction."""
        return self.share > _LEAST and (self.along_x.excludes_zero or self.diagonal.excludes_zero)

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("elastic",) if self.unequal else ()

    @property
    def sentence(self) -> str:
        text = (
            f"Along the lines of {counted(len(self.angles), 'trial')} the arm oscillates at "
            f"{rounded_range(float(self.frequencies.min()), float(self.frequencies.max()))} Hz with a damping ratio of "
            f"{rounded(float(np.median(self.dampings)))}"
        )
        if self.unequal:
            return (
                f"{text}; the squared frequency is {rounded(100 * self.share)} % above its mean towards {self.stiffest:.0f} "
                "degrees from x to y of the base, and as much below it in the perpendicular direction: this points to a "
                "stiffness that depends on the direction."
            )
        if not np.isfinite(self.along_x.low):
            return f"{text}: there are too few trials to determine a dependence on the direction."
        return f"{text}: no dependence on the direction is visible."

    def numbers(self) -> dict[str, Any]:
        return {
            "angles_rad": self.angles,
            "frequencies_hz": self.frequencies,
            "damping_ratios": self.dampings,
            "along_x": self.along_x,
            "diagonal": self.diagonal,
        }

    def draw(self, axes: Axes) -> None:
        """Draw the frequency against the angle of the line."""
        axes.plot(np.degrees(self.angles), self.frequencies, "o", ms=4.5, mew=0, color=ROLES["model"], label="trials")
        if self.unequal:
            angles = np.linspace(0, np.pi, 181)
            square = 1 + self.along_x.value * np.cos(2 * angles) + self.diagonal.value * np.sin(2 * angles)
            design = 1 + self.along_x.value * np.cos(2 * self.angles) + self.diagonal.value * np.sin(2 * self.angles)
            mean = float(np.mean(self.frequencies**2 / design))
            axes.plot(
                np.degrees(angles),
                np.sqrt(mean * square),
                color=ROLES["ink"],
                lw=1,
                ls=(0, (4, 3)),
                label="fit with direction-dependent stiffness",
            )
            axes.legend(loc="best")
        axes.set_ylim(0, 1.3 * float(self.frequencies.max()))
        axes.set(xlabel="direction, from x towards y of the base [degrees]", ylabel="frequency [Hz]")
        axes.grid()


def sides(found: Lines) -> Sides | None:
    """Return frequency and damping as functions of the direction; None if the directions of the trials are too close."""
    rows = []
    for run, side in zip(found.swinging.runs, found.sides, strict=True):
        own = decay(replace(found.swinging, runs=(run,)))
        if own is not None:
            each = ([swing.frequency for swing in own.swings], [swing.damping for swing in own.swings])
            rows.append((float(np.angle(side**2)) / 2 % np.pi, *(float(np.median(values)) for values in each)))
    if len(rows) < 2:
        return None
    angles, frequencies, dampings = np.array(rows).T
    separation = np.abs(np.angle(np.exp(2j * (angles[:, None] - angles)))) / 2
    if separation.max() < _SEPARATION:
        return None
    return Sides(angles, frequencies, dampings, *_stiffer(angles, frequencies**2))


def _stiffer(angles: Array, squares: Array) -> tuple[Estimate, Estimate]:
    """Return the relative increase of squared frequencies towards x and towards the bisector; undetermined with too few trials.

    From trials on two perpendicular lines, only the difference between these two directions can be determined.
    """
    if len(angles) < _TRIALS:
        return (Estimate(np.nan),) * 2
    twice = np.stack([np.cos(2 * angles), np.sin(2 * angles)], axis=1)
    _, spread, ways = np.linalg.svd(twice - twice.mean(axis=0), full_matrices=False)
    ways = ways[spread > _SPREAD * np.sqrt(len(angles))]
    design = np.column_stack([np.ones(len(angles)), twice @ ways.T])
    mean, *slopes = coefficients_of(design, squares / squares.mean(), range(len(angles)))
    value, reach = (ways.T @ [each.value for each in slopes], np.abs(ways.T) @ [each.high - each.value for each in slopes])
    along, diagonal = (
        Estimate(v / mean.value, (v - r) / mean.value, (v + r) / mean.value) for v, r in zip(value, reach, strict=True)
    )
    return along, diagonal
