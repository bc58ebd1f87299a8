"""Motion out of the plane: how large it is, and whether the plane is merely turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.fingerprint.prints import Print, said
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.plane import Plane, plane_of
from hsr_pin.report.inline_svg import ROLES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DOTS = 1500


@dataclass(frozen=True, eq=False)
class OutOfPlane(Print):
    """Motion of the farthest marker out of the plane.

    Attributes:
        plane: in which it moves.
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
            f"Out of the plane the arm moves by {said(1e3 * plane.sideways)} mm RMS, in it by {said(1e3 * plane.across)} mm "
            f"({said(100 * plane.sideways / max(plane.across, 1e-12))} %)"
        )
        if plane.turned:
            return (
                f"{text}; a turn of the plane by {said(float(np.degrees(plane.turn.value)))} degrees takes away "
                f"{said(100 * plane.explained)} % of the square: this points to cameras or a mount that are turned."
            )
        if plane.leaves:
            return f"{text}, and no turn of the plane takes that away: no law of a planar arm can explain it, it is set apart."
        return f"{text}: next to nothing."

    def numbers(self) -> dict[str, Any]:
        return {
            "sideways_m": self.plane.sideways,
            "across_m": self.plane.across,
            "offset_m": self.plane.offset,
            "turn_rad": self.plane.turn,
            "explained": self.plane.explained,
        }

    def draw(self, axes: Axes) -> None:
        """Path of the farthest marker as seen along the straight arm."""
        points = self.plane.points[:: -(-len(self.plane.points) // _DOTS)]
        axes.plot(*(1e3 * points.T), ".", ms=2, mew=0, color=ROLES["model"], alpha=0.6)
        if self.plane.turned:
            reach = np.array([points[:, 0].min(), points[:, 0].max()])
            line = np.tan(self.plane.turn.value) * reach
            axes.plot(1e3 * reach, 1e3 * line, color=ROLES["ink"], lw=1, ls=(0, (4, 3)), label="turned plane")
            axes.legend(loc="upper left")
        axes.axhline(0, color=ROLES["noise"], lw=1)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="across the arm, in the plane [mm]", ylabel="out of the plane [mm]")
        axes.grid()


def out_of_plane(experiment: Experiment) -> OutOfPlane | None:
    """Motion out of the plane; None where it was not measured."""
    plane = plane_of(experiment)
    return None if plane is None else OutOfPlane(plane)
