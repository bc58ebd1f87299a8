"""A named physical quantity with unit, bounds and neutral value, and dataclass fields that are such quantities."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from hsr_pin.errors import InputError, quoted

#: An amplitude is expected within so many of its scales (changes of practical size) about neutral, as a standard deviation: laws
#: that a user would notice are some scales large, and few are larger than ten.
PLAUSIBLE = 5.0


@dataclass(frozen=True)
class Parameter:
    """What is known about one quantity before it is fitted.

    Attributes:
        name: as in code, reports and on the command line.
        unit: ``"rad"``, ``"Nm s/rad"``, ``"1"`` for a ratio.
        neutral: the value that leaves the nominal model as it is; for a shape parameter (a place, a width, a time
            constant of something whose amplitude is zero) the value to start from.
        lower, upper: hard bounds, included.
        scale: a change of this size is of practical size; sets finite differences and starting values.
        amplitude: True if the neutral value switches the effect off; False for a shape parameter.
        description: one line.
        resizes: power of the stiffness level by which an amplitude grows where it does not do as its law says: -1 for a law in
            proportion to Keq (its moment then stays), 1 for one that is given in absolute units (it then goes with Keq), 0 where
            neither makes sense.
        looks: at so many values, across the bounds, a first look tries a shape parameter.
        ratio_width: of a factor on a declared number, the standard deviation of its logarithm beforehand; None: it is no factor.
    """

    name: str
    unit: str
    neutral: float
    lower: float
    upper: float
    scale: float
    amplitude: bool
    description: str
    resizes: int = 0
    looks: int = 3
    ratio_width: float | None = None

    def __post_init__(self) -> None:
        if not self.lower <= self.neutral <= self.upper:
            raise ValueError(f"{self.name}: neutral {self.neutral} outside [{self.lower}, {self.upper}]")
        if not (math.isfinite(self.scale) and self.scale > 0):
            raise ValueError(f"{self.name}: scale must be positive, got {self.scale}")

    def prior_width(self, value: float) -> float:
        """Standard deviation of the value beforehand, in its unit: about the neutral value, or within the bounds.

        An amplitude is expected within :data:`PLAUSIBLE` scales of neutral, a shape parameter anywhere within its bounds (the
        standard deviation of a uniform distribution). That of a factor grows with its value.
        """
        if self.ratio_width is not None:
            return self.ratio_width * abs(value)
        within = (self.upper - self.lower) / math.sqrt(12)
        return min(PLAUSIBLE * self.scale, within) if self.amplitude else within

    def departure(self, value: float) -> float:
        """Distance of a value from what is expected beforehand, in standard deviations; 0 for a shape parameter."""
        if self.ratio_width is not None:
            return math.log(value / self.neutral) / self.ratio_width
        return (value - self.neutral) / self.prior_width(value) if self.amplitude else 0.0

    @property
    def across(self) -> list[float]:
        """Values across the bounds at which a first look tries it, evenly by ratio where they span more than a factor of five."""
        at = [(k + 0.5) / self.looks for k in range(self.looks)]
        if self.lower > 0 and self.upper / self.lower > 5:
            return [self.lower * math.pow(self.upper / self.lower, f) for f in at]
        return [self.lower + (self.upper - self.lower) * f for f in at]


def finite(name: str, value: Any, expected: str = "a finite number") -> float:
    """A number that someone gave, as a float.

    Raises:
        InputError: it is none, or too large for a float.
    """
    try:
        number = math.nan if isinstance(value, str) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(name, expected=expected, received=quoted(value))
    return number


def parameter(
    neutral: float,
    *,
    lower: float,
    upper: float,
    unit: str,
    scale: float,
    description: str,
    amplitude: bool = False,
    resizes: int = 0,
    looks: int = 3,
) -> Any:
    """A dataclass field that is a :class:`Parameter`; its default is the neutral value."""
    fact = Parameter("?", unit, neutral, lower, upper, scale, amplitude, description, resizes, looks)
    return dataclasses.field(default=neutral, metadata={"parameter": fact})


@cache
def parameters_of(owner: type) -> tuple[Parameter, ...]:
    """The parameters of a dataclass, in the order of its fields."""
    return tuple(
        dataclasses.replace(field.metadata["parameter"], name=field.name)
        for field in dataclasses.fields(owner)
        if "parameter" in field.metadata
    )
