"""How strong must an effect be to move the markers by so many millimetres?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.errors import InputError

from .arm import Array
from .chain import ChainPlant
from .laws.law import Law
from .nuisance import Nuisance, noise_floor
from .plant import Plant
from .program import Program

#: Gaps of the named sizes, in noise floors.
SIZES: dict[str, float] = {"barely": 2.0, "medium": 6.0, "large": 15.0}
#: Coarse enough to be quick, fine enough for a gap to a few per cent.
SCOUT = ChainPlant(elements=12, step=5e-4)
TOLERANCE = 0.03


@dataclass(frozen=True)
class Scaled:
    """A law at the strength asked for.

    Attributes:
        law: the law. gap: RMS marker distance that it makes [mm].
        reached: whether that is the distance asked for; if not, the law is as strong as it may be.
    """

    law: Law
    gap: float
    reached: bool


def target(size: str, noise: float) -> float:
    """Gap [mm] of a size of `SIZES`, for markers with this noise per axis [m]."""
    if size not in SIZES:
        raise InputError("size", expected=" or ".join(SIZES), received=size)
    return 1e3 * SIZES[size] * noise_floor(noise)


def gap(a: Sequence[Array], b: Sequence[Array], still: int = 1) -> float:
    """RMS distance [mm] of markers (T, M, 3) [m] over all trials; the first `still` markers do not move."""
    return 1e3 * float(np.sqrt(np.mean(_squares(a, b, still))))


def distinct(
    law: Law, program: Program, nuisance: Nuisance | None = None, plant: Plant = SCOUT
) -> tuple[float, float]:
    """Gap of a law [mm], and what is left of it after the best change of K and C [mm].

    The change is found by linear least squares over differences of 2 % in K and C: an estimate.
    """
    nuisance = nuisance or Nuisance()

    def stacked(effects: tuple[Law, ...], k: float, c: float) -> Array:
        points = plant.watch(program, effects, replace(nuisance, k=nuisance.k * k, c=nuisance.c * c))
        return np.concatenate([p[:, 1:].ravel() for p in points])

    nominal = stacked((), 1, 1)
    change = stacked((law,), 1, 1) - nominal
    slopes = np.stack([stacked((), 1.02, 1) - nominal, stacked((), 1, 1.02) - nominal], axis=1)
    left = change - slopes @ np.linalg.lstsq(slopes, change, rcond=None)[0]
    points = change.size / 3
    return tuple(1e3 * float(np.sqrt(v @ v / points)) for v in (change, left))  # type: ignore[return-value]


def scale_to_gap(
    law: Law,
    program: Program,
    millimetres: float,
    nuisance: Nuisance | None = None,
    plant: Plant = SCOUT,
) -> Scaled:
    """Scale a law so that the markers move by this much (RMS, same K and C) [mm].

    Secant steps on the logarithms, of at most a factor 8; ends within 3 % or at the law's limit.
    """
    reference = plant.watch(program, (), nuisance)

    def measure(candidate: Law) -> float:
        return gap(plant.watch(program, (candidate,), nuisance), reference)

    best = Scaled(law, measure(law), False)
    previous, power = best, 1.0
    for _ in range(10):
        if abs(best.gap / millimetres - 1) < TOLERANCE:
            return replace(best, reached=True)
        wanted = (millimetres / max(best.gap, 1e-6)) ** (1 / power)
        stronger = best.law.scaled(float(np.clip(wanted, 1 / 8, 8.0)))
        if stronger == best.law:
            return best
        previous, best = best, Scaled(stronger, measure(stronger), False)
        power = _power(previous, best)
    return replace(best, reached=abs(best.gap / millimetres - 1) < 5 * TOLERANCE)


def _power(a: Scaled, b: Scaled) -> float:
    """Exponent p of gap ~ strength^p between two trials, kept within reason."""
    field = type(a.law).strength
    ratio = abs(getattr(b.law, field) / getattr(a.law, field))
    if min(a.gap, b.gap) <= 0 or abs(np.log(ratio)) < 1e-9:
        return 1.0
    return float(np.clip(np.log(b.gap / a.gap) / np.log(ratio), 0.3, 6.0))


def _squares(a: Sequence[Array], b: Sequence[Array], still: int) -> Array:
    moved = [(p[:, still:] - q[:, still:]) for p, q in zip(a, b, strict=True)]
    return np.concatenate([np.sum(d**2, axis=-1).ravel() for d in moved])
