"""Resampling of unevenly sampled recordings onto the even time grid that simulations require."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.trajectory import INPUTS, Array, Trajectory, Trial

#: Largest relative difference between the steps of an even grid.
EXACT = 1e-7
#: A sample this close to an instant of the grid [steps] is assigned to that instant and moved along the line to its neighbour.
TOLERANCE = 0.01
#: Distance of two samples [steps] from which samples are missing between them; smaller distances may be jitter.
GAP = 1.75
#: Largest distance of rounded times from an even grid, as a share of their last digit: a half, and a margin for the fit of the
#: grid.
ROUNDED = 0.75


@dataclass(frozen=True, eq=False)
class Grid:
    """Mapping of samples at uneven times onto an even time grid.

    Attributes:
        source: (T,) recorded times minus ``origin`` [s].
        time: (G,) even times [s].
        step: step of the even times [s].
        origin: value subtracted from the recorded times [s]: 0, or the first time where the times are so large (Unix time) that
            rounding makes steps uneven.
        rounding: a sample this close to an instant [s] was taken at that instant, and its time was rounded.
    """

    source: Array
    time: Array
    step: float
    origin: float
    rounding: float

    def positions(self, values: Array) -> Array:
        """Return values (G, ...) of (T, ...), interpolated linearly; NaN inside a gap and next to a NaN.

        A sample at the edge of a gap is moved to its instant along the line to its other neighbour.
        """
        source, flat = self.source, values.reshape(len(values), -1)
        after = np.clip(np.searchsorted(source, self.time), 1, len(source) - 1)
        before = after - 1
        span = source[after] - source[before]
        share = (self.time - source[before]) / span
        closest = np.where(share < 0.5, before, after)
        off = self.time - source[closest]
        placed = flat[closest]
        moved = np.flatnonzero(np.abs(off) > self.rounding)
        if len(moved):
            part = share[moved, None]
            line = (1 - part) * flat[before[moved]] + part * flat[after[moved]]
            line[(span[moved] > GAP * self.step) | (part[:, 0] > 1)] = np.nan
            edge = np.flatnonzero((np.abs(off[moved]) <= TOLERANCE * self.step) & np.isnan(line).any(axis=1))
            index = closest[moved[edge]]
            alone = flat[index] + off[moved[edge], None] * self._slopes(flat, index)
            line[edge] = np.where(np.isnan(line[edge]), alone, line[edge])
            placed[moved] = line
        return placed.reshape(len(placed), *values.shape[1:])

    def _slopes(self, flat: Array, index: NDArray[np.intp]) -> Array:
        """Return the slopes (I, C) from samples to the next or, if missing, from the previous sample; 0 if both are missing."""
        slopes = []
        for first in (np.minimum(index, len(flat) - 2), np.maximum(index - 1, 0)):
            span = (self.source[first + 1] - self.source[first])[:, None]
            slopes.append(np.where(span > GAP * self.step, np.nan, (flat[first + 1] - flat[first]) / span))
        return np.nan_to_num(np.where(np.isnan(slopes[0]), slopes[1], slopes[0]))

    def held(self, values: Array) -> Array:
        """Return values (G, ...) of (T, ...), each held until the next one."""
        return hold(self.source, values, self.time + max(TOLERANCE * self.step, self.rounding))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the resampling, one sentence each; none where only the rounding of the times was uneven."""
        notes = []
        steps = np.diff(self.source)
        uneven = float(np.abs(steps - self.step).max())
        steps_text = f"steps of {steps.min():.4g} to {steps.max():.4g} s"
        if uneven > 2 * max(TOLERANCE * self.step, self.rounding) or len(self.time) != len(self.source):
            notes.append(
                f"uneven sampling ({steps_text}) was resampled to an even step of {self.step:.6g} s "
                f"({len(self.source)} samples became {len(self.time)}); gaps remain gaps, and the input is held"
            )
        elif uneven > 2 * TOLERANCE * self.step:
            notes.append(f"rounded times ({steps_text}) were replaced by an even step of {self.step:.6g} s")
        elif uneven > 2 * self.rounding:
            notes.append(f"jittering samples ({steps_text}) were interpolated onto an even step of {self.step:.6g} s")
        if self.origin:
            notes.append(f"times are counted from the first sample, which was at {self.origin:.6f} s")
        return tuple(notes)


def hold(source: Array, values: Array, time: Array) -> Array:
    """Return values given at ``source`` times, each held until the next, at other times (the first value before the first)."""
    return np.asarray(values[np.clip(np.searchsorted(source, time, side="right") - 1, 0, len(source) - 1)])


def mean_until_next(source: Array, values: Array, time: Array) -> tuple[Array, tuple[str, ...]]:
    """Return held commands (R, C) as means (T, C) over the steps of even times, and notes.

    A change at a sample stays as it was. For a change between two samples, the sample before it takes the mean over the step.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    slack = TOLERANCE * step
    even = np.round((source - time[0]) / step) * step + time[0]
    source = np.where(np.abs(source - even) <= slack, even, source)
    first, last = (np.clip(np.searchsorted(source, at, side="right") - 1, 0, None) for at in (time + slack, time + step - slack))
    known = np.nan_to_num(values)  # a column of NaN does not change
    changes = np.cumsum(np.concatenate([np.zeros_like(known[:1]), known[1:] != known[:-1]]), axis=0)
    mixed = changes[first] != changes[last]
    if not mixed.any():
        return values[first], ()
    passed = np.concatenate([[0.0 * values[0]], np.cumsum(values[:-1] * np.diff(source)[:, None], axis=0)])
    begin = passed[first] + values[first] * (time - source[first])[:, None]
    end = passed[last] + values[last] * (time + step - source[last])[:, None]
    count = int(mixed.any(axis=1).sum())
    note = f"the command changes between samples in {count} steps; the sample before takes the mean over its step"
    return np.where(mixed, (end - begin) / step, values[first]), (note,)


def even_grid(time: Array) -> Grid | None:
    """Return the even grid for increasing times; None if the times are even already.

    If samples are missing, the step is that of the recording's own clock; if samples jitter, it is the mean step.

    Raises:
        ValueError: the times are so uneven that almost all of the grid would be gaps.
    """
    steps = np.diff(time)
    if np.ptp(steps) <= EXACT * steps.mean():
        return None
    spacing = float(np.spacing(np.abs(time).max()))
    origin = float(time[0]) if 4 * spacing > EXACT * steps.mean() else 0.0
    source = time - origin
    digit = max(last_digit(time, spacing), 4 * spacing / ROUNDED)
    counts = np.arange(len(time), dtype=float)
    step, off = fit(counts, source)
    if off > max(TOLERANCE * step, ROUNDED * digit):
        counts = _counts(source)
        step, off = fit(counts, source)
    rounded = off <= ROUNDED * digit and 4 * off < step
    if rounded or off <= TOLERANCE * step:
        instants = int(counts[-1]) + 1
    else:
        step = float(counts @ (source - source[0]) / (counts @ counts))
        instants = int(np.floor((source[-1] - source[0]) / step + TOLERANCE)) + 1
    rounding = 2 * off if rounded else 0.0  # twice, as the first time, at which the grid begins, is rounded too
    return Grid(source, source[0] + step * np.arange(instants), step, origin, rounding)


def fit(counts: Array, time: Array) -> tuple[float, float]:
    """Return the step [s] of a line fitted to the times of counted instants, and the largest distance [s] from that line."""
    centred, elapsed = counts - counts.mean(), time - time.mean()
    step = float(centred @ elapsed / (centred @ centred))
    return step, float(np.abs(elapsed - step * centred).max())


def _counts(time: Array) -> Array:
    """Return the counts (T,) of a regular clock at the given times; counts without a sample are skipped."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    usual = float(steps[steps <= GAP * usual].mean())
    for _ in range(3):
        ratios = steps / usual
        if ratios.sum() > 10 * len(time) + 10_000:
            raise ValueError("almost all of the even grid would be gaps")
        counts = np.concatenate([[0.0], np.cumsum(np.where(ratios > GAP, np.round(ratios), 1.0))])
        usual, _ = fit(counts, time)
    return counts


def last_digit(time: Array, spacing: float) -> float:
    """Return the largest power of ten [s] of which all times are multiples within rounding ``spacing`` [s]; 0 if none."""
    for digit in (10.0**-power for power in range(1, 10)):
        if np.all(np.abs(time - np.round(time / digit) * digit) <= 4 * spacing):
            return digit
    return 0.0


def on_even_grid(trajectory: Trajectory) -> tuple[Trajectory, float]:
    """Return a trajectory at even times, with notes on the resampling, and the time subtracted from its times [s].

    Raises:
        ValueError: the times are so uneven that almost all of the grid would be gaps.
    """
    grid = even_grid(trajectory.time)
    if grid is None:
        return trajectory, 0.0
    given: dict[str, Any] = {name: grid.held(values) for name in INPUTS if (values := getattr(trajectory, name)) is not None}
    even = replace(
        trajectory,
        time=grid.time,
        positions=grid.positions(trajectory.positions),
        joint_angles=None,
        joint_rates=None,
        notes=(*grid.notes, *trajectory.notes),
        **given,
    )
    return even, grid.origin


def instants_between(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Return a mask (T,) of rows without markers between otherwise even samples: the instants at which a command changes."""
    time, empty = trajectory.time, np.array(np.isnan(trajectory.positions).all(axis=(1, 2)))
    empty[[0, -1]] = False
    if not empty.any() or np.ptp(np.diff(time)) <= EXACT * np.diff(time).mean():
        return np.zeros(len(time), dtype=bool)
    beats = (time - time[0]) / np.median(np.diff(time[~empty]))
    off = np.asarray(np.abs(beats - np.round(beats)) > TOLERANCE)
    return off & empty if not (off & ~empty).any() else np.zeros(len(time), dtype=bool)


def with_commands_between(trajectory: Trajectory, instants: NDArray[np.bool_]) -> tuple[Trajectory, float]:
    """Return :func:`on_even_grid` of a trajectory without some rows, while keeping the command changes at their times."""
    names = [name for name in INPUTS if getattr(trajectory, name) is not None]
    kept: dict[str, Any] = {name: getattr(trajectory, name)[~instants] for name in ("time", "positions", *names)}
    even, origin = on_even_grid(replace(trajectory, **kept))
    notes: tuple[str, ...] = ()
    for name in names:
        values = getattr(trajectory, name)
        rows, notes = mean_until_next(trajectory.time - origin, values.reshape(len(values), -1), even.time)
        given: dict[str, Any] = {name: rows.reshape(-1, *values.shape[1:])}
        even = replace(even, **given)
    return replace(even, notes=(*even.notes, *notes)), origin


def evened(trial: Trial) -> Trial:
    """Return a trial at even times.

    Raises:
        ValueError: the times are so uneven that almost all of the grid would be gaps.
    """
    trajectory, origin = on_even_grid(trial.trajectory)
    start = None if trial.t_start is None else trial.t_start - origin
    return trial if trajectory is trial.trajectory else replace(trial, trajectory=trajectory, t_start=start)
