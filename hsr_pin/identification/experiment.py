"""A dataset made ready to be compared with simulations: cleaned, cut to its start, its input a torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.release import start_of
from hsr_pin.recordings.clean import clean, noise_floor
from hsr_pin.robot.pressure import PAPER
from hsr_pin.trajectory import Array, Dataset, Marker, Trial, read_only

#: Markers nearer to the base than this share of the length do not tell anything about bending.
BASE = 0.02
#: A marker that moves less than this many noise floors, and less than this many metres, has not moved.
_STILL = (10.0, 0.002)
#: The backbone does not stretch: a marker farther from the base than this times its arc length plus this [m] is no marker of this
#: arm. A trial with more than this share of such positions is none of this arm's.
_REACH, _OFF, _FEW = 1.1, 0.05, 0.01
#: No recording is less noisy than this [m].
_QUIETEST = 1e-6


@dataclass(frozen=True, eq=False)
class Run:
    """One trial as the model must reproduce it.

    Attributes:
        trial: where it comes from.
        time: (T,) [s] of the measured samples, from the start on.
        torque: (T,) [N m] commanded: tau, or Eqs. (4) and (5) with the declared Keq; zeros for a release.
        measured: (T, M, 3) [m]; NaN in gaps.
        start_pose: (M, 3) [m] where the markers are at the start; None: settled under the first torque.
        lead: fraction of a sample by which the motion starts before ``time[0]`` (a release between two samples).
        start_velocity: (M, 3) [m/s] of the markers at the start; None: at rest.
    """

    trial: Trial
    time: Array
    torque: Array
    measured: Array
    start_pose: Array | None
    lead: float
    start_velocity: Array | None = None

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


@dataclass(frozen=True, eq=False)
class Experiment:
    """All usable trials of a dataset.

    Attributes:
        dataset: cleaned.
        runs: one per usable trial.
        markers: (M,) those that tell about bending (not the base's).
        noise: (M,) [m] noise floor: standard deviation of each marker's coordinates.
        notes: what was left out and why.
    """

    dataset: Dataset
    runs: tuple[Run, ...]
    markers: tuple[Marker, ...]
    noise: Array
    notes: tuple[str, ...] = ()

    @property
    def noise_rms(self) -> float:
        """RMS distance [m] that noise alone leaves between model and markers."""
        return float(np.sqrt(3 * np.mean(self.noise**2)))


def prepare(dataset: Dataset, *, delay: float = 0.0) -> Experiment:
    """Clean a dataset and cut it to what a model can be compared with.

    Args:
        dataset: as read.
        delay: trials that start from a pose are followed only from so long after their declared start [s]: for releases by hand.

    Raises:
        IdentificationError: nothing usable is left.
    """
    if not dataset.trials:
        raise IdentificationError("trials", expected="at least one", received="none")
    dataset = clean(dataset)
    moving = _bending_markers(dataset)
    if not (np.isfinite(delay) and delay >= 0):
        raise IdentificationError("delay", expected="zero or more [s]", received=delay)
    noise = _noise(dataset, moving)
    runs, notes = [], [f"releases are followed from {delay:g} s after their declared start"] if delay else []
    for trial in dataset.trials:
        run = _run(trial, moving, noise, delay)
        if isinstance(run, str):
            notes.append(f"{trial.name} is left out: {run}")
        else:
            runs.append(run)
    if not runs:
        raise IdentificationError("trials", expected="at least one that can be used", received="; ".join(notes))
    markers = tuple(dataset.markers[i] for i in moving)
    return Experiment(dataset, tuple(runs), markers, noise, tuple(notes))


def _bending_markers(dataset: Dataset) -> list[int]:
    """Indices of the markers that tell about bending."""
    for marker in dataset.markers:
        if not 0 <= marker.arc_length <= dataset.length * (1 + 1e-9):
            raise IdentificationError(
                f"arc length of marker {marker.name}",
                expected=f"from 0 to the arm's length, {dataset.length:g} m",
                received=f"{marker.arc_length:g} m",
            )
    moving = [i for i, m in enumerate(dataset.markers) if m.arc_length > BASE * dataset.length]
    if not moving:
        raise IdentificationError("markers", expected="at least one beyond the base", received="base markers only")
    return moving


def moves(run: Run, noise: Array) -> bool:
    """Whether any marker of a run moves by more than its noise."""
    seen = np.isfinite(run.measured[..., 0]).any(axis=0)
    low, high = (np.nanpercentile(run.measured[:, seen], p, axis=0) for p in (2, 98))
    span = np.linalg.norm(high - low, axis=1)
    return bool(np.any(span > np.maximum(_STILL[0] * noise[seen], _STILL[1])))


def _noise(dataset: Dataset, moving: list[int]) -> Array:
    """(M,) [m] the median over the trials; where a marker was seen too seldom to tell, the largest of the others'."""
    floors = np.array([noise_floor(trial)[moving] for trial in dataset.trials])
    known = [column[np.isfinite(column)] for column in floors.T]
    noise = np.array([np.median(column) if len(column) else np.nan for column in known])
    if not np.isfinite(noise).any():
        raise IdentificationError("markers", expected="some consecutive samples of one of them", received="gaps everywhere")
    return np.maximum(np.where(np.isfinite(noise), noise, np.nanmax(noise)), _QUIETEST)


def _run(trial: Trial, moving: list[int], noise: Array, delay: float) -> Run | str:
    """The run, or in words why there is none."""
    trajectory = trial.trajectory
    first, start = trial.first_sample, None
    if not trial.starts_at_rest:
        start = start_of(trial, float(noise.max()), delay)
        first = start.sample
    if len(trajectory.time) - first < 5:
        return f"only {len(trajectory.time) - first} samples follow its start"
    measured = trajectory.positions[first:, moving]
    beyond = np.linalg.norm(measured, axis=2) > _REACH * np.array([trajectory.markers[i].arc_length for i in moving]) + _OFF
    if beyond.mean() > _FEW:
        return f"{100 * beyond.mean():.0f} % of its positions are farther from the base than the arm reaches"
    measured = np.where(beyond[..., None], np.nan, measured)
    if np.isfinite(measured).all(axis=2).sum() < 10:
        return "fewer than 10 positions were seen"
    if trajectory.torque is not None:
        torque = trajectory.torque
    elif trajectory.pressures is not None:
        torque = trial.keq * _bending(trajectory.pressures)
    else:
        torque = np.zeros(len(trajectory.time))
    return Run(
        trial=trial,
        time=_held(trajectory.time[first:]),
        torque=_held(torque[first:]),
        measured=_held(measured),
        start_pose=None if start is None else _held(start.pose[moving]),
        lead=0.0 if start is None else start.lead,
        start_velocity=None if start is None else _held(start.velocity[moving]),
    )


def _held(values: Array) -> Array:
    array = read_only(values)
    assert array is not None
    return array


def _bending(pressures: Array) -> Array:
    """Eq. (4) as it stands: measured pressures may leave the regulators' range by their noise."""
    constant, first, second = PAPER.bending_plane
    return np.asarray(constant + first * pressures[:, 0] + second * pressures[:, 1])
