"""Table II of the paper, as printed: the pressure combinations of its Fig. 4.

Eqs. (1), (4) and (5), solved for the pressures, reproduce every printed digit except two: P1 of the third row results as 0.3386
bar, where the table has 0.3368. The printed value gives 0.999 N m instead of 1.000, well within the uncertainty of the map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hsr_pin.errors import PressureError


@dataclass(frozen=True)
class Combination:
    """One row of Table II.

    Attributes:
        P1, P2: pressures [bar].
        keq: bending stiffness [Nm/rad].
        tau: torque on every joint [N m].
    """

    P1: float
    P2: float
    keq: float
    tau: float


TABLE_II = (
    Combination(1.2868, 1.8735, 1.11, 0.250),
    Combination(0.8127, 2.1477, 1.11, 0.625),
    Combination(0.3368, 2.4218, 1.11, 1.000),
    Combination(2.4285, 2.0755, 2.33, 0.100),
    Combination(1.4046, 2.6676, 2.33, 1.800),
    Combination(0.3807, 3.2597, 2.33, 3.500),
)


def combinations(keq: float) -> tuple[Combination, ...]:
    """Return the three rows of Table II for a stiffness [Nm/rad].

    Raises:
        PressureError: the paper does not tabulate combinations for this stiffness.
    """
    rows = tuple(row for row in TABLE_II if math.isclose(row.keq, keq, rel_tol=1e-9))
    if not rows:
        tabulated = " or ".join(f"{value:g}" for value in dict.fromkeys(row.keq for row in TABLE_II))
        raise PressureError(
            "pressure combinations of Table II",
            expected=f"a stiffness of {tabulated} Nm/rad",
            received=f"{keq:g}",
            hint="for other values specify pressures or a torque",
        )
    return rows
