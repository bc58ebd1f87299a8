"""From the torques of an arm in space to pressures of its chambers, or tensions of its tendons, within their range and rate."""

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

#: A unit in every channel counts beside the torques as this share of what a unit in the strongest one gives.
_LEAST = 1e-4
#: Torques that differ by no more than this share of what a unit in the strongest channel gives are the same.
_SAME = 1e-5


@dataclass(frozen=True, eq=False)
class ChannelCommand:
    """What the regulators are told.

    Attributes:
        values: (C,) of the channels, in their units.
        torque: (2 S,) [N m] that they give.
        saturated: whether that is not the torque that was asked for.
    """

    values: Array
    torque: Array
    saturated: bool

    def __post_init__(self) -> None:
        for name in ("values", "torque"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


@dataclass(frozen=True)
class ChannelRegulators:
    """Regulators that push or pull in one way only, as many as there are chambers or tendons.

    Of all values that give a torque the least are taken (three chambers: one of them empty); where none gives it, those that come
    nearest to it. C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, SIAM (1995), chapter 23: bounded variables.

    Attributes:
        channels: (C,) as a dataset has them; what was only measured is left out.
        highest: the largest value of each [its unit].
        lowest: the smallest: at rest, or so that a tendon does not go slack.
        rate: fastest change of any [its unit/s].

    Raises:
        InputError: a range or a rate that is none, or no channel that drives.
    """

    channels: tuple[Channel, ...]
    highest: float
    lowest: float = 0.0
    rate: float = math.inf

    def __post_init__(self) -> None:
        if not self.lowest < self.highest or not self.rate > 0:
            received = f"{self.lowest} to {self.highest}, {self.rate}"
            raise InputError("regulators", expected="a lowest and a higher value, and a rate above zero", received=received)
        if not self.driving:
            raise InputError("channels", expected="at least one that gives a torque", received=len(self.channels))

    @cached_property
    def driving(self) -> Sequence[Channel]:
        """Those of the channels that give a torque: C of them."""
        return [channel for channel in self.channels if channel.torque]

    @cached_property
    def gains(self) -> Array:
        """(2 S, C) [N m per unit]."""
        return np.array([channel.torque for channel in self.driving]).T

    def command(self, torque: ArrayLike, dt: float = math.inf, before: ChannelCommand | None = None) -> ChannelCommand:
        """The values for a torque (2 S,) [N m], ``dt`` [s] after the command ``before`` (default: whatever came before).

        Raises:
            InputError: a torque of other sections or that is no number, or a step that is none.
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
