"""Physical parameters with unit, bounds and neutral value, and dataclass fields that declare them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cache
from typing import Any

from hsr_pin.errors import InputError, quoted

#: Prior standard deviation of an amplitude about its neutral value, in units of its scale (a change of practical size). Laws that
#: a user would notice have amplitudes of several scales; few exceed ten.
PRIOR_SCALES = 5.0


@dataclass(frozen=True)
class Parameter:
    """Prior knowledge about one physical quantity that is fitted.

    Attributes:
        name: the name used in code, in reports and on the command line.
        unit: for instance ``"rad"`` or ``"Nm s/rad"``; ``"1"`` for a ratio.
        neutral: the value that leaves the nominal model unchanged; for a shape parameter (a position, a width or a time constant,
            which has no influence while the amplitude is zero) the initial value.
        lower, upper: hard bounds, inclusive.
        scale: a change of practical size, in the unit; sets the steps of finite differences and the initial values.
        amplitude: True if the neutral value switches the effect off; False for a shape parameter.
        description: one line.
        level_exponent: exponent with which the amplitude scales with the stiffness level in the alternative variant of a law: -1
            for a law that is proportional to Keq (its moment is then the same at all levels), 1 for a law in absolute units (its
            moment is then proportional to Keq), 0 if there is no alternative variant.
        start_count: number of initial values, spread across the bounds, that quick fits try for a shape parameter.
        ratio_width: prior standard deviation of the logarithm of a factor on a declared number; None for any other quantity.
    """

    name: str
    unit: str
    neutral: float
    lower: float
    upper: float
    scale: float
    amplitude: bool
    description: str
    level_exponent: int = 0
    start_count: int = 3
    ratio_width: float | None = None

    def __post_init__(self) -> None:
        if not self.lower <= self.neutral <= self.upper:
            raise ValueError(f"{self.name}: neutral {self.neutral} outside [{self.lower}, {self.upper}]")
        if not (math.isfinite(self.scale) and self.scale > 0):
            raise ValueError(f"{self.name}: scale must be positive, got {self.scale}")

    def prior_width(self, value: float) -> float:
        """Return the prior standard deviation of the parameter, in its unit.

        The width of an amplitude is :data:`PRIOR_SCALES` scales about neutral, but at most that of a uniform distribution over
        its bounds. The width of a shape parameter is that of the uniform distribution. The width of a factor is proportional to
        its value.
        """
        if self.ratio_width is not None:
            return self.ratio_width * abs(value)
        within = (self.upper - self.lower) / math.sqrt(12)
        return min(PRIOR_SCALES * self.scale, within) if self.amplitude else within

    def departure(self, value: float) -> float:
        """Return the distance of a value from the prior mean, in prior standard deviations; 0 for a shape parameter."""
        if self.ratio_width is not None:
            return math.log(value / self.neutral) / self.ratio_width
        return (value - self.neutral) / self.prior_width(value) if self.amplitude else 0.0

    @property
    def start_values(self) -> list[float]:
        """Initial values across the bounds for quick fits, with equal ratios if the bounds span more than a factor of five."""
        at = [(k + 0.5) / self.start_count for k in range(self.start_count)]
        if self.lower > 0 and self.upper / self.lower > 5:
            return [self.lower * math.pow(self.upper / self.lower, f) for f in at]
        return [self.lower + (self.upper - self.lower) * f for f in at]


def finite(name: str, value: Any, expected: str = "a finite number") -> float:
    """Return a value given by the user as a finite float.

    Args:
        name: name of the quantity, for the error message.
        value: the value that was given.
        expected: description of valid values, for the error message.

    Raises:
        InputError: the value is not a number, not finite, or too large for a float.
    """
    try:
        number = math.nan if isinstance(value, str) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(name, expected=expected, received=quoted(value))
    return number


def amplitude(scale: float, unit: str, *, lower: float, upper: float, description: str, level_exponent: int = 0) -> Any:
    """Return a dataclass field that declares an amplitude, a :class:`Parameter` whose default and neutral value is 0."""
    return _field(Parameter("?", unit, 0.0, lower, upper, scale, True, description, level_exponent))


def shape(start: float, scale: float, unit: str, *, lower: float, upper: float, description: str, start_count: int = 3) -> Any:
    """Return a dataclass field that declares a shape parameter, a :class:`Parameter` whose default is its initial value."""
    return _field(Parameter("?", unit, start, lower, upper, scale, False, description, start_count=start_count))


def _field(fact: Parameter) -> Any:
    return dataclasses.field(default=fact.neutral, metadata={"parameter": fact})


@cache
def parameters_of(owner: type) -> tuple[Parameter, ...]:
    """Return the parameters that a dataclass declares, in the order of its fields."""
    return tuple(
        dataclasses.replace(field.metadata["parameter"], name=field.name)
        for field in dataclasses.fields(owner)
        if "parameter" in field.metadata
    )
