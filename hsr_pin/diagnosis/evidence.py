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


def structure(heldout: Sequence[Array]) -> float:
    """[m^2] mean square of the part of the residuals that lasts from one sample to the next.

    The covariance of neighbouring samples: white marker noise drops out of it by itself, whatever its size, so that it is known
    ten times better than the mean square beyond an estimated noise floor. What swings so fast that a neighbour tells nothing of
    it, or the opposite, shows two or three samples on: whatever its frequency, seven tenths of it do in one of the three.
    """
    return max(abs(_covariance(heldout, lag)) for lag in (1, 2, 3))


def _covariance(heldout: Sequence[Array], lag: int) -> float:
    """[m^2] of samples so far apart, where those between them were seen too."""
    total, count = 0.0, 0
    for residual in heldout:
        product = (residual[lag:] * residual[:-lag]).sum(axis=-1)
        there = np.asarray(np.isfinite(residual).all(axis=-1))
        seen = np.logical_and.reduce([there[k : len(there) - lag + k] for k in range(lag + 1)])
        total, count = total + float(product[seen].sum()), count + int(seen.sum())
    return total / count if count else 0.0


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


def frequency_of_gain(better: Sequence[Array], worse: Sequence[Array], seed: int) -> float:
    """In what share of resampled pieces of the trials one model's mean squared distance is lower than another's."""
    one, other = squares(better, _PIECES), squares(worse, _PIECES)
    drawn = draws(len(other.sums), seed)
    return float(np.mean(drawn @ (other.sums - one.sums) > 0))
