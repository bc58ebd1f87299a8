"""The plane in which an arm bends: the motion out of the declared plane, and whether that motion is in another plane.

If an arm bends in a plane that is rotated about its straight axis, the bending in the declared plane is smaller by the cosine of
the angle, and every fitted model is too stiff. Recordings of the arm alone cannot distinguish rotated cameras from a rotated
base.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.jackknife import Estimate, coefficients_of
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array

#: Motion out of the plane is significant if it exceeds this share of the motion in the plane and this multiple of the noise.
_SHARE, _NOISES = 0.03, 2.0
#: The plane is rotated if a rotation explains this share of the mean square and exceeds this angle [degrees].
_TURNED, _DEGREES = 0.7, 1.0
#: Smallest number of samples of a marker, relative to the marker with the most samples.
_SEEN = 0.5
_ASIDE = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane of the farthest marker's motion.

    Attributes:
        sideways: RMS motion out of the declared plane, relative to each trial's median, in excess of noise [m].
        across: RMS motion across the arm in the plane, in excess of noise [m].
        offset: standard deviation of the trials' medians out of the plane [m].
        turn: angle of the rotation about the straight arm that removes most of the motion out of the plane [rad].
        explained: share of the mean square that this rotation removes.
        beside: distance of the rotated plane from the straight arm [m].
        noise: standard deviation of a coordinate [m].
        points: (S, 2) positions across the arm and sideways [m].
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
        """Whether the arm leaves the declared plane significantly."""
        return self.sideways > max(_SHARE * self.across, _NOISES * self.noise)

    @property
    def turned(self) -> bool:
        """Whether the arm moves in a plane that is rotated from the declared one."""
        return (
            self.leaves and self.explained > _TURNED and self.turn.excludes_zero and abs(self.turn.value) > np.radians(_DEGREES)
        )

    @property
    def kind(self) -> str:
        """Kind of physics that a rotation indicates; empty if there is none."""
        return "measurement" if self.turned else ""

    @property
    def sentence(self) -> str:
        """The finding as a sentence; empty if the plane is the declared one."""
        value, low, high = (f"{np.degrees(part):.1f}" for part in self.turn)
        sentence = (
            f"the plane of bending is rotated by {value} degrees ({low} to {high}) about the straight arm, because of the "
            "cameras or the base; the recordings were rotated back"
        )
        return sentence if self.turned else ""

    def undone(self, experiment: Experiment) -> Experiment:
        """Return the recordings, rotated back into the declared plane."""
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


def with_plane_corrected(experiment: Experiment) -> tuple[Experiment, Plane | None]:
    """Return the recordings, rotated back with a note if their plane is rotated; and that plane."""
    plane = plane_of(experiment)
    if plane is None or not plane.turned:
        return experiment, None
    return replace(plane.undone(experiment), notes=(*experiment.notes, plane.sentence)), plane


def plane_of(experiment: Experiment) -> Plane | None:
    """Return the plane of an arm that is declared as planar; None if motion out of the plane was not measured."""
    if len(experiment.directions) > 1:
        return None
    axis = int(np.argmax(np.abs(mount_frame(experiment.dataset.mount)[1])))
    across, sideways, trials, middles, noise = [], [], [], [], 0.0
    for run in experiment.runs:
        marker = farthest_seen(run, experiment)
        shown = run.shown(marker)
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
    """Return the index of the farthest marker that was measured in a sufficient part of a run."""
    seen = np.isfinite(run.measured[..., 0]).sum(axis=0)
    often = np.flatnonzero(seen >= _SEEN * seen.max())
    return int(max(often, key=lambda index: experiment.markers[index].arc_length))


def _slope(x: Array, y: Array) -> Estimate:
    return Estimate(float(x @ y / max(float(x @ x), 1e-30)))
