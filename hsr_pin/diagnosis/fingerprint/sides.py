"""Frequency and damping of an arm in space by the side to which it swings.

An arm that is round swings alike to every side. One that is stiffer to some has frequencies f with f^2 = mean (1 + x cos 2 a +
y sin 2 a) at the angle a of the line on which it swings: a stiffness is a tensor, and so is its square frequency.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.fingerprint.decay import decay
from hsr_pin.diagnosis.fingerprint.lines import Lines
from hsr_pin.diagnosis.fingerprint.prints import Print, counted, said
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.report.inline_svg import ROLES
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Lines must be so far apart [rad], as lines without ends, and there must be so many trials.
_APART, _TRIALS = 0.35, 5
#: Lines tell of a direction of stiffness if they spread by so much in it.
_SPREAD = 0.1
#: Stiffness depends on the side if it does by more than this share.
_LEAST = 0.03


@dataclass(frozen=True, eq=False)
class Sides(Print):
    """Frequency and damping by the side.

    Attributes:
        angles: (n,) [rad] of the lines on which trials swing, from x towards y of the base, 0 to pi.
        frequencies: (n,) [Hz] the median of each trial.
        dampings: (n,) damping ratios likewise.
        along_x, diagonal: by what share the square of the frequency is higher towards x, and half way to y, than on average.
    """

    angles: Array
    frequencies: Array
    dampings: Array
    along_x: Estimate
    diagonal: Estimate
    name: ClassVar[str] = "sides"
    title: ClassVar[str] = "Frequency by the side to which the arm swings"

    @property
    def share(self) -> float:
        """By what share the stiffness is higher to the stiffest side than on average."""
        return float(np.hypot(self.along_x.value, self.diagonal.value))

    @property
    def stiffest(self) -> float:
        """[degrees] of that side, from x towards y, 0 to 180."""
        return float(np.degrees(np.arctan2(self.diagonal.value, self.along_x.value)) / 2 % 180)

    @property
    def unequal(self) -> bool:
        """Whether the arm is certainly stiffer to some sides than to others."""
        return self.share > _LEAST and (self.along_x.certain or self.diagonal.certain)

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("elastic",) if self.unequal else ()

    @property
    def sentence(self) -> str:
        low, high = said(float(self.frequencies.min())), said(float(self.frequencies.max()))
        text = (
            f"To the sides of {counted(len(self.angles), 'trial')} the arm swings at "
            f"{low if low == high else f'{low} to {high}'} Hz with a damping ratio of {said(float(np.median(self.dampings)))}"
        )
        if self.unequal:
            return (
                f"{text}; square frequencies are {said(100 * self.share)} % above their mean towards {self.stiffest:.0f} degrees "
                "from x to y of the base, and as much below it across: this points to a stiffness that is not the same to all "
                "sides."
            )
        if not np.isfinite(self.along_x.low):
            return f"{text}: too few trials to tell whether alike to every side."
        return f"{text}: alike to every side, as far as can be told."

    def numbers(self) -> dict[str, Any]:
        return {
            "angles_rad": self.angles,
            "frequencies_hz": self.frequencies,
            "damping_ratios": self.dampings,
            "along_x": self.along_x,
            "diagonal": self.diagonal,
        }

    def draw(self, axes: Axes) -> None:
        """Frequency against the angle of the line."""
        axes.plot(np.degrees(self.angles), self.frequencies, "o", ms=4.5, mew=0, color=ROLES["model"], label="trials")
        if self.unequal:
            angles = np.linspace(0, np.pi, 181)
            square = 1 + self.along_x.value * np.cos(2 * angles) + self.diagonal.value * np.sin(2 * angles)
            design = 1 + self.along_x.value * np.cos(2 * self.angles) + self.diagonal.value * np.sin(2 * self.angles)
            mean = float(np.mean(self.frequencies**2 / design))
            axes.plot(
                np.degrees(angles), np.sqrt(mean * square), color=ROLES["ink"], lw=1, ls=(0, (4, 3)), label="stiffer to a side"
            )
            axes.legend(loc="best")
        axes.set_ylim(0, 1.3 * float(self.frequencies.max()))
        axes.set(xlabel="side, from x towards y of the base [degrees]", ylabel="frequency [Hz]")
        axes.grid()


def sides(found: Lines) -> Sides | None:
    """Frequency and damping by the side; None where trials do not swing to sides that are far enough apart."""
    rows = []
    for run, side in zip(found.swinging.runs, found.sides, strict=True):
        own = decay(replace(found.swinging, runs=(run,)))
        if own is not None:
            each = ([swing.frequency for swing in own.swings], [swing.damping for swing in own.swings])
            rows.append((float(np.angle(side**2)) / 2 % np.pi, *(float(np.median(values)) for values in each)))
    if len(rows) < 2:
        return None
    angles, frequencies, dampings = np.array(rows).T
    apart = np.abs(np.angle(np.exp(2j * (angles[:, None] - angles)))) / 2
    if apart.max() < _APART:
        return None
    return Sides(angles, frequencies, dampings, *_stiffer(angles, frequencies**2))


def _stiffer(angles: Array, squares: Array) -> tuple[Estimate, Estimate]:
    """By what share square frequencies are higher towards x, and half way to y, than on average; nothing of too few trials.

    Of trials on two lines across one another, as an arm that is not round swings on, it is known only how these two differ.
    """
    if len(angles) < _TRIALS:
        return (Estimate(np.nan, -np.inf, np.inf),) * 2
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
