"""The error ladder (an error budget): how much of the gap each model explains, from the declared model to the best one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from hsr_pin.inference.resampling import interval, squares
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Rung:
    """One row of the ladder: a model, or a floor that no model can reach.

    Attributes:
        name: the physics that this model adds.
        effects: sorted names of the effects in the model.
        rms: RMS marker distance on held-out trials [m].
        share: share of the squared error that this row removes, of all that the ladder removes and leaves beyond noise; on the
            row "not repeatable" the share that the last model leaves above it; on the last row the share beyond noise that the
            row above it leaves. It is zero for a row that removes nothing. All shares add up to one.
        interval: (2,) 95 % interval of ``rms`` from resampled trials [m].
        floor: whether the row is a floor and not a model.
    """

    name: str
    effects: tuple[str, ...]
    rms: float
    share: float
    interval: tuple[float, float]
    floor: bool = False


def ladder(
    models: Sequence[tuple[str, tuple[str, ...], Sequence[Array]]], noise: float, seed: int, not_repeatable: float | None = None
) -> tuple[Rung, ...]:
    """Return the rows of the ladder.

    Args:
        models: name, effects and held-out residuals [m] (one (T, M, 2) per run) of each model, from the declared one to the best.
        noise: RMS distance that noise alone leaves [m].
        seed: seed of the resampling.
        not_repeatable: trial-to-trial scatter beyond noise [m]; None if no trials repeat one another. The row is omitted if the
            last model is closer than that, which is possible because each trial may have its own equilibrium.
    """
    means = [squares(heldout).mean for _, _, heldout in models]
    again = math.inf if not_repeatable is None else noise**2 + not_repeatable**2
    floors = [again, noise**2] if again < means[-1] else [noise**2]
    drops = [max(0.0, before - after) for before, after in itertools.pairwise([*means, *floors])]
    whole = sum(drops) or 1.0
    rungs = [
        Rung(name, effects, mean**0.5, drop / whole, interval(squares(heldout), seed))
        for (name, effects, heldout), mean, drop in zip(models, means, [0.0, *drops], strict=False)
    ]
    if len(floors) > 1:
        rms = again**0.5
        rungs.append(Rung("not repeatable (trial-to-trial scatter)", (), rms, drops[-2] / whole, (rms, rms), floor=True))
    return (*rungs, Rung("noise floor (share: unexplained remainder)", (), noise, drops[-1] / whole, (noise, noise), floor=True))
