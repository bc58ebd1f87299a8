"""Is one model better than another on held-out trials, and by how much: resampling the trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hsr_pin.trajectory import Array

_RESAMPLES = 2000
#: Fewer trials than the first are cut into at least as many pieces as the second.
_FEW, _SOME = 5, 8
#: Gains are looked at in at least so many pieces: one that shows in two trials out of six would be missing from every tenth draw
#: of whole trials.
_PIECES = 48


@dataclass(frozen=True, eq=False)
class Squares:
    """Squared marker distances of one model on held-out data, in blocks that can be drawn anew.

    Attributes:
        sums: (K,) [m^2] of each block.
        counts: (K,) markers seen in each block.
    """

    sums: Array
    counts: Array

    @property
    def mean(self) -> float:
        """[m^2] mean squared distance."""
        return float(self.sums.sum() / self.counts.sum())


def squares(heldout: Sequence[Array], blocks: int = _FEW) -> Squares:
    """Held-out residuals [m] (one (T, M, 2) per run) as blocks.

    A block is a trial; with fewer trials than ``blocks``, each is cut into pieces in time: there must be something to draw from.
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
    """(R, K) how often each block is drawn in each of R resamples."""
    generator = np.random.default_rng(seed)
    drawn = generator.multinomial(blocks, np.full(blocks, 1 / blocks), size=_RESAMPLES).astype(float)
    drawn.flags.writeable = False
    return drawn


def interval(values: Squares, seed: int) -> tuple[float, float]:
    """95 % interval [m] of the RMS distance over resampled blocks."""
    drawn = draws(len(values.sums), seed)
    means = drawn @ values.sums / (drawn @ values.counts)
    low, high = np.sqrt(np.percentile(means, (2.5, 97.5)))
    return float(low), float(high)


def gain_interval(worse: Squares, better: Squares, seed: int) -> tuple[float, float]:
    """95 % interval [m^2] of how much lower the mean squared distance of ``better`` is, on the same resampled blocks."""
    drawn = draws(len(worse.sums), seed)
    gains = drawn @ (worse.sums - better.sums) / (drawn @ worse.counts)
    low, high = np.percentile(gains, (2.5, 97.5))
    return float(low), float(high)


def certainly_better(better: Sequence[Array], worse: Sequence[Array], seed: int) -> bool:
    """Whether the interval of the gain excludes zero, and with five trials or more does so without any one of them too."""
    everything = list(range(len(worse)))
    kept = [everything, *([k for k in everything if k != one] for one in everything if len(worse) >= _FEW)]
    return all(
        gain_interval(squares([worse[k] for k in some], _PIECES), squares([better[k] for k in some], _PIECES), seed)[0] > 0
        for some in kept
    )
