"""Conversion of the torques of an arm in space to chamber pressures or tendon tensions, within their range and rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import lsq_linear

from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array, Channel, read_only

#: Weight of a unit in every channel relative to the torque of a unit in the strongest channel.
_LEAST = 1e-4
#: Largest difference of torques that are treated as equal, relative to the torque of a unit in the strongest channel.
_SAME = 1e-5


@dataclass(frozen=True, eq=False)
class ChannelCommand:
    """The command for the regulators.

    Attributes:
        values: (C,) values of the channels, in their units.
        torque: (2 S,) resulting torque [N m].
        saturated: whether the resulting torque differs from the requested one.
    """

    values: Array
    torque: Array
    saturated: bool

    def __post_init__(self) -> None:
        for name in ("values", "torque"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


@dataclass(frozen=True)
class ChannelRegulators:
    """Regulators that act in one direction only, one for each chamber or tendon.

    Among all values that give a torque the smallest are chosen (with three chambers, one of them is empty); if none gives it, the
    values with the nearest torque. C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, SIAM (1995), chapter 23: bounded
    variables.

    Attributes:
        channels: channels of a dataset; those that were only measured are ignored.
        highest: largest value of each channel, in its unit.
        lowest: smallest value of each channel, for example the value at rest, or a tension that keeps a tendon taut.
        rate: largest rate of change of any channel [its unit/s].

    Raises:
        InputError: a range or a rate is invalid, or no channel produces a torque.
    """

    channels: tuple[Channel, ...]
    highest: float
    lowest: float = 0.0
    rate: float = math.inf

    def __post_init__(self) -> None:
        if not self.lowest < self.highest or not self.rate > 0:
            received = f"{self.lowest} to {self.highest}, {self.rate}"
            raise InputError("regulators", expected="a lowest value below the highest, and a rate above zero", received=received)
        if not self.driving:
            raise InputError("channels", expected="at least one that produces a torque", received=len(self.channels))

    @cached_property
    def driving(self) -> Sequence[Channel]:
        """The C channels that produce a torque."""
        return [channel for channel in self.channels if channel.torque]

    @cached_property
    def gains(self) -> Array:
        """Torque per unit of each channel (2 S, C) [N m per unit]."""
        return np.array([channel.torque for channel in self.driving]).T

    def command(self, torque: ArrayLike, dt: float = math.inf, before: ChannelCommand | None = None) -> ChannelCommand:
        """Return the command for a torque (2 S,) [N m], ``dt`` [s] after the command ``before`` (default: no rate limit).

        Raises:
            InputError: the torque has the wrong number of sections or is not finite, or the step is invalid.
        """
        asked = np.asarray(torque, dtype=float).ravel()
        if asked.shape != (len(self.gains),) or not np.isfinite(asked).all() or not dt > 0:
            expected = f"{len(self.gains)} finite torques [N m] and a step above zero [s]"
            raise InputError("command", expected=expected, received=f"{torque!r}, {dt}")
        count = len(self.driving)
        low, high = np.full(count, self.lowest), np.full(count, self.highest)
        if before is not None:
            reach = self.rate * dt
            low, high = np.maximum(low, before.values - reach), np.minimum(high, before.values + reach)
        strongest = float(np.linalg.norm(self.gains, axis=0).max())
        rows = np.vstack([self.gains / strongest, _LEAST * np.eye(count)])
        right = np.concatenate([asked / strongest, np.full(count, _LEAST * self.lowest)])
        values = lsq_linear(rows, right, (low, np.maximum(high, low + 1e-12)), method="bvls").x
        given = self.gains @ values
        return ChannelCommand(values, given, bool(np.abs(given - asked).max() > _SAME * strongest))
