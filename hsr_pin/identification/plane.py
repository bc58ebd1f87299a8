"""The plane in which an arm bends: how much moves out of the declared one, and whether that is another plane.

Seen from the declared plane, an arm that bends in one turned about its straight axis bends less than it does, by the cosine of
the turn, and every model of it is too stiff. Whether the cameras are turned, or the base with its muscles, no recording of the
arm alone can tell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array

#: There is motion out of the plane if it is more than this share of that in the plane, and than so many noises.
_SHARE, _NOISES = 0.03, 2.0
#: The plane is turned if a turn takes away so much of the mean square, and the turn is more than so many degrees.
_TURNED, _DEGREES = 0.7, 1.0
#: A marker counts that was seen at least this often, beside the one that was seen most.
_SEEN = 0.5
_ASIDE = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Plane:
    """Of the farthest marker's motion.

    Attributes:
        sideways: [m] RMS out of the declared plane, each trial's middle left out, beyond noise.
        across: [m] the same across the arm in the plane.
        offset: [m] standard deviation of the trials' middles out of the plane.
        turn: [rad] about the straight arm that would take most of it away.
        explained: share of the mean square that this turn takes away.
        beside: [m] how far beside the straight arm the turned plane passes.
        noise: [m] of a coordinate.
        points: (S, 2) [m] across and sideways.
    """

    sideways: float
    across: float
    offset: float
    turn: Estimate
    explained: float
    beside: float
    noise: float
    points: Array

    @property
    def leaves(self) -> bool:
        """Whether the arm leaves the declared plane by enough to matter."""
        return self.sideways > max(_SHARE * self.across, _NOISES * self.noise)

    @property
    def turned(self) -> bool:
        """Whether the arm moves in a plane, but another one."""
        return self.leaves and self.explained > _TURNED and self.turn.certain and abs(self.turn.value) > np.radians(_DEGREES)

    @property
    def kind(self) -> str:
        """Kind of physics that it tells; empty if none."""
        return "measurement" if self.turned else ""

    @property
    def sentence(self) -> str:
        """As a person would say it; empty where the plane is the declared one."""
        value, low, high = (f"{np.degrees(part):.1f}" for part in self.turn)
        told = (
            f"the plane in which the arm bends is turned by {value} degrees ({low} to {high}) about the straight arm, by its "
            "cameras or its base, and was turned back first"
        )
        return told if self.turned else ""

    def undone(self, experiment: Experiment) -> Experiment:
        """The recordings as if the plane were the declared one."""
        along, across = map(np.abs, mount_frame(experiment.dataset.mount))
        c, s = np.cos(self.turn.value), np.sin(self.turn.value)
        turn = np.outer(along, along) + np.outer(across, c * across + s * _ASIDE) + np.outer(_ASIDE, c * _ASIDE - s * across)
        centre = self.beside * _ASIDE

        def back(points: Array) -> Array:
            return np.asarray((points - centre) @ turn.T + centre)

        trials = {
            trial.name: replace(trial, trajectory=replace(trial.trajectory, positions=back(trial.trajectory.positions)))
            for trial in experiment.dataset.trials
        }
        runs = tuple(
            replace(
                run,
                trial=trials[run.trial.name],
                measured=back(run.measured),
                start_pose=None if run.start_pose is None else back(run.start_pose),
                start_velocity=None if run.start_velocity is None else run.start_velocity @ turn.T,
                found_poses={},
            )
            for run in experiment.runs
        )
        return replace(experiment, dataset=replace(experiment.dataset, trials=tuple(trials.values())), runs=runs)


def in_its_plane(experiment: Experiment) -> tuple[Experiment, Plane | None]:
    """The recordings, turned back if their plane is turned, with a note; and that plane."""
    plane = plane_of(experiment)
    if plane is None or not plane.turned:
        return experiment, None
    return replace(plane.undone(experiment), notes=(*experiment.notes, plane.sentence)), plane


def plane_of(experiment: Experiment) -> Plane | None:
    """The plane of an arm that is declared to bend in one; None where motion out of it was not measured."""
    if len(experiment.directions) > 1:
        return None
    axis = int(np.argmax(np.abs(mount_frame(experiment.dataset.mount)[1])))
    across, sideways, trials, middles, noise = [], [], [], [], 0.0
    for run in experiment.runs:
        marker = farthest_seen(run, experiment)
        shown = run.measured[np.isfinite(run.measured[:, marker, 0]), marker]
        middle = np.median(shown[:, [axis, 1]], axis=0)
        middles.append(middle)
        across.append(shown[:, axis] - middle[0])
        sideways.append(shown[:, 1] - middle[1])
        trials += [run.trial.name] * len(shown)
        noise = max(noise, float(experiment.noise[marker]))
    x, y, at = np.concatenate(across), np.concatenate(sideways), np.array(middles)
    if not np.any(y):
        return None
    slope = coefficients_of(x[:, None], y, trials)[0] if len(across) > 2 else _slope(x, y)
    beyond = max(float(np.mean(y**2)) - noise**2, 0.0)
    less = max(float(np.mean((y - slope.value * x) ** 2)) - noise**2, 0.0)
    return Plane(
        sideways=float(np.sqrt(beyond)),
        across=float(np.sqrt(max(float(np.mean(x**2)) - noise**2, 0.0))),
        offset=float(np.std(at[:, 1], ddof=1)) if len(at) > 1 else 0.0,
        turn=Estimate(*(float(np.arctan(value)) for value in slope)),
        explained=1 - less / beyond if beyond > 0 else 0.0,
        beside=float(np.median(at[:, 1] - slope.value * at[:, 0])),
        noise=noise,
        points=np.stack([x, y], axis=1),
    )


def farthest_seen(run: Run, experiment: Experiment) -> int:
    """Index of the farthest marker that was seen for a good part of a run."""
    seen = np.isfinite(run.measured[..., 0]).sum(axis=0)
    often = np.flatnonzero(seen >= _SEEN * seen.max())
    return int(max(often, key=lambda index: experiment.markers[index].arc_length))


def _slope(x: Array, y: Array) -> Estimate:
    return Estimate(float(x @ y / max(float(x @ x), 1e-30)), -np.inf, np.inf)
