"""Motion out of the plane: how large it is, and whether the plane is merely turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.diagnosis.fingerprint.bending import bending
from hsr_pin.diagnosis.fingerprint.prints import Estimate, Print, coefficients_of, said
from hsr_pin.diagnosis.inline_svg import ROLES
from hsr_pin.identification.experiment import Experiment
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: There is motion out of the plane if it is more than this share of that in the plane, and than so many noises.
_SHARE, _NOISES = 0.03, 2.0
#: The plane is turned if a turn takes away so much of the mean square, and the turn is more than so many degrees.
_TURNED, _DEGREES = 0.7, 1.0
_DOTS = 1500


@dataclass(frozen=True, eq=False)
class OutOfPlane(Print):
    """Motion of the farthest marker out of the plane.

    Attributes:
        sideways: [m] RMS out of the plane, each trial's middle left out, beyond noise.
        across: [m] the same across the arm in the plane.
        offset: [m] standard deviation of the trials' middles out of the plane.
        turn: [rad] about the straight arm that would take most of it away.
        explained: share of the mean square that this turn takes away.
        beside: [m] how far beside the straight arm the turned plane passes.
        noise: [m] of a coordinate.
        points: (S, 2) [m] across and sideways, some of all.
    """

    sideways: float
    across: float
    offset: float
    turn: Estimate
    explained: float
    beside: float
    noise: float
    points: Array
    name: ClassVar[str] = "out_of_plane"
    title: ClassVar[str] = "Motion out of the plane"

    @property
    def leaves(self) -> bool:
        """Whether the arm leaves the plane by enough to matter."""
        return self.sideways > max(_SHARE * self.across, _NOISES * self.noise)

    @property
    def turned(self) -> bool:
        """Whether the arm moves in a plane, but another one."""
        return self.leaves and self.explained > _TURNED and self.turn.certain and abs(self.turn.value) > np.radians(_DEGREES)

    @property
    def kinds(self) -> tuple[str, ...]:
        return ("measurement",) if self.turned else ()

    @property
    def sentence(self) -> str:
        text = (
            f"Out of the plane the arm moves by {said(1e3 * self.sideways)} mm RMS, in it by {said(1e3 * self.across)} mm "
            f"({said(100 * self.sideways / max(self.across, 1e-12))} %)"
        )
        if self.turned:
            return (
                f"{text}; a turn of the plane by {said(float(np.degrees(self.turn.value)))} degrees takes away "
                f"{said(100 * self.explained)} % of the square: this points to cameras or a mount that are turned."
            )
        if self.leaves:
            return f"{text}, and no turn of the plane takes that away: no law of a planar arm can explain it, it is set apart."
        return f"{text}: next to nothing."

    def numbers(self) -> dict[str, Any]:
        return {
            "sideways_m": self.sideways,
            "across_m": self.across,
            "offset_m": self.offset,
            "turn_rad": self.turn,
            "explained": self.explained,
        }

    def draw(self, axes: Axes) -> None:
        """Path of the farthest marker as seen along the straight arm."""
        axes.plot(*(1e3 * self.points.T), ".", ms=2, mew=0, color=ROLES["model"], alpha=0.6)
        if self.turned:
            reach = np.array([self.points[:, 0].min(), self.points[:, 0].max()])
            axes.plot(
                1e3 * reach, 1e3 * reach * np.tan(self.turn.value), color=ROLES["ink"], lw=1, ls=(0, (4, 3)), label="turned plane"
            )
            axes.legend(loc="upper left")
        axes.axhline(0, color=ROLES["noise"], lw=1)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="across the arm, in the plane [mm]", ylabel="out of the plane [mm]")
        axes.grid()


def out_of_plane(experiment: Experiment) -> OutOfPlane | None:
    """Motion out of the plane; None where it was not measured."""
    across, sideways, trials, middles, centres = [], [], [], [], []
    axis = 2 if experiment.dataset.mount == "horizontal" else 0
    noise = 0.0
    for run in experiment.runs:
        marker = bending(run, experiment).marker
        shown = run.measured[np.isfinite(run.measured[:, marker, 0]), marker]
        middles.append(float(np.median(shown[:, 1])))
        centres.append(float(np.median(shown[:, axis])))
        across.append(shown[:, axis] - np.median(shown[:, axis]))
        sideways.append(shown[:, 1] - np.median(shown[:, 1]))
        trials += [run.trial.name] * len(shown)
        noise = max(noise, float(experiment.noise[marker]))
    x, y = np.concatenate(across), np.concatenate(sideways)
    if not np.any(y):
        return None
    slope = coefficients_of(x[:, None], y, trials)[0] if len(across) > 2 else _slope(x, y)
    turn = Estimate(*(float(np.arctan(value)) for value in slope))
    beyond = max(float(np.mean(y**2)) - noise**2, 0.0)
    less = max(float(np.mean((y - slope.value * x) ** 2)) - noise**2, 0.0)
    every = -(-len(x) // _DOTS)
    return OutOfPlane(
        sideways=float(np.sqrt(beyond)),
        across=float(np.sqrt(max(float(np.mean(x**2)) - noise**2, 0.0))),
        offset=float(np.std(middles, ddof=1)) if len(middles) > 1 else 0.0,
        turn=turn,
        explained=1 - less / beyond if beyond > 0 else 0.0,
        beside=float(np.median(np.array(middles) - slope.value * np.array(centres))),
        noise=noise,
        points=np.stack([x, y], axis=1)[::every],
    )


def _slope(x: Array, y: Array) -> Estimate:
    return Estimate(float(x @ y / max(float(x @ x), 1e-30)), -np.inf, np.inf)
