"""Integration methods: the order of the extrapolation and the choice of step lengths."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import ceil, prod

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.parameters import finite
from hsr_pin.trajectory import Array

#: Order of each method by name.
ORDERS = {"euler": 1, "extrapolated2": 2, "extrapolated3": 3, "extrapolated4": 4, "extrapolated5": 5, "extrapolated6": 6}
#: The default method, and the method for lightly damped arms, which cannot add energy to an undamped oscillation. Methods of
#: order above 2 do so at damping ratios below 0.006, at the step lengths that their tolerance allows.
USUAL, RINGING = "extrapolated4", "extrapolated2"
#: Damping ratio of the whole arm below which it is treated as lightly damped.
HARDLY_DAMPED = 0.01
#: Default tolerance of a step [m at the tip]. The tip is then within 0.05 mm of the exact motion of the chain after steps of the
#: torque, within 0.06 mm for waves and staircases, and within 0.1 mm for chains of one or two links.
TOLERANCE = 5e-5
#: Default length of constant steps, for arms that a caller advances step by step [s].
STEP = 0.01
#: Length of the first step and of the step after a jump of the torque [s]; largest step length [s].
FIRST, LONGEST = 0.01, 0.32


@dataclass(frozen=True)
class Integrator:
    """An integration method with the choice of its step lengths.

    Attributes:
        name: one of :data:`ORDERS`; None: :data:`USUAL`, or :data:`RINGING` for lightly damped arms.
        tolerance: largest error of a step [m at the tip].
        step: largest length of constant steps that divide the sampling interval evenly [s]; None: the tolerance determines the
            step lengths.
    """

    name: str | None = None
    tolerance: float = TOLERANCE
    step: float | None = None

    def __post_init__(self) -> None:
        if self.name is not None and self.name not in ORDERS:
            raise InputError("integrator", expected=", ".join(ORDERS), received=repr(self.name))
        if self.step is None and self.name == "euler":
            raise InputError("step", expected="a step length [s], because Euler's method has no error estimate", received="none")
        for name, value in (("tolerance", self.tolerance), ("step", self.step)):
            if value is not None and finite(name, value, "a number above zero") <= 0:
                raise InputError(name, expected="a number above zero", received=f"{value:g}")

    def substeps(self, duration: float) -> int:
        """Return the number of steps of at most ``step`` in a ``duration`` [s]; 1 if a tolerance determines the steps."""
        return substeps(duration, self.step)

    @property
    def weights(self) -> Array:
        """Weights (2, p) of the results with 1 to p substeps: for order p, and without the first result."""
        return _weights(ORDERS[self.name or USUAL])

    def for_arm(self, ringing: bool) -> Integrator:
        """Return the method, with a default name that suits a lightly damped (``ringing``) arm or any other."""
        return self if self.name else replace(self, name=RINGING if ringing else USUAL)


def substeps(duration: float, step: float | None) -> int:
    """Return the number of steps of at most ``step`` [s] in a ``duration`` [s]; 1 if ``step`` is None."""
    return 1 if step is None else max(1, ceil(duration / step - 1e-6))


@cache
def _weights(order: int) -> Array:
    every = range(1, order + 1)
    rows = np.zeros((2, order))
    for row, first in enumerate((1, 2)):
        for n in range(first, order + 1):
            rows[row, n - 1] = prod(n / (n - m) for m in every if m != n and m >= first)
    rows.flags.writeable = False
    return rows
