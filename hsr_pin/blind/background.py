"""The small effects of a messy arm: none alone worth a name, together about as much as the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE, draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.scaling import Yardstick, scale_to_gap
from hsr_pin.errors import SimulationFailure

#: How many there are, and what they leave together once stiffness and damping are refitted [noise floors].
FEWEST, MOST = 4, 8
LEAST, GREATEST = 0.3, 1.2
#: What any of them leaves alone, at most [noise floors].
ALONE = 0.5
#: What one leaves that may be noticed for what it is [noise floors]: to name it is no mistake.
NOTICEABLE = 0.3
#: Share of them that is from the catalogue; the others are from outside.
CATALOGUED = 0.7
#: A wall is there or is not: it cannot be faint.
NEVER_FAINT = ("wall",)


@dataclass(frozen=True)
class Background:
    """Small effects.

    Attributes:
        laws: four to eight. alone: what each leaves [noise floors]. together: what all leave [noise floors].
    """

    laws: tuple[Law, ...]
    alone: tuple[float, ...]
    together: float

    @property
    def noticeable(self) -> tuple[str, ...]:
        """Names of those that may be noticed; to name another would be luck."""
        return tuple(law.name for law, alone in zip(self.laws, self.alone, strict=True) if alone >= NOTICEABLE)


def background(rng: np.random.Generator, without: Sequence[str], yardstick: Yardstick, floor: float) -> Background:
    """Draw small effects other than `without`, and weaken them until together they leave what was drawn.

    Args:
        rng: of names, strengths and what they leave.
        without: names that are not to be among them.
        yardstick: of the arm without them.
        floor: noise floor [mm].
    """
    count, together = int(rng.integers(FEWEST, MOST + 1)), float(rng.uniform(LEAST, GREATEST))
    shares = rng.uniform(0.4, 1.0, count)
    wanted = np.minimum(together * shares / np.linalg.norm(shares), 0.7 * ALONE)
    laws: list[Law] = []
    alone: list[float] = []
    for name in _names(rng, without):
        try:
            law = draw(name, rng)
            found = scale_to_gap(law, floor * wanted[len(laws)], yardstick, refit=True, tolerance=0.4, steps=5)
        except SimulationFailure:
            continue
        if 0 < found.gap <= ALONE * floor:
            laws.append(found.law)
            alone.append(found.gap / floor)
        if len(laws) == count:
            break
    return _balanced(laws, np.array(alone), together, yardstick, floor)


def _names(rng: np.random.Generator, without: Sequence[str]) -> list[str]:
    """Names in the order in which they are tried."""
    inside, outside = (
        [str(name) for name in rng.permutation([name for name in names if name not in (*without, *NEVER_FAINT)])]
        for names in (list(CATALOGUE), list(OUTSIDE))
    )
    found = []
    while inside and outside:
        found.append((inside if rng.random() < CATALOGUED else outside).pop())
    return [*found, *inside]


def _balanced(laws: Sequence[Law], alone: np.ndarray, together: float, yardstick: Yardstick, floor: float) -> Background:
    """All of them made weaker or stronger by one factor, until what they leave together is about what was asked for."""
    for _ in range(3):
        gap = yardstick.refitted_gap(*laws) / floor
        factor = float(np.clip(together / gap, 0.2, ALONE / alone.max()))
        if abs(factor - 1) < 0.1:
            break
        laws, alone = [law.scaled(factor) for law in laws], alone * factor
        gap = yardstick.refitted_gap(*laws) / floor
        if LEAST <= gap <= GREATEST:
            break
    return Background(tuple(laws), tuple(float(each) for each in alone), gap)
