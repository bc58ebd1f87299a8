"""Small effects of a messy arm: none is reportable alone, and together they move the markers about as much as the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE, draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.scaling import GapSimulator, scale_to_gap
from hsr_pin.errors import SimulationFailure

#: Range of the number of small effects, and of their total gap after refitting stiffness and damping [noise floors].
MIN_COUNT, MAX_COUNT = 4, 8
MIN_TOGETHER, MAX_TOGETHER = 0.3, 1.2
#: Largest refitted gap of a single small effect [noise floors].
MAX_ALONE = 0.5
#: Refitted gap from which a small effect may be named without a mistake [noise floors].
NOTICEABLE = 0.3
#: Share of the small effects that are from the catalogue; the others are from outside.
CATALOGUE_SHARE = 0.7
#: Effects that cannot be scaled to a small gap.
UNSCALABLE = ("wall",)


@dataclass(frozen=True)
class Background:
    """Small effects of one case.

    Attributes:
        laws: four to eight laws.
        alone: refitted marker gap of each law alone [noise floors].
        together: refitted marker gap of all laws together [noise floors].
    """

    laws: tuple[Law, ...]
    alone: tuple[float, ...]
    together: float

    @property
    def noticeable(self) -> tuple[str, ...]:
        """Names of the small effects that are large enough to be named without a mistake."""
        return tuple(law.name for law, alone in zip(self.laws, self.alone, strict=True) if alone >= NOTICEABLE)


def background(rng: np.random.Generator, without: Sequence[str], gap_simulator: GapSimulator, floor: float) -> Background:
    """Draw small effects other than `without`, and scale them until their total gap is about the drawn one.

    Args:
        rng: random numbers for names, strengths and the total gap.
        without: names of effects that must not be among them.
        gap_simulator: simulator of the arm without the small effects.
        floor: noise floor [mm].
    """
    count, together = int(rng.integers(MIN_COUNT, MAX_COUNT + 1)), float(rng.uniform(MIN_TOGETHER, MAX_TOGETHER))
    shares = rng.uniform(0.4, 1.0, count)
    wanted = np.minimum(together * shares / np.linalg.norm(shares), 0.7 * MAX_ALONE)
    laws: list[Law] = []
    alone: list[float] = []
    for name in _names(rng, without):
        try:
            law = draw(name, rng)
            found = scale_to_gap(law, floor * wanted[len(laws)], gap_simulator, refit=True, tolerance=0.4, steps=5)
        except SimulationFailure:
            continue
        if 0 < found.gap <= MAX_ALONE * floor:
            laws.append(found.law)
            alone.append(found.gap / floor)
        if len(laws) == count:
            break
    return _balanced(laws, np.array(alone), together, gap_simulator, floor)


def _names(rng: np.random.Generator, without: Sequence[str]) -> list[str]:
    """Return the names of laws in the order in which they are tried."""
    inside, outside = (
        [str(name) for name in rng.permutation([name for name in names if name not in (*without, *UNSCALABLE)])]
        for names in (list(CATALOGUE), list(OUTSIDE))
    )
    found = []
    while inside and outside:
        found.append((inside if rng.random() < CATALOGUE_SHARE else outside).pop())
    return [*found, *inside]


def _balanced(laws: Sequence[Law], alone: np.ndarray, together: float, gap_simulator: GapSimulator, floor: float) -> Background:
    """Return all laws, scaled by one factor until their total refitted gap is about the one asked for."""
    for _ in range(3):
        gap = gap_simulator.refitted_gap(*laws) / floor
        factor = float(np.clip(together / gap, 0.2, MAX_ALONE / alone.max()))
        if abs(factor - 1) < 0.1:
            break
        laws, alone = [law.scaled(factor) for law in laws], alone * factor
        gap = gap_simulator.refitted_gap(*laws) / floor
        if MIN_TOGETHER <= gap <= MAX_TOGETHER:
            break
    return Background(tuple(laws), tuple(float(each) for each in alone), gap)
