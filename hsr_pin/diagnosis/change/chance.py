"""What OLD's own trials would show by chance: some of them taken for another recording, in which nothing has changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.change.fitting import Fitted, moved
from hsr_pin.diagnosis.change.frame import Before, Frame
from hsr_pin.trajectory import Array

#: Ways to take half of OLD's trials for another recording, beside each one alone.
_HALVES = 16
#: A change is made this much smaller: then it is linear.
_SMALL = 0.3


@dataclass(frozen=True, eq=False)
class Chance:
    """For each of some changes.

    Attributes:
        gains: (S, F) of the squared residuals that each of F changes takes away, in each of S ways to part OLD.
    """

    gains: Array

    @property
    def largest(self) -> float:
        """Gain that no change reaches in OLD."""
        return float(self.gains.max(initial=0.0))

    @property
    def inflation(self) -> float:
        """How much more a change seems to explain in OLD than chance alone would have it, in the mean; at least 1."""
        return max(1.0, float(self.gains.mean())) if self.gains.size else 1.0


def chance(frame: Frame, before: Before, changes: Sequence[Fitted], seed: int) -> Chance:
    """Of some fitted changes."""
    count, runs = len(frame.pair.old.runs), frame.pair.old_runs
    units = []
    for each in changes:
        start, sized = each.suspect.start, np.array(each.suspect.sizes)
        small = np.where(sized, start + _SMALL * (each.after - start), each.after)
        units.append(moved(frame, each.suspect, small[None], runs))
    generator, gains = np.random.default_rng(seed), []
    halves = [generator.permutation(count)[: count // 2].tolist() for _ in range(_HALVES if count > 3 else 0)]
    ways: list[list[int]] = [*([k] for k in range(count)), *halves]
    for chosen in ways:
        part = [np.concatenate([unit[k] * (k in chosen) for unit in units], axis=-1) for k in runs]
        columns = before.change(part)
        size, along = (columns**2).sum(axis=0), columns.T @ before.seen
        seen = size > 1e-9
        gains.append(np.where(seen, along**2 / np.where(seen, size, 1.0), 0.0))
    return Chance(np.array(gains))
