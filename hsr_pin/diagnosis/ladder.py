"""How far: the gap, rung by rung."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hsr_pin.diagnosis.evidence import interval, squares
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Rung:
    """One model on the ladder, or the noise floor at its foot.

    Attributes:
        name: what was mended here.
        effects: in the model, sorted.
        rms: [m] RMS marker distance on held-out trials.
        share: of the squared gap between the declared model and the noise floor, what this rung takes away; on the last line,
            what is left unexplained. All shares add up to one (the first rung has none).
        interval: (2,) [m] 95 % interval of ``rms`` from resampled trials.
    """

    name: str
    effects: tuple[str, ...]
    rms: float
    share: float
    interval: tuple[float, float]


def ladder(models: Sequence[tuple[str, tuple[str, ...], Sequence[Array]]], noise: float, seed: int) -> tuple[Rung, ...]:
    """The ladder.

    Args:
        models: name, effects and held-out residuals [m] (one (T, M, 3) per run), from the declared model down.
        noise: [m] RMS distance that noise alone leaves.
        seed: of the resampling.
    """
    means = [squares(heldout).mean for _, _, heldout in models]
    whole = means[0] - noise**2
    rungs = []
    for k, (name, effects, heldout) in enumerate(models):
        share = 0.0 if k == 0 or whole <= 0 else (means[k - 1] - means[k]) / whole
        rungs.append(Rung(name, effects, means[k] ** 0.5, share, interval(squares(heldout), seed)))
    rest = 0.0 if whole <= 0 else (means[-1] - noise**2) / whole
    return (*rungs, Rung("noise floor (unexplained rest above it)", (), noise, rest, (noise, noise)))
