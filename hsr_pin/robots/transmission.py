"""A motor that turns beside its joint: what lies between the two passes torque on, late and softly.

The motor's angle is a state of its own. Part of the inertia moves with it: the declared rotor, or a share of the link's own.
The torque between motor and joint is that at the end of a step, or the mean over it, so that stiff contacts need no small steps.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class Motor:
    """How far a motor is ahead of its joint.

    Attributes:
        ahead: (B, n) [rad].
        faster: (B, n) [rad/s] by how much it turns faster.
    """

    ahead: Array
    faster: Array


class Transmission(JointCause):
    """Something soft or loose between motor and joint."""

    @abstractmethod
    def there(self, values: Values) -> NDArray[np.bool_]:
        """(B, n) which joints have it."""

    @abstractmethod
    def passed(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """(B, n) torque [N m] on the joint over a step h (B, 1) [s] if nothing accelerates, and its slope [N m s/rad]."""

    @abstractmethod
    def apart(self, values: Values, torque: Array) -> Array:
        """(B, n) [rad] by which the motor is ahead while it passes on a torque (B, n) [N m]."""

    @staticmethod
    def shared(sizes: Sizes) -> tuple[Parameter, ...]:
        """Where the encoders sit, where nobody said it; the share of the inertia that turns with the motor, likewise."""
        side = shape("encoder_side", 0.5, 0.0, 1.0, start_count=2, description="0: at the joint, 1: at the motor")
        share = shape("motor_share", 0.3, 0.05, 0.8, start_count=1)
        return (*[side] * (not sizes.encoders), *[share] * (not (sizes.rotor > 0).all()))

    def inertia(self, values: Values) -> Array:
        """(B, n) [kg m^2] that turns with the motor."""
        sizes = values.sizes
        if (sizes.rotor > 0).all():
            return np.repeat(sizes.rotor[None], len(values), axis=0)
        return np.where(sizes.rotor > 0, sizes.rotor, values.shared("motor_share") * sizes.alone)

    def armature(self, values: Values) -> Array:
        """What turns with the motor does not turn with the link."""
        return np.where(self.there(values), -self.inertia(values), 0.0)

    def beside(self, values: Values, state: Motor) -> tuple[Array, Array]:
        """The motors, as far as the encoders sit on them."""
        encoders = values.sizes.encoders
        side = float(encoders == "motor") if encoders else values.shared("encoder_side")
        return np.where(self.there(values), side * state.ahead, 0.0), np.where(self.there(values), state.faster, 0.0)

    def start(self, values: Values, now: Now, a: Array) -> Motor:
        """It passes on what its own acceleration leaves."""
        return Motor(self.apart(values, now.driven - self.inertia(values) * a), np.zeros_like(now.v))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """What is passed on in place of the motor's own torque."""
        torque, slope, ratio = self._step(values, now)
        there, share = self.there(values), 1 / (1 + ratio)
        added = share * (torque + ratio * now.driven) - now.driven
        return np.where(there, added, 0.0), np.where(there, share * (slope + ratio * now.slope) - now.slope, 0.0)

    def after(self, values: Values, now: Now, a: Array) -> Motor:
        """The motor at the end of the step in which the joints accelerate by a (B, n) [rad/s^2]."""
        torque, slope, ratio = self._step(values, now)
        driven = now.driven - now.slope * now.h * a
        own = (driven - torque + slope * now.h * a) / (self.inertia(values) * (1 + ratio))
        apart, motor = own - a, now.state
        return Motor(motor.ahead + now.h * motor.faster + now.h**2 / 2 * apart, motor.faster + now.h * apart)

    def _step(self, values: Values, now: Now) -> tuple[Array, Array, Array]:
        torque, slope = self.passed(values, now.state, now.h)
        return torque, slope, slope * now.h / self.inertia(values)
