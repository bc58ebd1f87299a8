"""Two recordings of one arm as one experiment, and their residuals in bins of time."""

from __future__ import annotations

from collections.abc import Sequence
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

#: Rows of one marker's coordinate over both recordings, about; and the narrowest bin [s].
_ROWS, _NARROWEST = 1200, 0.02
#: A change shows if it moves the markers by this share of the noise floor, and of the length of the arm.
_NOISE, _LENGTH = 0.5, 2e-3
#: A run moves at least this much, over what those of OLD do, and at most.
_MOTION = (0.3, 10.0)
#: Over how long motion is made smooth before it is shifted in time [s], in five samples at least.
_SMOOTH = 0.06
#: Declared numbers that may differ by this share and still be of the same arm.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Pair:
    """OLD and NEW.

    Attributes:
        old, new: each as it was prepared.
    """

    old: Experiment
    new: Experiment

    @cached_property
    def experiment(self) -> Experiment:
        """Both: the runs of OLD first."""
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
        """(R,) for each run."""
        return np.arange(len(self.experiment.runs)) >= len(self.old.runs)

    @property
    def old_runs(self) -> range:
        """Indices of OLD's runs among all."""
        return range(len(self.old.runs))

    @property
    def new_runs(self) -> range:
        """Indices of NEW's."""
        return range(len(self.old.runs), len(self.experiment.runs))

    @property
    def worth(self) -> float:
        """[m] RMS distance by which a change must move the markers to be worth a word."""
        return max(_NOISE * self.experiment.noise_rms, _LENGTH * self.experiment.dataset.length)

    @cached_property
    def motion(self) -> tuple[float, ...]:
        """For each run how much the arm moves in it, over what it does in OLD's: RMS distance from its mean place."""
        seen = (run.compared[:, np.isfinite(run.compared).any(axis=(0, 2))] for run in self.experiment.runs)
        sizes = [float(np.sqrt(np.mean(np.nanvar(places, axis=0)))) for places in seen]
        usual = float(np.sqrt(np.mean(np.square([sizes[k] for k in self.old_runs]))))
        return tuple(float(np.clip(size / usual, *_MOTION)) for size in sizes)

    @cached_property
    def smooth(self) -> tuple[Array, ...]:
        """Of each run (T, M, A) [m] where the markers were, without gaps and with less noise."""
        return tuple(_smooth(run) for run in self.experiment.runs)

    def later(self, index: int, delays: Array) -> Array:
        """(B, M, A, C) [m] how much farther a run was than it would have been without delays (C,) [s] of its command.

        A command that comes later shifts whatever the arm did in answer, also what no model of it explains.
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
        """Of a bin [s]."""
        runs = self.experiment.runs
        total = sum(float(run.time[-1] - run.time[0]) for run in runs)
        return max(_NARROWEST, total / _ROWS)

    @cached_property
    def bins(self) -> tuple[Bins, ...]:
        """Of each run."""
        return tuple(Bins.of(run, self.width) for run in self.experiment.runs)


@dataclass(frozen=True, eq=False)
class Bins:
    """How the samples of a run are averaged.

    Attributes:
        starts: (B,) first sample of each bin.
        seen: (T, M) whether a marker was seen.
        counts: (B, M) samples in which it was.
        time: (B,) [s] since the run began.
    """

    starts: NDArray[np.intp]
    seen: NDArray[np.bool_]
    counts: Array
    time: Array

    @classmethod
    def of(cls, run: Run, width: float) -> Bins:
        """Bins of this width [s], or of one sample."""
        since = run.instants - run.time[0]
        place = np.floor(since / max(width, run.step) + 1e-6).astype(int)
        starts = np.flatnonzero(np.diff(place, prepend=-1))
        seen: NDArray[np.bool_] = np.asarray(np.isfinite(run.compared).all(axis=2))
        sizes = np.diff(starts, append=len(since))
        return cls(starts, seen, np.add.reduceat(seen.astype(float), starts), np.add.reduceat(since, starts) / sizes)

    def __call__(self, values: Array) -> Array:
        """(B, M, ...) means of values (T, M, ...) over the samples at which a marker was seen; 0 where it never was."""
        mask = self.seen.reshape(*self.seen.shape, *[1] * (values.ndim - 2))
        sums = np.add.reduceat(np.where(mask, values, 0.0), self.starts, axis=0)
        counts = self.counts.reshape(*self.counts.shape, *[1] * (values.ndim - 2))
        return np.asarray(sums / np.maximum(counts, 1.0))

    def of_all(self, values: Array) -> Array:
        """(B, ...) means of values (T, ...) over all samples."""
        sizes = np.diff(self.starts, append=len(values)).reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(np.add.reduceat(values, self.starts, axis=0) / sizes)


def _smooth(run: Run) -> Array:
    """(T, M, A) [m] moving parabolas, gaps bridged; zeros for a marker that was hardly seen.

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
    """Two recordings of one arm.

    Raises:
        IdentificationError: they are of different arms, or show different markers.
    """
    hint = "both recordings must be of one arm, declared alike but for what differs from trial to trial"
    for name in ("bending", "length", "mass", "diameter", "mount", "torsion"):
        was, is_ = getattr(old.dataset, name), getattr(new.dataset, name)
        if was != is_ if isinstance(was, str) else not isclose(was, is_, rel_tol=_SAME):
            expected = f"{was}, as in {old.dataset.name}"
            raise IdentificationError(f"{name} of {new.dataset.name}", expected=expected, received=is_, hint=hint)
    for what, told in (
        ("sections", [[str(section) for section in each.dataset.sections] for each in (old, new)]),
        ("markers", [[_placed(marker) for marker in each.markers] for each in (old, new)]),
    ):
        if told[0] != told[1]:
            expected, received = (_listed(each) or "none" for each in told)
            raise IdentificationError(f"{what} of {new.dataset.name}", expected=expected, received=received, hint=hint)
    return Pair(old, new)


def _placed(marker: Marker) -> str:
    beside = f", {marker.radius:g} m beside at {marker.angle:g} rad" if marker.radius else ""
    return f"{marker.name} at {marker.arc_length:g} m{beside}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)
