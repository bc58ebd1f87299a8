"""Two recordings of one arm as one experiment, and their residuals in time bins."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isclose

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array, Marker

#: Approximate number of bins over both recordings, and least width of a bin [s].
_ROWS, _NARROWEST = 1200, 0.02
#: Least reportable motion of the markers, as a share of the noise floor and of the length of the arm.
_NOISE, _LENGTH = 0.5, 2e-3
#: Range of the relative motion of a run.
_MOTION = (0.3, 10.0)
#: Smoothing window of a motion before it is shifted in time [s], at least five samples.
_SMOOTH = 0.06
#: Relative tolerance of declared parameters of the same arm.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Pair:
    """A reference recording and a current recording of one arm.

    Attributes:
        old, new: the prepared reference and current recordings.
    """

    old: Experiment
    new: Experiment

    @cached_property
    def experiment(self) -> Experiment:
        """Both recordings as one experiment, with the runs of the reference first."""
        old, new = self.old, self.new
        return replace(
            old,
            dataset=replace(old.dataset, trials=(*old.dataset.trials, *new.dataset.trials)),
            runs=(*old.runs, *new.runs),
            noise=np.maximum(old.noise, new.noise),
            rest_scatter=max(old.rest_scatter, new.rest_scatter),
        )

    @cached_property
    def is_new(self) -> NDArray[np.bool_]:
        """For each run (R,), whether it belongs to the current recording."""
        return np.arange(len(self.experiment.runs)) >= len(self.old.runs)

    @property
    def old_runs(self) -> range:
        """Indices of the runs of the reference recording."""
        return range(len(self.old.runs))

    @property
    def new_runs(self) -> range:
        """Indices of the runs of the current recording."""
        return range(len(self.old.runs), len(self.experiment.runs))

    @property
    def reportable(self) -> float:
        """Least RMS distance by which a change must move the markers to be reported [m]."""
        return max(_NOISE * self.experiment.noise_rms, _LENGTH * self.experiment.dataset.length)

    @cached_property
    def motion(self) -> tuple[float, ...]:
        """For each run, its RMS distance from the mean pose relative to that in the reference recording."""
        seen = (run.compared[:, np.isfinite(run.compared).any(axis=(0, 2))] for run in self.experiment.runs)
        sizes = [float(np.sqrt(np.mean(np.nanvar(places, axis=0)))) for places in seen]
        usual = float(np.sqrt(np.mean(np.square([sizes[k] for k in self.old_runs]))))
        return tuple(float(np.clip(size / usual, *_MOTION)) for size in sizes)

    @cached_property
    def smooth(self) -> tuple[Array, ...]:
        """For each run (T, M, A) smoothed marker positions without gaps [m]."""
        return tuple(_smooth(run) for run in self.experiment.runs)

    def later(self, index: int, delays: Array) -> Array:
        """Return the shift (B, M, A, C) of a run's markers by delays (C,) [s] of its command, compared with no delay [m].

        A delayed command shifts the whole response of the arm, including the part that no model explains.
        """
        run, seen = self.experiment.runs[index], self.smooth[index]
        if run.start_pose is not None:
            return np.zeros((len(self.bins[index].starts), *seen.shape[1:], len(delays)))
        flat = seen.reshape(len(seen), -1)
        ahead = np.stack(
            [np.stack([np.interp(run.instants + each, run.instants, one) for one in flat.T], axis=-1) for each in delays], axis=-1
        )
        return self.bins[index](seen[..., None] - ahead.reshape(*seen.shape, len(delays)))

    @cached_property
    def width(self) -> float:
        """Width of a bin [s]."""
        runs = self.experiment.runs
        total = sum(float(run.time[-1] - run.time[0]) for run in runs)
        return max(_NARROWEST, total / _ROWS)

    @cached_property
    def bins(self) -> tuple[Bins, ...]:
        """Bins of each run."""
        return tuple(Bins.of(run, self.width) for run in self.experiment.runs)


@dataclass(frozen=True, eq=False)
class Bins:
    """Averaging of the samples of a run in time bins.

    Attributes:
        starts: (B,) first sample of each bin.
        seen: (T, M) whether a marker was visible.
        counts: (B, M) number of samples in which it was visible.
        time: (B,) time since the start of the run [s].
    """

    starts: NDArray[np.intp]
    seen: NDArray[np.bool_]
    counts: Array
    time: Array

    @classmethod
    def of(cls, run: Run, width: float) -> Bins:
        """Return bins of this width [s], or of one sample."""
        since = run.instants - run.time[0]
        place = np.floor(since / max(width, run.step) + 1e-6).astype(int)
        starts = np.flatnonzero(np.diff(place, prepend=-1))
        seen: NDArray[np.bool_] = np.asarray(np.isfinite(run.compared).all(axis=2))
        sizes = np.diff(starts, append=len(since))
        return cls(starts, seen, np.add.reduceat(seen.astype(float), starts), np.add.reduceat(since, starts) / sizes)

    def __call__(self, values: Array) -> Array:
        """Return means (B, M, ...) of values (T, M, ...) over the samples with a visible marker; 0 without any."""
        mask = self.seen.reshape(*self.seen.shape, *[1] * (values.ndim - 2))
        sums = np.add.reduceat(np.where(mask, values, 0.0), self.starts, axis=0)
        counts = self.counts.reshape(*self.counts.shape, *[1] * (values.ndim - 2))
        return np.asarray(sums / np.maximum(counts, 1.0))

    def of_all(self, values: Array) -> Array:
        """Return means (B, ...) of values (T, ...) over all samples."""
        sizes = np.diff(self.starts, append=len(values)).reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(np.add.reduceat(values, self.starts, axis=0) / sizes)


def _smooth(run: Run) -> Array:
    """Return smoothed marker positions (T, M, A) with gaps interpolated [m]; zeros for hardly visible markers.

    A. Savitzky, M. J. E. Golay, Anal. Chem. 36 (1964).
    """
    out = np.zeros_like(run.compared)
    window = 2 * max(2, round(_SMOOTH / run.step / 2)) + 1
    for marker in range(run.compared.shape[1]):
        seen = np.isfinite(run.compared[:, marker]).all(axis=1)
        if seen.sum() > window:
            for axis in range(out.shape[2]):
                whole = np.interp(run.instants, run.instants[seen], run.compared[seen, marker, axis])
                out[:, marker, axis] = savgol_filter(whole, window, 2)
    return out


def pair(old: Experiment, new: Experiment) -> Pair:
    """Return two recordings as a pair.

    Raises:
        IdentificationError: they are of different arms, or have different markers.
    """
    hint = "both recordings must be of one arm with equal declared values, except for those of single trials"
    for name in ("bending", "length", "mass", "diameter", "mount", "torsion"):
        was, is_ = getattr(old.dataset, name), getattr(new.dataset, name)
        if was != is_ if isinstance(was, str) else not isclose(was, is_, rel_tol=_SAME):
            expected = f"{was}, as in {old.dataset.name}"
            raise IdentificationError(f"{name} of {new.dataset.name}", expected=expected, received=is_, hint=hint)
    for what, listings in (
        ("sections", [[str(section) for section in each.dataset.sections] for each in (old, new)]),
        ("markers", [[_placed(marker) for marker in each.markers] for each in (old, new)]),
    ):
        if listings[0] != listings[1]:
            expected, received = (", ".join(each) or "none" for each in listings)
            raise IdentificationError(f"{what} of {new.dataset.name}", expected=expected, received=received, hint=hint)
    return Pair(old, new)


def _placed(marker: Marker) -> str:
    offset = f", {marker.radius:g} m off the backbone at {marker.angle:g} rad" if marker.radius else ""
    return f"{marker.name} at {marker.arc_length:g} m{offset}"
