"""A dataset made ready to be compared with simulations: cleaned, cut to its start, its input a torque."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.command import command_of, mean_along
from hsr_pin.identification.contradictions import contradictions
from hsr_pin.identification.holds import without_repeats
from hsr_pin.identification.nuisance import LETS_GO, rest_scatter
from hsr_pin.identification.reach import farthest
from hsr_pin.identification.release import median, start_of
from hsr_pin.identification.smoothing import Filter, smoothing_of
from hsr_pin.recordings.clean import clean
from hsr_pin.recordings.noise import white_noise
from hsr_pin.robot.specification import ArmSpecification, mount_frame
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered
from hsr_pin.trajectory import Array, Dataset, Marker, Trial

#: Markers nearer to the base than this share of the length do not tell anything about bending.
BASE = 0.02
#: A marker that moves less than this many noise floors, and less than this many metres, has not moved.
_STILL = (10.0, 0.002)
#: A trial with more than this share of positions beyond the reach of the arm is none of this arm's.
_FEW = 0.01
#: Samples at most over which the pose at rest is averaged.
_REST = 20
#: Standard deviation of a median over that of a mean.
_MEDIAN = 1.25
#: No recording is less noisy than this [m].
_QUIETEST = 1e-6
#: Share of what a run moves that a step of integration may be in error by.
_FINE = 0.02


@dataclass(frozen=True, eq=False)
class Run:
    """One trial as the model must reproduce it.

    Attributes:
        trial: where it comes from.
        time: (T,) [s] of the measured samples, from the start on.
        torque: (T,) [N m] commanded: tau, or Eqs. (4) and (5) with the declared Keq; zeros for a release. In space complex:
            towards x, and towards y of the base. Of an arm of sections the mean along it, where one number has to stand for all.
        measured: (T, M, 3) [m]; NaN in gaps.
        start_pose: (M, 3) [m] where the markers are at the start; None: settled under the first torque.
        lead: fraction of a sample by which the motion starts before ``time[0]`` (a release between two samples).
        start_velocity: (M, 3) [m/s] of the markers at the start; None: at rest.
        interpolated: the torque goes straight from sample to sample instead of being held.
        axes: the world's coordinates in which the arm moves.
        by_section: (T, S) [N m] commanded, complex, of an arm of S > 1 sections; None: the same for all.
        place: in the session, from 0 for the first of its trials to 1 for the last.
        every: only one in so many of the samples that count is looked at.
        rows: (R,) the samples that count: those that are new, and whose noise is independent; None: all.
        smoothing: the filter that its markers went through; None: none.
        found_poses: the pose at the start, its rate and its modes, by model: for others of its values the search begins there.
        declared: the arm as the trial declares it, by chain.
        delivered: what arrives of the command where no muscle changes it, by whether a curve is taken as one.
    """

    trial: Trial
    time: Array
    torque: Array
    measured: Array
    start_pose: Array | None
    lead: float
    start_velocity: Array | None = None
    interpolated: bool = False
    axes: tuple[int, ...] = (0, 2)
    by_section: Array | None = None
    place: float = 0.0
    every: int = 1
    rows: NDArray[np.intp] | None = None
    smoothing: Filter | None = None
    found_poses: dict[object, tuple[Array, Array, Array]] = field(default_factory=dict, repr=False)
    declared: dict[object, ArmSpecification] = field(default_factory=dict, repr=False)
    delivered: dict[bool, Delivered] = field(default_factory=dict, init=False, repr=False)

    @property
    def looked_at(self) -> NDArray[np.intp]:
        """(R,) indices of the samples that are looked at."""
        return np.asarray((np.arange(len(self.time)) if self.rows is None else self.rows)[:: self.every])

    @property
    def instants(self) -> Array:
        """(R,) [s] of these."""
        return np.asarray(self.time[self.looked_at])

    @cached_property
    def compared(self) -> Array:
        """(R, M, A) [m] what was measured along the axes, of the samples that are looked at."""
        return np.asarray(self.tracked[self.looked_at])

    @property
    def tracked(self) -> Array:
        """(T, M, A) [m] what was measured along the axes."""
        return np.asarray(self.measured[:, :, self.axes])

    @property
    def whole(self) -> Run:
        """The same with all samples looked at."""
        return self if self.rows is None and self.every == 1 else replace(self, rows=None, every=1)

    @cached_property
    def moved(self) -> float:
        """RMS way [m] about its mean place of the marker that goes farthest."""
        seen = np.asarray(np.isfinite(self.compared).all(axis=2))
        ways = [self.compared[seen[:, m], m].var(axis=0).sum() for m in range(seen.shape[1]) if seen[:, m].any()]
        return float(np.sqrt(max(ways, default=0.0)))

    @property
    def tolerance(self) -> float:
        """Error of a step [m at the tip] that is small beside what moves."""
        return max(_FINE * self.moved, _QUIETEST)

    @property
    def command(self) -> Array:
        """(T, S) [N m] what drives each section; where all are driven alike (T, 1)."""
        return self.torque[:, None] if self.by_section is None else self.by_section

    @property
    def drive(self) -> Array:
        """(T,) [N m] the torque as recordings have it; in space (T, 2), or (T, 2 S) for S sections."""
        if not np.iscomplexobj(self.torque):
            return self.torque
        return np.stack([self.command.real, self.command.imag], axis=2).reshape(len(self.time), -1)

    @property
    def span(self) -> float:
        """How far the torque goes from its one end to the other [N m]; the farthest of the sections'."""
        return float(np.hypot(np.ptp(self.command.real, axis=0), np.ptp(self.command.imag, axis=0)).max())

    @cached_property
    def rest(self) -> Array:
        """(M, 3) [m] where the markers are before the first change of command; NaN for one that is not seen."""
        return median(self.measured[self._at_rest])

    @property
    def resting(self) -> int:
        """Samples before the first change of command, twenty at most."""
        changes = np.flatnonzero(np.diff(self.command, axis=0).any(axis=1))
        return min(int(changes[0]) + 1 if len(changes) else _REST, _REST)

    @property
    def _at_rest(self) -> slice:
        """Those of these that a filter did not mix with others, if there are any."""
        half = self.smoothing.half if self.smoothing else 0
        return slice(half, self.resting - half) if self.resting > 2 * half else slice(0, self.resting)

    @property
    def samples_at_rest(self) -> int:
        """How many independent samples these are."""
        inside = self._at_rest
        rows = self.whole.looked_at if self.rows is None else self.rows
        return max(1, int(((rows >= inside.start) & (rows < inside.stop)).sum()))

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
        noise: (M,) [m] noise floor: standard deviation of each marker's coordinates along the axes.
        notes: what was left out and why.
        rest_scatter: [m] standard deviation, over the trials, of where the farthest marker rests.
        hand: whether what let the arm go may have held it a little longer.
    """

    dataset: Dataset
    runs: tuple[Run, ...]
    markers: tuple[Marker, ...]
    noise: Array
    notes: tuple[str, ...] = ()
    rest_scatter: float = 0.0
    hand: bool = True

    @cached_property
    def reach(self) -> Array:
        """(M,) [m] arc lengths of the markers."""
        return np.array([marker.arc_length for marker in self.markers])

    @property
    def axes(self) -> tuple[int, ...]:
        """The world's coordinates in which the arm moves: what is compared, and fitted to."""
        return self.dataset.axes

    @property
    def directions(self) -> tuple[complex, ...]:
        """In which the arm bends: as numbers, one in the plane, two in space."""
        return (1.0, 1.0j)[: len(self.axes) - 1]

    @property
    def lasting(self) -> int:
        """How many numbers say where the arm rests in a trial: one for each direction, none where it always rests alike."""
        return len(self.directions) if self.rest_scatter > 0 else 0

    def own(self, run: Run) -> int:
        """How many numbers may belong to a run and not to the arm."""
        released = 1 + len(self.directions) * (1 + self.hand * len(LETS_GO))
        return self.lasting + (0 if run.start_pose is None else released)

    def cameras(self, columns: Columns) -> Cameras:
        """What is seen of arms with these markers."""
        return Cameras(columns, self.reach, np.array([marker.beside for marker in self.markers]), fast=True)

    @cached_property
    def levels(self) -> tuple[float, ...]:
        """The declared stiffnesses [Nm/rad], the softest first."""
        return tuple(sorted({trial.keq for trial in self.dataset.trials}))

    @property
    def noise_rms(self) -> float:
        """RMS distance [m] along the axes that noise alone leaves between model and markers."""
        return float(np.sqrt(len(self.axes) * np.mean(self.noise**2)))


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
    moving = _bending_markers(dataset)
    dataset, held = without_repeats(dataset, moving)
    dataset = clean(dataset, remove_spikes=not held)  # samples far apart in time stand off their neighbours by motion
    smoothing, filtered = (None, "") if held else smoothing_of(dataset)
    if not (np.isfinite(delay) and delay >= 0):
        raise IdentificationError("delay", expected="zero or more [s]", received=delay)
    noise = _noise(dataset, moving, held=bool(held)) * (smoothing.undervalued if smoothing else 1.0)
    reach, doubts = farthest(dataset, moving)
    late = f"releases are followed from {delay:g} s after their declared start" if delay else ""
    runs, notes = [], [*doubts, *filter(None, (held, filtered, late))]
    for place, trial in zip(np.linspace(0, 1, len(dataset.trials)), dataset.trials, strict=True):
        run = _run(trial, dataset, moving, noise, reach, delay)
        if isinstance(run, str):
            notes.append(f"{trial.name} is left out: {run}")
        else:
            rows = _new(run.measured) if held else _independent(run, smoothing) if smoothing else None
            runs.append(replace(run, place=float(place), rows=rows, smoothing=smoothing))
    if not runs:
        raise IdentificationError("trials", expected="at least one that can be used", received="; ".join(notes))
    markers = tuple(dataset.markers[i] for i in moving)
    notes = [*contradictions(dataset, runs, markers), *notes]
    return restricted(Experiment(dataset, tuple(runs), markers, noise, tuple(notes)), [run.trial.name for run in runs])


def restricted(experiment: Experiment, names: Collection[str]) -> Experiment:
    """The named trials alone: what trials tell only together, how far apart they rest, is told by these."""
    noise, runs = experiment.noise, tuple(run for run in experiment.runs if run.trial.name in names)
    far, sigma = int(np.argmax([marker.arc_length for marker in experiment.markers])), float(noise.max())
    places = [place for run in runs if (place := _resting(run, experiment.dataset, far, sigma))]
    samples = min((run.samples_at_rest for run in runs if run.start_pose is None), default=_REST)
    scatter = rest_scatter(places, _MEDIAN * sigma / samples**0.5)
    notes = [note for note in experiment.notes if note != _scattered(experiment.rest_scatter)]
    return replace(experiment, runs=runs, rest_scatter=scatter, notes=(*notes, _scattered(scatter)) if scatter else tuple(notes))


def _scattered(scatter: float) -> str:
    return f"the arm rests within {1e3 * scatter:.1f} mm (standard deviation) of one place, anew in every trial"


def _resting(run: Run, dataset: Dataset, far: int, noise: float) -> tuple[object, Array, Array] | None:
    """Which trials should rest where this one does, where that is, and whence it came (K,) [m]; None where it does not rest."""
    along = mount_frame(dataset.mount)[0]
    across = [axis for axis in run.axes if along[axis] == 0]
    conditions = (run.trial.keq, run.trial.tip_mass, tuple(np.round(run.command[0] / run.trial.keq, 4).astype(complex).tolist()))
    if run.start_pose is None:
        place = run.rest[far, across]
        return (conditions, place, np.zeros_like(place)) if np.isfinite(place).all() else None
    last = run.measured[-max(10, len(run.time) // 20) :, far, across]
    seen = last[np.isfinite(last).all(axis=1)]
    if run.trial.trajectory.has_input or len(seen) < 5 or np.ptp(seen, axis=0).max() > max(10 * noise, 1e-3):
        return None
    origin = run.start_pose[far, across]
    return (conditions, np.array([column.mean() for column in seen.T]), origin) if np.isfinite(origin).all() else None


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
    seen = np.all(np.isfinite(run.measured).any(axis=0), axis=1)
    low, high = (np.nanpercentile(run.measured[:, seen], p, axis=0) for p in (2, 98))
    span = np.linalg.norm(high - low, axis=1)
    return bool(np.any(span > np.maximum(_STILL[0] * noise[seen], _STILL[1])))


def _noise(dataset: Dataset, moving: list[int], *, held: bool) -> Array:
    """(M,) [m] the median over the trials; where a marker was seen too seldom to tell, the largest of the others'."""
    tracks = [trial.trajectory.positions[:, moving] for trial in dataset.trials]
    if held:  # too few in a trial
        tracks = [np.concatenate([np.append(track[_new(track)], np.full((1, *track.shape[1:]), np.nan), 0) for track in tracks])]
    floors = np.array([_floor(track, dataset.axes, held) for track in tracks])
    known = [column[np.isfinite(column)] for column in floors.T]
    noise = np.array([np.median(column) if len(column) else np.nan for column in known])
    if not np.isfinite(noise).any():
        raise IdentificationError("markers", expected="some consecutive samples of one of them", received="gaps everywhere")
    return np.maximum(np.where(np.isfinite(noise), noise, np.nanmax(noise)), _QUIETEST)


def _run(trial: Trial, dataset: Dataset, moving: list[int], noise: Array, reach: Array, delay: float) -> Run | str:
    """The run, or in words why there is none."""
    trajectory, command = trial.trajectory, command_of(trial, dataset)
    first, start = trial.first_sample, None
    if not trial.starts_at_rest:
        start = start_of(trial, float(noise.max()), delay)
        first = start.sample
    if len(trajectory.time) - first < 5:
        return f"only {len(trajectory.time) - first} samples follow its start"
    measured = trajectory.positions[first:, moving]
    beyond = np.linalg.norm(measured, axis=2) > reach
    if beyond.mean() > _FEW:
        return f"{100 * beyond.mean():.0f} % of its positions are farther from the base than the arm reaches"
    measured = np.where(beyond[..., None], np.nan, measured)
    if np.isfinite(measured).all(axis=2).sum() < 10:
        return "fewer than 10 positions were seen"
    return Run(
        trial=trial,
        time=_held(trajectory.time[first:]),
        torque=_held(mean_along(command[first:], dataset)),
        measured=_held(measured),
        start_pose=None if start is None else _held(start.pose[moving]),
        lead=0.0 if start is None else start.lead,
        start_velocity=None if start is None else _held(start.velocity[moving]),
        interpolated=bool(trial.interpolated),
        axes=dataset.axes,
        by_section=_held(command[first:]) if command.shape[1] > 1 else None,
    )


def _floor(track: Array, axes: tuple[int, ...], held: bool) -> Array:
    """(M,) [m] noise in a coordinate along the axes, of positions (T, M, 3).

    Few samples that are held far apart show motion as if it were noise: there the coordinate across counts where it is quieter.
    """
    sigma = white_noise(track)
    along = np.sqrt(np.mean(sigma[:, axes] ** 2, axis=1))
    across = np.delete(sigma, axes, axis=1)
    quiet = across[:, 0] if held and across.size else along
    return np.asarray(np.where(quiet > 0, np.fmin(along, quiet), along))


def _new(measured: Array) -> NDArray[np.intp]:
    """(R,) the samples in which a marker was seen, of (T, M, 3) positions whose repeats are gaps."""
    seen = np.asarray(np.isfinite(measured).all(axis=2))
    return np.flatnonzero(seen.any(axis=1))


def _independent(run: Run, smoothing: Filter) -> NDArray[np.intp]:
    """(R,) the samples of a smoothed run whose noise is independent, and that show nothing of what is not simulated.

    An arm that is held, or at rest, may be shown from before its start: there it was the same.
    """
    before = len(run.trial.trajectory.time) - len(run.time)
    moves = run.start_velocity is not None and bool(run.start_velocity.any())
    first = smoothing.half if moves or before < smoothing.half else 0
    return np.arange(first, max(first + 1, len(run.time) - smoothing.half), smoothing.spacing)


def _held(values: Array) -> Array:
    array = np.array(values)
    array.flags.writeable = False
    return array
