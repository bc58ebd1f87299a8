"""Confidence intervals of held-out errors by resampling the trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hsr_pin.trajectory import Array

_RESAMPLES = 2000
#: If there are fewer trials than the first number, they are divided into at least as many blocks as the second.
_FEW, _SOME = 5, 8
#: Least number of blocks in a comparison of two models. With whole trials as blocks, a gain that is present in two of six trials
#: would be missing from every tenth resample.
_PIECES = 48


@dataclass(frozen=True, eq=False)
class Squares:
    """Squared marker distances of one model on held-out data, in blocks for resampling.

    Attributes:
        sums: (K,) sum of squared distances in each block [m^2].
        counts: (K,) number of marker positions in each block.
    """

    sums: Array
    counts: Array

    @property
    def mean(self) -> float:
        """Mean squared distance [m^2]."""
        return float(self.sums.sum() / self.counts.sum())


def squares(heldout: Sequence[Array], blocks: int = _FEW) -> Squares:
    """Return the squared distances of held-out residuals [m] (one (T, M, 2) per run) in blocks.

    A block is a trial. If there are fewer trials than ``blocks``, each trial is divided in time, so that there are enough blocks
    to resample.
    """
    pieces = 1 if len(heldout) >= blocks else -(-max(blocks, _SOME) // len(heldout))
    sums, counts = [], []
    for residual in heldout:
        for piece in np.array_split(residual, pieces):
            square = (piece**2).sum(axis=-1)
            seen = np.isfinite(square)
            if seen.any():
                sums.append(float(square[seen].sum()))
                counts.append(float(seen.sum()))
    return Squares(np.array(sums), np.array(counts))


@lru_cache(maxsize=32)
def draws(blocks: int, seed: int) -> Array:
    """Return how often each block is drawn in each of R resamples, (R, K)."""
    generator = np.random.default_rng(seed)
    drawn = generator.multinomial(blocks, np.full(blocks, 1 / blocks), size=_RESAMPLES).astype(float)
    drawn.flags.writeable = False
    return drawn


def interval(values: Squares, seed: int) -> tuple[float, float]:
    """Return the 95 % interval of the RMS distance over resampled blocks [m]."""
    drawn = draws(len(values.sums), seed)
    means = drawn @ values.sums / (drawn @ values.counts)
    low, high = np.sqrt(np.percentile(means, (2.5, 97.5)))
    return float(low), float(high)


def gain_interval(worse: Squares, better: Squares, seed: int) -> tuple[float, float]:
    """Return the 95 % interval of the decrease of the mean squared distance from ``worse`` to ``better`` [m^2]."""
    drawn = draws(len(worse.sums), seed)
    gains = drawn @ (worse.sums - better.sums) / (drawn @ worse.counts)
    low, high = np.percentile(gains, (2.5, 97.5))
    return float(low), float(high)


def significantly_better(better: Sequence[Array], worse: Sequence[Array], seed: int) -> bool:
    """Return whether the interval of the gain excludes zero, and with five or more trials also without any one of them."""
    everything = list(range(len(worse)))
    kept = [everything, *([k for k in everything if k != one] for one in everything if len(worse) >= _FEW)]
    return all(
        gain_interval(squares([worse[k] for k in some], _PIECES), squares([better[k] for k in some], _PIECES), seed)[0] > 0
        for some in kept
    )
