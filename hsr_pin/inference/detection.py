"""Detection limits: the size from which on a cause that was not named would have become part of the verdict.

The change of the recordings that a cause of size a would make, beyond what the free parameters of the best model can hide, adds
a^2 g to the mean square that a model without the cause leaves in a group of channels. The cause is found if this raises the log
evidence by more than the cause costs (:mod:`hsr_pin.inference.evidence`) and by the logarithm of the odds, if it is more than the
share of the gap for which the posterior keeps a simpler model, and if the gap is reported at all.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from math import expm1, inf, log, sqrt

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.evidence import variance
from hsr_pin.inference.model import Data
from hsr_pin.inference.problem import Part, Problem
from hsr_pin.inference.proposals import Proposal
from hsr_pin.trajectory import Array

#: Odds at which a cause counts as found.
_ODDS = 20.0
#: A limit beyond this exponent is not a number that anyone could use. Number of bisections for a limit.
_LARGEST, _HALVINGS = 300.0, 50
#: Number of limits in a sentence.
_LISTED = 4


@dataclass(frozen=True)
class DetectionLimit:
    """Smallest size at which a cause would have been found.

    Attributes:
        cause: name of the cause.
        kind: kind of physics.
        parameter: name of its amplitude, with that of the cause.
        size: the limit; None if the recordings cannot show the cause within its bounds.
        unit: unit of the size.
        scale: a size of practical importance, in the same unit.
        parameters: number of parameters of the cause.
    """

    cause: str
    kind: str
    parameter: str
    size: float | None
    unit: str
    scale: float
    parameters: int

    def __str__(self) -> str:
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        return f"{self.parameter} {self.size:.2g}{unit}" if self.size is not None else f"{self.parameter} at any size"


def most_visible(limits: Iterable[DetectionLimit]) -> list[DetectionLimit]:
    """Return for each kind of physics one of its simplest causes, the limits that are small for practice first."""

    def share(each: DetectionLimit) -> float:
        return (each.size or 0.0) / each.scale

    best: dict[str, DetectionLimit] = {}
    for each in sorted((each for each in limits if each.size is not None), key=lambda each: (each.parameters, share(each))):
        best.setdefault(each.kind, each)
    return sorted(best.values(), key=share)


def detection_sentence(limits: Iterable[DetectionLimit]) -> str:
    """Return what the recordings cannot exclude, for the most visible kinds of physics; empty if there are no limits."""
    listed = ", ".join(map(str, most_visible(limits)[:_LISTED]))
    return f"A cause smaller than this would not have been found: {listed}." if listed else ""


def parts_for_limits(parts: Iterable[Part], credible: Collection[str]) -> list[Part]:
    """Return the first variant of every law that can be named and that no credible model has; their limits are computed."""
    first: dict[str, Part] = {}
    for part in parts:
        if part.name not in credible and not part.flexible:
            first.setdefault(part.name, part)
    return list(first.values())


def detection_limits(
    problem: Problem,
    best: Candidate,
    parts: Iterable[Part],
    proposals: Iterable[Proposal],
    data: Data,
    calibration: Calibration,
    least: float,
) -> tuple[DetectionLimit, ...]:
    """Return the detection limit of each amplitude of the proposed causes.

    Args:
        problem: the recordings and their simulation.
        best: the most probable model.
        parts: the parts that were proposed.
        proposals: proposals for adding one of them to it.
        data: noise variance and number of coordinates of the recordings.
        calibration: constants of the model evidence.
        least: smallest a^2 g that would be reported.
    """
    left = variance(best.model.misfits, data, calibration)
    squares = np.array([1 / float(np.mean(1 / problem.floor[list(own)] ** 2)) for own in problem.groups])
    kinds, found = {part.name: part.kind for part in parts}, []
    for proposal in proposals:
        facts = {fact.name: fact for fact in proposal.hypothesis.parameters}
        added = len(facts) - len(best.fit.values)
        for name, visibility in proposal.visibility.items():
            cause = name.partition(".")[0]
            fact, added_squares = facts[name], visibility**2 * squares
            occam = 0.5 * np.log1p(calibration.samples * (added_squares / left).sum() * fact.prior_width(fact.neutral) ** 2)
            needed = 2 * (log(_ODDS) + calibration.cause + occam) / calibration.samples
            reported = sqrt(least / added_squares.mean()) if added_squares.any() else inf
            room = max(fact.upper - fact.neutral, fact.neutral - fact.lower)
            size = max(_smallest(added_squares / left, float(needed)), reported)
            found.append(DetectionLimit(cause, kinds[cause], name, size if size <= room else None, fact.unit, fact.scale, added))
    return tuple(found)


def _smallest(growth: Array, needed: float) -> float:
    """Return the size a at which sum_g ln(1 + a^2 growth_g) reaches a number; infinity if there is none that can be used."""
    if not growth.max() > 0 or needed > _LARGEST:
        return inf
    low, high = 0.0, sqrt(expm1(needed) / growth.max())  # the group that grows most reaches it alone
    for _ in range(_HALVINGS if len(growth) > 1 else 0):
        middle = (low + high) / 2
        low, high = (low, middle) if np.log1p(middle**2 * growth).sum() >= needed else (middle, high)
    return high
