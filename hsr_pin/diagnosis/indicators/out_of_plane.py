"""Motion out of the plane, and whether a rotation of the plane explains it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.indicators.indicator import Indicator, rounded, thinned
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.plane import Plane, plane_of
from hsr_pin.report.inline_svg import ROLES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DOTS = 1500


@dataclass(frozen=True, eq=False)
class OutOfPlane(Indicator):
    """Motion of the outermost marker out of the plane.

    Attributes:
        plane: the plane in which the arm moves.
    """

    plane: Plane
    name: ClassVar[str] = "out_of_plane"
    title: ClassVar[str] = "Motion out of the plane"

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("measurement",) if self.plane.turned else ()

    @property
    def sentence(self) -> str:
        plane = self.plane
        text = (
            f"Out of the plane the arm moves by {rounded(1e3 * plane.sideways)} mm RMS, in it by {rounded(1e3 * plane.across)} mm"
            f" ({rounded(100 * plane.sideways / max(plane.across, 1e-12))} %)"
        )
        if plane.turned:
            return (
                f"{text}; a rotation of the plane by {rounded(float(np.degrees(plane.turn.value)))} degrees explains "
                f"{rounded(100 * plane.explained)} % of the squared motion: this points to rotated cameras or a rotated mount."
            )
        if plane.leaves:
            return f"{text}, which no rotation of the plane and no law of a planar arm explains: it is reported separately."
        return f"{text}: this is negligible."

    def numbers(self) -> dict[str, Any]:
        return {
            "sideways_m": self.plane.sideways,
            "across_m": self.plane.across,
            "offset_m": self.plane.offset,
            "turn_rad": self.plane.turn,
            "explained": self.plane.explained,
        }

    def draw(self, axes: Axes) -> None:
        """Draw the path of the outermost marker as seen along the straight arm."""
        points = thinned(self.plane.points, _DOTS)
        axes.plot(*(1e3 * points.T), ".", ms=2, mew=0, color=ROLES["model"], alpha=0.6)
        if self.plane.turned:
            reach = np.array([points[:, 0].min(), points[:, 0].max()])
            line = np.tan(self.plane.turn.value) * reach
            axes.plot(1e3 * reach, 1e3 * line, color=ROLES["ink"], lw=1, ls=(0, (4, 3)), label="rotated plane")
            axes.legend(loc="upper left")
        axes.axhline(0, color=ROLES["noise"], lw=1)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="across the arm, in the plane [mm]", ylabel="out of the plane [mm]")
        axes.grid()


def out_of_plane(experiment: Experiment) -> OutOfPlane | None:
    """Return the motion out of the plane; None if it was not measured."""
    plane = plane_of(experiment)
    return None if plane is None else OutOfPlane(plane)
