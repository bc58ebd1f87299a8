"""Apparent changes within the reference recording: some of its trials are treated as another recording without any change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.change.fitting import Fitted, moved
from hsr_pin.diagnosis.change.frame import Before, Frame
from hsr_pin.trajectory import Array

#: Number of random halves of the reference recording, in addition to each single trial.
_HALVES = 16
#: Factor by which a change is reduced, so that its influence is linear.
_SMALL = 0.3


@dataclass(frozen=True, eq=False)
class Chance:
    """Gains of change hypotheses within the reference recording, where nothing has changed.

    Attributes:
        gains: (S, F) decrease of the squared residuals by each of F changes, for each of S splits of the reference recording.
    """

    gains: Array

    @property
    def largest(self) -> float:
        """Largest gain of any change within the reference recording."""
        return float(self.gains.max(initial=0.0))

    @property
    def inflation(self) -> float:
        """Mean gain within the reference recording relative to that expected by chance, at least 1: a variance inflation."""
        return max(1.0, float(self.gains.mean())) if self.gains.size else 1.0


def chance(frame: Frame, before: Before, changes: Sequence[Fitted], seed: int) -> Chance:
    """Return the gains of some fitted changes within the reference recording."""
    count, runs = len(frame.pair.old.runs), frame.pair.old_runs
    units = []
    for each in changes:
        start, sized = each.change.start, np.array(each.change.sizes)
        small = np.where(sized, start + _SMALL * (each.after - start), each.after)
        units.append(moved(frame, each.change, small[None], runs))
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
