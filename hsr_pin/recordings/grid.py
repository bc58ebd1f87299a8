"""The even grid of sampling instants that every trajectory stands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array

#: A sample this close to an instant of the grid, in steps, is the sample of that instant.
TOLERANCE = 0.01
#: Samples are missing where two are farther apart than this, in steps; closer ones may merely jitter.
GAP = 1.75


@dataclass(frozen=True, eq=False)
class Grid:
    """How to bring samples taken at uneven times onto even ones.

    Attributes:
        source: (T,) [s] the times that were recorded.
        time: (G,) [s] the even times.
        step: [s] between them.
    """

    source: Array
    time: Array
    step: float

    def positions(self, values: Array) -> Array:
        """(G, ...) of (T, ...): a straight line between neighbouring samples; NaN inside of a gap, and beside a NaN."""
        after = np.clip(np.searchsorted(self.source, self.time), 1, len(self.source) - 1)
        before = after - 1
        span = self.source[after] - self.source[before]
        share = (self.time - self.source[before]) / span
        near = TOLERANCE * self.step
        on_before = np.abs(self.time - self.source[before]) <= near
        on_after = np.abs(self.time - self.source[after]) <= near
        share[on_before], share[on_after] = 0.0, 1.0
        share[(span > GAP * self.step) & ~on_before & ~on_after] = np.nan
        share = share.reshape(-1, *[1] * (values.ndim - 1))
        between = (1 - share) * values[before] + share * values[after]
        return np.where(share == 0, values[before], np.where(share == 1, values[after], between))

    def held(self, values: Array) -> Array:
        """(G, ...) of (T, ...): each value holds until the next."""
        return hold(self.source, values, self.time + TOLERANCE * self.step)

    @property
    def note(self) -> str:
        """One sentence on what was done."""
        steps = np.diff(self.source)
        return (
            f"sampling was uneven (steps of {steps.min():.4g} to {steps.max():.4g} s): resampled onto an even step of "
            f"{self.step:.6g} s ({len(self.source)} samples became {len(self.time)}), gaps left as gaps, the input held"
        )


def hold(source: Array, values: Array, time: Array) -> Array:
    """Values given at ``source`` times, each held until the next, at other times (before the first: the first)."""
    return np.asarray(values[np.clip(np.searchsorted(source, time, side="right") - 1, 0, len(source) - 1)])


def even_grid(time: Array) -> Grid | None:
    """The even grid for increasing times; None where they are even already.

    The step is that of the recording's own clock where samples are merely missing, and the mean step where they jitter.

    Raises:
        ValueError: so uneven that the grid would be almost all gap.
    """
    step = (time[-1] - time[0]) / (len(time) - 1)
    if np.all(np.abs(time - np.linspace(time[0], time[-1], len(time))) <= TOLERANCE * step):
        return None
    usual = np.median(np.diff(time))
    ratios = np.diff(time) / usual
    if ratios.sum() > 10 * len(time) + 10_000:
        raise ValueError("almost all gap")
    counts = np.concatenate([[0.0], np.cumsum(np.where(ratios > GAP, np.round(ratios), 1.0))])
    elapsed = time - time[0]
    step = float(counts @ elapsed / (counts @ counts))
    instants = int(np.floor(elapsed[-1] / step + TOLERANCE)) + 1
    return Grid(time, time[0] + step * np.arange(instants), step)
