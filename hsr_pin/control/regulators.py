"""Conversion of a torque to pressures for regulators: on the line of constant stiffness, within their range and rate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.robot.pressure import PAPER, PressureMap
from hsr_pin.trajectory import Array, read_only


@dataclass(frozen=True, eq=False)
class PressureCommand:
    """The command for the regulators.

    Attributes:
        pressures: (2,) pressures P1, P2 [bar].
        torque: resulting torque by Eq. (5) [N m].
        saturated: whether the resulting torque differs from the requested one.
    """

    pressures: Array
    torque: float
    saturated: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "pressures", read_only(self.pressures))


@dataclass(frozen=True)
class Regulators:
    """A pair of pressure regulators on an arm of constant stiffness.

    If a torque cannot be reached, the nearest torque on the line is used: the stiffness is kept.

    Attributes:
        keq: stiffness of the arm [Nm/rad].
        rate: largest rate of change of both pressures [bar/s].
        pressure_map: Eqs. (1) and (4), and the range of the pressures.

    Raises:
        PressureError: no pressures give this stiffness.
        InputError: the rate is not positive.
    """

    keq: float
    rate: float = math.inf
    pressure_map: PressureMap = PAPER

    def __post_init__(self) -> None:
        if not self.rate > 0:
            raise InputError("rate", expected="more than zero [bar/s]", received=self.rate)
        _ = self.torque_range  # raises for a stiffness out of reach

    @cached_property
    def torque_range(self) -> tuple[float, float]:
        """Lowest and highest torque [N m] on the line."""
        return self.pressure_map.torque_range(self.keq)

    @cached_property
    def torque_rate(self) -> float:
        """Largest rate of change of the torque [N m/s] along the line."""
        low, high = self.torque_range
        ends = self.pressure_map.pressures_for_torque(self.keq, [low, high])
        return self.rate * (high - low) / float(np.abs(ends[1] - ends[0]).max())

    def command(self, torque: float, dt: float = math.inf, before: PressureCommand | None = None) -> PressureCommand:
        """Return the pressures for a torque [N m], ``dt`` [s] after the command ``before`` (default: no rate limit).

        Raises:
            InputError: the torque or the step is not a number.
        """
        if not math.isfinite(torque) or not dt > 0:
            raise InputError("command", expected="a finite torque [N m] and a step above zero [s]", received=f"{torque}, {dt}")
        low, high = self.torque_range
        if before is not None:
            reach = self.torque_rate * dt
            low, high = max(low, before.torque - reach), min(high, before.torque + reach)
        given = min(max(torque, low), high)
        return PressureCommand(self.pressure_map.pressures_for_torque(self.keq, given), given, given != torque)
