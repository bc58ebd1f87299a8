"""The bending angle of the whole arm: twice the angle at which its outermost marker is seen from the base.

For an arm of constant curvature this is the rotation of the tip. It needs no model except for the direction of the straight arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.commands import Plateau
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.plane import farthest_seen
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array

#: Share of a plateau, at its end, in which the arm is assumed to have settled.
_END = 0.2


def _axes(mount: str) -> tuple[Array, Array]:
    """Return the direction of the straight arm, and that in which positive bending moves the tip, in (x, z)."""
    along, across = mount_frame(mount)
    return along[[0, 2]], across[[0, 2]]


@dataclass(frozen=True, eq=False)
class Bending:
    """Bending angle of the arm in one run, where its marker was visible.

    Attributes:
        run: the run.
        time: (S,) time since the start of the run [s].
        angle: (S,) bending angle [rad].
        noise: standard deviation of an angle [rad].
        marker: index of the marker.
        arc_length: arc length of the marker [m].
        mount: mount of the arm.
        start: bending angle in the initial pose, or the first visible one if the pose is unknown [rad].
    """

    run: Run
    time: Array
    angle: Array
    noise: float
    marker: int
    arc_length: float
    mount: str
    start: float

    def plane(self, place: Array) -> tuple[float, float]:
        """Return the coordinates of a point (3,) [m] across the straight arm (towards positive bending) and along it."""
        along, across = (float(place[[0, 2]] @ axis) for axis in _axes(self.mount))
        return across, along

    def between(self, first: float, last: float) -> tuple[Array, Array]:
        """Return times [s] and angles [rad] in a time interval."""
        inside = (self.time >= first - 1e-9) & (self.time <= last + 1e-9)
        return self.time[inside], self.angle[inside]

    def span(self, plateau: Plateau) -> tuple[float, float]:
        """Return the beginning and the end of a plateau since the start of the run [s]."""
        begin = self.run.time[0]
        return float(self.run.time[plateau.first] - begin), float(self.run.time[plateau.last] - begin)

    def ringing(self, plateau: Plateau, share: float = _END) -> float:
        """Return the standard deviation of the angle about a straight line in the last part of a plateau [rad]."""
        first, last = self.span(plateau)
        time, seen = self.between(last - share * (last - first), last)
        return float(np.std(seen - np.polyval(np.polyfit(time - last, seen, 1), time - last))) if len(seen) > 3 else 0.0

    def settled(self, plateau: Plateau, share: float = _END) -> float:
        """Return the median angle in the last part of a plateau [rad]; NaN if the marker was not visible."""
        first, last = self.span(plateau)
        seen = self.between(last - share * (last - first), last)[1]
        return float(np.median(seen)) if len(seen) else float("nan")


def bending(run: Run, experiment: Experiment) -> Bending:
    """Return the bending angle from the outermost marker that was visible for a good part of a run."""
    marker = farthest_seen(run, experiment)
    shown = np.isfinite(run.measured[:, marker, 0])
    along, across = (run.tracked[shown, marker] @ axis for axis in _axes(experiment.dataset.mount))
    angle = 2 * np.arctan2(across, along)
    start = float(angle[0])
    if run.start_pose is not None and np.isfinite(run.start_pose[marker, 0]):
        along_at, across_at = (run.start_pose[marker, [0, 2]] @ axis for axis in _axes(experiment.dataset.mount))
        start = float(2 * np.arctan2(across_at, along_at))
    distance = max(float(np.median(np.hypot(along, across))), 1e-9)
    return Bending(
        run=run,
        time=(run.time - run.time[0])[shown],
        angle=angle,
        noise=2 * float(experiment.noise[marker]) / distance,
        marker=marker,
        arc_length=experiment.markers[marker].arc_length,
        mount=experiment.dataset.mount,
        start=start,
    )
