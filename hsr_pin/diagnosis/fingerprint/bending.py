"""How far the arm is bent, as one number that every arm has: twice the angle at which its farthest marker is seen.

An arm bent evenly turns its tip by this angle. Nothing of a model enters but the direction in which the straight arm points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.commands import Plateau
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.plane import farthest_seen
from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

#: Share of a plateau, at its end, over which the arm is taken to be settled.
_END = 0.2

#: Mount -> where the straight arm points, and where positive bending carries the tip, in (x, z).
_AXES = {
    "hanging": ((0.0, -1.0), (1.0, 0.0)),
    "upright": ((0.0, 1.0), (1.0, 0.0)),
    "horizontal": ((1.0, 0.0), (0.0, -1.0)),
}


@dataclass(frozen=True, eq=False)
class Bending:
    """The bending of an arm through one run, where its marker was seen.

    Attributes:
        run: where it comes from.
        time: (S,) [s] since the start of the run.
        angle: (S,) [rad].
        noise: standard deviation of an angle [rad].
        marker: index of the marker.
        arc_length: of the marker [m].
        mount: of the arm.
        start: [rad] in the pose that a run starts from; the first that was seen where that is not known.
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
        """Across (towards positive bending) and along the straight arm [m], of a place (3,) [m]."""
        along, across = (float(place[[0, 2]] @ np.array(axis)) for axis in _AXES[self.mount])
        return across, along

    def between(self, first: float, last: float) -> tuple[Array, Array]:
        """Times [s] and angles [rad] of a stretch."""
        inside = (self.time >= first - 1e-9) & (self.time <= last + 1e-9)
        return self.time[inside], self.angle[inside]

    def span(self, plateau: Plateau) -> tuple[float, float]:
        """When a plateau begins and ends [s] since the start."""
        begin = self.run.time[0]
        return float(self.run.time[plateau.first] - begin), float(self.run.time[plateau.last] - begin)

    def ringing(self, plateau: Plateau, share: float = _END) -> float:
        """Standard deviation [rad] in the last part of a plateau, about a straight line."""
        first, last = self.span(plateau)
        time, seen = self.between(last - share * (last - first), last)
        return float(np.std(seen - np.polyval(np.polyfit(time - last, seen, 1), time - last))) if len(seen) > 3 else 0.0

    def settled(self, plateau: Plateau, share: float = _END) -> float:
        """Median [rad] of the last part of a plateau; NaN where nothing was seen there."""
        first, last = self.span(plateau)
        seen = self.between(last - share * (last - first), last)[1]
        return float(np.median(seen)) if len(seen) else float("nan")


def bending(run: Run, experiment: Experiment) -> Bending:
    """The bending that the farthest marker shows that was seen for a good part of a run."""
    marker = farthest_seen(run, experiment)
    shown = np.isfinite(run.measured[:, marker, 0])
    along, across = (run.tracked[shown, marker] @ np.array(axis) for axis in _AXES[experiment.dataset.mount])
    angle = 2 * np.arctan2(across, along)
    start = float(angle[0])
    if run.start_pose is not None and np.isfinite(run.start_pose[marker, 0]):
        along_at, across_at = (run.start_pose[marker, [0, 2]] @ np.array(axis) for axis in _AXES[experiment.dataset.mount])
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
