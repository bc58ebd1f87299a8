"""How a motion is integrated: the order of the extrapolation, and how steps are chosen."""

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
#: The method for most arms, and the one that cannot add energy to an oscillation that nothing damps: those of order above 2 do
#: where its damping ratio is below 0.006, at steps that their tolerance allows.
USUAL, RINGING = "extrapolated4", "extrapolated2"
#: Damping ratio of a whole arm below which it rings on.
HARDLY_DAMPED = 0.01
#: Default error of a step [m at the tip]: after steps of the torque the tip is then within 0.05 mm of the chain's exact motion,
#: in waves and staircases within 0.06 mm, with one or two links within 0.1 mm.
TOLERANCE = 5e-5
#: Default length of steps that are all the same [s], where an arm is stepped from outside.
STEP = 0.01
#: Length of a first step, and of the one after a jump of the torque [s]; and of the longest.
FIRST, LONGEST = 0.01, 0.32


@dataclass(frozen=True)
class Integrator:
    """A method and its steps.

    Attributes:
        name: one of :data:`ORDERS`; None: :data:`USUAL`, or :data:`RINGING` for arms that hardly anything damps.
        tolerance: [m] of the tip, that a step may be in error by.
        step: [s] steps of at most this length that divide the samples evenly, in place of a tolerance; None: as long as that
            allows.
    """

    name: str | None = None
    tolerance: float = TOLERANCE
    step: float | None = None

    def __post_init__(self) -> None:
        if self.name is not None and self.name not in ORDERS:
            raise InputError("integrator", expected=", ".join(ORDERS), received=repr(self.name))
        if self.step is None and self.name == "euler":
            raise InputError("step", expected="a length [s]: Euler's method knows nothing of its error", received="none")
        for name, value in (("tolerance", self.tolerance), ("step", self.step)):
            if value is not None and finite(name, value, "a number above zero") <= 0:
                raise InputError(name, expected="a number above zero", received=f"{value:g}")

    def substeps(self, duration: float) -> int:
        """Into how many steps of at most ``step`` a ``duration`` [s] is divided; 1 where there is a tolerance instead."""
        return substeps(duration, self.step)

    @property
    def weights(self) -> Array:
        """(2, p) of the results with 1 to p substeps, and without the first of them."""
        return _weights(ORDERS[self.name or USUAL])

    def suited(self, ringing: bool) -> Integrator:
        """The method by name, for an arm that rings on or not."""
        return self if self.name else replace(self, name=RINGING if ringing else USUAL)


def substeps(duration: float, step: float | None) -> int:
    """As :meth:`Integrator.substeps`."""
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
