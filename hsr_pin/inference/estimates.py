"""Parameter estimates of a fit, and the ranking of fitted models."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.uncertainty import uncertainty


@dataclass(frozen=True)
class Estimate:
    """Estimate of one parameter of a fitted model.

    Attributes:
        name: "keq_scale", "damping_scale", "effect.parameter".
        unit: unit of the value; "1" for a ratio.
        value: the best estimate.
        interval: 95 % interval within the parameter's bounds.
        description: one line about the parameter.
        on_bound: whether the fit ended on a bound, so that the value is only a lower or upper limit.
    """

    name: str
    unit: str
    value: float
    interval: tuple[float, float]
    description: str
    on_bound: bool

    @property
    def rounded(self) -> tuple[str, str, str]:
        """Value and ends of the interval as texts, rounded to two digits of half the interval's width."""
        numbers = (self.value, *self.interval)
        half = (self.interval[1] - self.interval[0]) / 2
        if not 1e-6 < half < 1e6:
            return (number(numbers[0]), number(numbers[1]), number(numbers[2]))
        places = max(0, 1 - math.floor(math.log10(half)))
        value, low, high = (f"{each:.{places}f}" for each in numbers)
        return value, low, high

    def __str__(self) -> str:
        value, low, high = self.rounded
        return f"{self.name} {value}{'' if self.unit == '1' else f' {self.unit}'} [{low}, {high}]"


def estimates(fit: Fit) -> tuple[Estimate, ...]:
    """Return all free parameters of a fit: those of the nominal model first, then those of each cause."""
    if not len(fit.values):
        return ()
    intervals, on_bound = uncertainty(fit).interval, fit.on_bound()
    return tuple(
        Estimate(fact.name, fact.unit, float(value), (float(low), float(high)), fact.description, fact.name in on_bound)
        for fact, value, (low, high) in zip(fit.hypothesis.parameters, fit.values, intervals, strict=True)
    )


def number(value: float) -> str:
    """Return a number with three significant digits as text; a question mark for NaN."""
    if math.isnan(value):
        return "?"
    return "0" if value == 0 else f"{value:#.3g}".rstrip(".")


def ranked(tried: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the best variant of each set of causes, the smallest error on held-out trials first."""
    best: dict[tuple[str, ...], Candidate] = {}
    for candidate in sorted(tried, key=lambda candidate: (candidate.heldout_square, candidate.names)):
        best.setdefault(candidate.names, candidate)
    return tuple(best.values())
