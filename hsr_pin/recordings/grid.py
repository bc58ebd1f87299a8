"""The even grid of sampling instants that every trajectory stands on: as even as simulations demand it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.trajectory import Array, Trajectory, Trial

#: Steps that differ by less than this share are even.
EXACT = 1e-7
#: A sample this close to an instant of the grid, in steps, is the sample of that instant, moved along the line to its neighbour.
TOLERANCE = 0.01
#: Samples are missing where two are farther apart than this, in steps; closer ones may merely jitter.
GAP = 1.75
#: Times that were rounded when they were written lie within this share of their last digit around an even grid: half of it, and
#: what fitting the grid adds.
ROUNDED = 0.75


@dataclass(frozen=True, eq=False)
class Grid:
    """How to bring samples taken at uneven times onto even ones.

    Attributes:
        source: (T,) [s] the times that were recorded, less ``origin``.
        time: (G,) [s] the even times.
        step: [s] between them.
        origin: [s] what was taken off the recorded times: 0, or the first of them where they are so large (Unix time) that their
            last digits make steps uneven.
        rounding: [s] a sample this close to an instant was taken at it, its time merely rounded.
    """

    source: Array
    time: Array
    step: float
    origin: float
    rounding: float

    def positions(self, values: Array) -> Array:
        """(G, ...) of (T, ...): a straight line between neighbouring samples; NaN inside of a gap, and beside a NaN.

        A sample next to its instant is not lost: beside a gap the line is that to its other neighbour.
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
            beside = np.flatnonzero((np.abs(off[moved]) <= TOLERANCE * self.step) & np.isnan(line).any(axis=1))
            index = closest[moved[beside]]
            alone = flat[index] + off[moved[beside], None] * self._slopes(flat, index)
            line[beside] = np.where(np.isnan(line[beside]), alone, line[beside])
            placed[moved] = line
        return placed.reshape(len(placed), *values.shape[1:])

    def _slopes(self, flat: Array, index: NDArray[np.intp]) -> Array:
        """(I, C) from some samples to the next, or from the one before; 0 where neither was seen."""
        slopes = []
        for first in (np.minimum(index, len(flat) - 2), np.maximum(index - 1, 0)):
            span = (self.source[first + 1] - self.source[first])[:, None]
            slopes.append(np.where(span > GAP * self.step, np.nan, (flat[first + 1] - flat[first]) / span))
        return np.nan_to_num(np.where(np.isnan(slopes[0]), slopes[1], slopes[0]))

    def held(self, values: Array) -> Array:
        """(G, ...) of (T, ...): each value holds until the next."""
        return hold(self.source, values, self.time + max(TOLERANCE * self.step, self.rounding))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done, one sentence each; nothing where times were even but for their last digits."""
        notes = []
        steps = np.diff(self.source)
        uneven = float(np.abs(steps - self.step).max())
        said = f"steps of {steps.min():.4g} to {steps.max():.4g} s"
        if uneven > 2 * max(TOLERANCE * self.step, self.rounding) or len(self.time) != len(self.source):
            notes.append(
                f"sampling was uneven ({said}): resampled onto an even step of {self.step:.6g} s "
                f"({len(self.source)} samples became {len(self.time)}), gaps left as gaps, the input held"
            )
        elif uneven > 2 * TOLERANCE * self.step:
            notes.append(f"times are rounded ({said}): taken for an even step of {self.step:.6g} s")
        elif uneven > 2 * self.rounding:
            notes.append(f"sampling jitters ({said}): samples moved onto an even step of {self.step:.6g} s, along their motion")
        if self.origin:
            notes.append(f"times count from the first sample, at {self.origin:.6f} s")
        return tuple(notes)


def hold(source: Array, values: Array, time: Array) -> Array:
    """Values given at ``source`` times, each held until the next, at other times (before the first: the first)."""
    return np.asarray(values[np.clip(np.searchsorted(source, time, side="right") - 1, 0, len(source) - 1)])


def mean_until_next(source: Array, values: Array, time: Array) -> tuple[Array, tuple[str, ...]]:
    """(T, C) commands (R, C) that are held from their ``source`` times on, as means over each step of even times; and a note.

    What changes on a sample stays as it was. What changes between two keeps its time: the sample before it holds the mean.
    """
    step = float(time[-1] - time[0]) / (len(time) - 1)
    slack = TOLERANCE * step
    even = np.round((source - time[0]) / step) * step + time[0]
    source = np.where(np.abs(source - even) <= slack, even, source)
    first, last = (np.clip(np.searchsorted(source, at, side="right") - 1, 0, None) for at in (time + slack, time + step - slack))
    changes = np.concatenate([[0], np.cumsum((values[1:] != values[:-1]).any(axis=1))])
    mixed = changes[first] != changes[last]
    if not mixed.any():
        return values[first], ()
    passed = np.concatenate([[0.0 * values[0]], np.cumsum(values[:-1] * np.diff(source)[:, None], axis=0)])
    begin = passed[first] + values[first] * (time - source[first])[:, None]
    end = passed[last] + values[last] * (time + step - source[last])[:, None]
    note = f"the command changes within {int(mixed.sum())} steps between samples: the sample before holds its mean until the next"
    return np.where(mixed[:, None], (end - begin) / step, values[first]), (note,)


def even_grid(time: Array) -> Grid | None:
    """The even grid for increasing times; None where they are even already.

    The step is that of the recording's own clock where samples are merely missing, and the mean step where they jitter.

    Raises:
        ValueError: so uneven that the grid would be almost all gap.
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
    rounding = 2 * off if rounded else 0.0  # twice: the grid begins at the first sample, whose time is rounded too
    return Grid(source, source[0] + step * np.arange(instants), step, origin, rounding)


def fit(counts: Array, time: Array) -> tuple[float, float]:
    """The step of the line through times at counted instants, and the largest distance from it."""
    centred, elapsed = counts - counts.mean(), time - time.mean()
    step = float(centred @ elapsed / (centred @ centred))
    return step, float(np.abs(elapsed - step * centred).max())


def _counts(time: Array) -> Array:
    """(T,) the instants of a regular clock at which times lie, some of them without a sample."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    usual = float(steps[steps <= GAP * usual].mean())
    for _ in range(3):
        ratios = steps / usual
        if ratios.sum() > 10 * len(time) + 10_000:
            raise ValueError("almost all gap")
        counts = np.concatenate([[0.0], np.cumsum(np.where(ratios > GAP, np.round(ratios), 1.0))])
        usual, _ = fit(counts, time)
    return counts


def last_digit(time: Array, spacing: float) -> float:
    """The power of ten [s] that all times are multiples of; 0 where they have more digits than that."""
    for digit in (10.0**-power for power in range(1, 10)):
        if np.all(np.abs(time - np.round(time / digit) * digit) <= 4 * spacing):
            return digit
    return 0.0


def on_even_grid(trajectory: Trajectory) -> tuple[Trajectory, float]:
    """A trajectory at even times, its notes saying what was done; and what was taken off its times [s].

    Raises:
        ValueError: so uneven that the grid would be almost all gap.
    """
    grid = even_grid(trajectory.time)
    if grid is None:
        return trajectory, 0.0
    even = replace(
        trajectory,
        time=grid.time,
        positions=grid.positions(trajectory.positions),
        torque=None if trajectory.torque is None else grid.held(trajectory.torque),
        pressures=None if trajectory.pressures is None else grid.held(trajectory.pressures),
        channels=None if trajectory.channels is None else grid.held(trajectory.channels),
        joint_angles=None,
        joint_rates=None,
        notes=(*grid.notes, *trajectory.notes),
    )
    return even, grid.origin


def instants_between(trajectory: Trajectory) -> NDArray[np.bool_]:
    """(T,) rows without any marker that lie between the samples of otherwise even times: instants at which a command changes."""
    time, empty = trajectory.time, np.array(np.isnan(trajectory.positions).all(axis=(1, 2)))
    empty[[0, -1]] = False
    if not empty.any() or np.ptp(np.diff(time)) <= EXACT * np.diff(time).mean():
        return np.zeros(len(time), dtype=bool)
    beats = (time - time[0]) / np.median(np.diff(time[~empty]))
    off = np.asarray(np.abs(beats - np.round(beats)) > TOLERANCE)
    return off & empty if not (off & ~empty).any() else np.zeros(len(time), dtype=bool)


def with_commands_between(trajectory: Trajectory, instants: NDArray[np.bool_]) -> tuple[Trajectory, float]:
    """As :func:`on_even_grid` of a trajectory without these rows, whose command changes at their times nevertheless."""
    names = [name for name in ("torque", "pressures", "channels") if getattr(trajectory, name) is not None]
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
    """A trial at even times.

    Raises:
        ValueError: so uneven that the grid would be almost all gap.
    """
    trajectory, origin = on_even_grid(trial.trajectory)
    start = None if trial.t_start is None else trial.t_start - origin
    return trial if trajectory is trial.trajectory else replace(trial, trajectory=trajectory, t_start=start)
