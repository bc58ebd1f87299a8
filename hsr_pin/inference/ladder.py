"""How far: the gap, rung by rung."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from hsr_pin.inference.resampling import interval, squares
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Rung:
    """One model on the ladder, or the noise floor at its foot.

    Attributes:
        name: what was mended here.
        effects: in the model, sorted.
        rms: [m] RMS marker distance on held-out trials.
        share: of all that the ladder takes away and leaves beyond noise, in squares, what this rung takes away; on the row "not
            repeatable" what the last model leaves above it; on the last line, what is left beyond noise by the row above it. A
            rung that takes nothing away has no share. All shares add up to one.
        interval: (2,) [m] 95 % interval of ``rms`` from resampled trials.
        floor: whether this is no model, but what no model gets below.
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
    """The ladder.

    Args:
        models: name, effects and held-out residuals [m] (one (T, M, 2) per run), from the declared model down.
        noise: [m] RMS distance that noise alone leaves.
        seed: of the resampling.
        not_repeatable: [m] how far the arm is from itself, beyond noise; None where no trials repeat one another. No floor, and
            left out, where a model to which trials may differ in where they rest is nearer than that.
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
        rungs.append(Rung("not repeatable; asked of no model", (), rms, drops[-2] / whole, (rms, rms), floor=True))
    return (*rungs, Rung("noise floor (unexplained rest above it)", (), noise, drops[-1] / whole, (noise, noise), floor=True))
