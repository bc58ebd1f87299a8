"""A dataset prepared for comparison (cleaned, trimmed to its start, the input as a torque), and the models that simulate it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.command import command_of, mean_along
from hsr_pin.identification.contradictions import contradictions
from hsr_pin.identification.evaluation import Case, predict, predict_with_slopes, simulate_cases
from hsr_pin.identification.holds import without_repeats
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.nuisance import rest_scatter
from hsr_pin.identification.prepared import BASE, QUIETEST, REST, Prepared, Run
from hsr_pin.identification.reach import farthest
from hsr_pin.identification.release import median, start_of
from hsr_pin.identification.smoothing import Filter, smoothing_of
from hsr_pin.parameters import Parameter
from hsr_pin.recordings.clean import clean
from hsr_pin.recordings.noise import white_noise
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array, Dataset, Trial

#: A marker that moves less than this multiple of its noise and less than this distance [m] has not moved.
_STILL = (10.0, 0.002)
#: Largest share of positions beyond the reach of the arm; a trial with more does not belong to this arm.
_FEW = 0.01
#: Standard deviation of a median relative to that of a mean.
_MEDIAN = 1.25


@dataclass(frozen=True, eq=False)
class Experiment(Prepared):
    """Recordings of an arm with the models that simulate them, as fits and diagnoses use them."""

    def some(self, kept: Sequence[int], samples: int) -> Experiment:
        """Return an experiment with some of the runs and approximately the given number of samples of each.

        Disturbances of releases are not modelled in it: far from the solution, they explain an oscillation as well as a missing
        law would.
        """
        runs = (self.runs[k] for k in kept)
        few = tuple(replace(run, every=max(1, len(run.time) // samples)) for run in runs)
        return replace(self, runs=few, disturbed_release=False)

    def of_runs(self, runs: Sequence[Run]) -> Experiment:
        """Return an experiment with some of the runs."""
        return replace(self, runs=tuple(runs))

    # the functions of `evaluation`, as methods
    predict = predict
    predict_with_slopes = predict_with_slopes

    def probe(self, hypothesis: Hypothesis, points: Array) -> list[Array]:
        """Return, for each run, the marker positions (T, C, M, A) [m] at each of the parameter values (C, P)."""
        answers = simulate_cases(self, hypothesis, (Case(run, points) for run in self.runs))
        return [answer.positions[..., self.axes] for answer in answers]

    def changes_of_variant(self, hypothesis: Hypothesis, new: Sequence[Parameter], run: Run, changes: Array) -> Array:
        """Return the changes (n, A') of a run's residuals by the last part's amplitudes, from those (n, A) of its base variant.

        An amplitude that scales differently with the stiffness level has a different effect; an amplitude of another level has
        none.
        """
        part, powers = hypothesis.parts[-1], [fact.level_exponent for fact in new if fact.amplitude] or [new[0].level_exponent]
        if part.resized:
            level = run.trial.keq / self.levels[0]
            changes = changes * level ** np.tile(powers, changes.shape[1] // len(powers))
        if part.levels:
            acts = np.array([hypothesis.acts(fact.name, run) for fact in new])
            changes = np.asarray(changes[:, :, None] * acts).reshape(len(changes), -1)
        return changes


def prepare(dataset: Dataset, *, delay: float = 0.0) -> Experiment:
    """Clean a dataset and trim it to the data that can be compared with a model.

    Args:
        dataset: the dataset as read.
        delay: time after the declared start from which trials that start from a pose are used [s]; for releases by hand.

    Raises:
        IdentificationError: no usable data are left.
    """
    if not dataset.trials:
        raise IdentificationError("trials", expected="at least one", received="none")
    moving = _bending_markers(dataset)
    dataset, held = without_repeats(dataset, moving)
    dataset = clean(dataset, remove_spikes=not held)  # samples far apart in time differ from their neighbours by motion
    smoothing, filtered = (None, "") if held else smoothing_of(dataset)
    if not (np.isfinite(delay) and delay >= 0):
        raise IdentificationError("delay", expected="zero or more [s]", received=delay)
    noise = _noise(dataset, moving, held=bool(held)) * (smoothing.noise_factor if smoothing else 1.0)
    reach, doubtful = farthest(dataset, moving)
    delayed = f"releases are used from {delay:g} s after their declared start" if delay else ""
    runs, notes = [], [*doubtful, *filter(None, (held, filtered, delayed))]
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
    """Return an experiment with the named trials only; the scatter of their resting positions is estimated anew."""
    noise, runs = experiment.noise, tuple(run for run in experiment.runs if run.trial.name in names)
    far, sigma = int(np.argmax([marker.arc_length for marker in experiment.markers])), float(noise.max())
    places = [place for run in runs if (place := _resting(run, experiment.dataset, far, sigma))]
    samples = min((run.samples_at_rest for run in runs if run.start_pose is None), default=REST)
    scatter = rest_scatter(places, _MEDIAN * sigma / samples**0.5)
    notes = [note for note in experiment.notes if note != _scattered(experiment.rest_scatter)]
    return replace(experiment, runs=runs, rest_scatter=scatter, notes=(*notes, _scattered(scatter)) if scatter else tuple(notes))


def _scattered(scatter: float) -> str:
    return f"the resting position of the arm varies from trial to trial by {1e3 * scatter:.1f} mm (standard deviation)"


def _resting(run: Run, dataset: Dataset, far: int, noise: float) -> tuple[object, Array, Array] | None:
    """Return the conditions of a trial, its resting position and its origin (K,) [m]; None if the arm does not come to rest.

    Trials under the same conditions should have the same resting position.
    """
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
    """Return the indices of the markers that depend on bending."""
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


def informative(experiment: Experiment) -> list[Run]:
    """Return the runs in which the arm moves, and those in which it rests if it rests in several places."""
    moving = [run for run in experiment.runs if moves(run.measured, experiment.noise)]
    still = [run for run in experiment.runs if run not in moving]
    places = np.stack([median(run.measured) for run in still]) if still else np.empty((0, len(experiment.noise), 3))
    return list(experiment.runs) if len(still) > 1 and moves(places, experiment.noise) else moving


def moves(measured: Array, noise: Array) -> bool:
    """Return whether any marker moves by more than its noise (M,) [m], for positions (T, M, 3) [m]."""
    seen = np.all(np.isfinite(measured).any(axis=0), axis=1)
    low, high = (np.nanpercentile(measured[:, seen], p, axis=0) for p in (2, 98))
    span = np.linalg.norm(high - low, axis=1)
    return bool(np.any(span > np.maximum(_STILL[0] * noise[seen], _STILL[1])))


def _noise(dataset: Dataset, moving: list[int], *, held: bool) -> Array:
    """Return the noise (M,) [m], the median over the trials; a marker with too few samples gets the largest of the others."""
    tracks = [trial.trajectory.positions[:, moving] for trial in dataset.trials]
    if held:  # one trial has too few
        tracks = [np.concatenate([np.append(track[_new(track)], np.full((1, *track.shape[1:]), np.nan), 0) for track in tracks])]
    floors = np.array([_floor(track, dataset.axes, held) for track in tracks])
    known = [column[np.isfinite(column)] for column in floors.T]
    noise = np.array([np.median(column) if len(column) else np.nan for column in known])
    if not np.isfinite(noise).any():
        raise IdentificationError("markers", expected="consecutive samples of at least one marker", received="gaps everywhere")
    return np.maximum(np.where(np.isfinite(noise), noise, np.nanmax(noise)), QUIETEST)


def _run(trial: Trial, dataset: Dataset, moving: list[int], noise: Array, reach: Array, delay: float) -> Run | str:
    """Return the run of a trial, or the reason why it cannot be used."""
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
        time=_read_only(trajectory.time[first:]),
        torque=_read_only(mean_along(command[first:], dataset)),
        measured=_read_only(measured),
        start_pose=None if start is None else _read_only(start.pose[moving]),
        lead=0.0 if start is None else start.lead,
        start_velocity=None if start is None else _read_only(start.velocity[moving]),
        interpolated=bool(trial.interpolated),
        axes=dataset.axes,
        by_section=_read_only(command[first:]) if command.shape[1] > 1 else None,
    )


def _floor(track: Array, axes: tuple[int, ...], held: bool) -> Array:
    """Return the noise (M,) [m] of a coordinate along the axes, for positions (T, M, 3).

    In few samples far apart, motion looks like noise; the lateral coordinate is used if it is quieter.
    """
    sigma = white_noise(track)
    along = np.sqrt(np.mean(sigma[:, axes] ** 2, axis=1))
    across = np.delete(sigma, axes, axis=1)
    quiet = across[:, 0] if held and across.size else along
    return np.asarray(np.where(quiet > 0, np.fmin(along, quiet), along))


def _new(measured: Array) -> NDArray[np.intp]:
    """Return the samples (R,) in which a marker was measured, for positions (T, M, 3) with repeated samples as gaps."""
    seen = np.asarray(np.isfinite(measured).all(axis=2))
    return np.flatnonzero(seen.any(axis=1))


def _independent(run: Run, smoothing: Filter) -> NDArray[np.intp]:
    """Return the samples (R,) of a smoothed run that have independent noise and no influence of unsimulated motion.

    The first samples of an arm that is held or at rest may be used, because the pose was the same before.
    """
    before = len(run.trial.trajectory.time) - len(run.time)
    moves = run.start_velocity is not None and bool(run.start_velocity.any())
    first = smoothing.half if moves or before < smoothing.half else 0
    return np.arange(first, max(first + 1, len(run.time) - smoothing.half), smoothing.spacing)


def _read_only(values: Array) -> Array:
    array = np.array(values)
    array.flags.writeable = False
    return array
