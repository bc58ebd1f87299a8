"""Elastic or loose transmissions, which give the motor an angle of its own.

The lead of the motor over its joint is a state. Part of the inertia moves with the motor: the declared rotor inertia, or a
share of the link's inertia, and what the cause ``rotor_inertia`` adds. The transmitted torque is taken at the end of a step, or
averaged over it, so that stiff contacts need no small steps.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.explain.model import shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class Motor:
    """State of the motors relative to their joints.

    Attributes:
        lead: (B, n) angle of the motor minus angle of the joint [rad].
        lead_rate: (B, n) its rate [rad/s].
    """

    lead: Array
    lead_rate: Array


class Transmission(JointCause):
    """A compliant or loose element between motor and joint."""

    @abstractmethod
    def is_present(self, values: Values) -> NDArray[np.bool_]:
        """Return which joints have this element, (B, n)."""

    @abstractmethod
    def transmitted(self, values: Values, motor: Motor, h: Array) -> tuple[Array, Array]:
        """Return the torque on the joint over a step h (B, 1) [s] without accelerations [N m], and its slope [N m s/rad]."""

    @abstractmethod
    def static_lead(self, values: Values, torque: Array) -> Array:
        """Return the lead of the motor while it transmits a torque (B, n) [N m] at rest, (B, n) [rad]."""

    @staticmethod
    def shared(scales: Scales) -> tuple[Parameter, ...]:
        """Return the shared parameters: place of the encoders, and motor share of the inertia, unless they are declared."""
        side = shape("encoder_side", 0.5, 0.0, 1.0, start_count=2, description="0: encoder at the joint, 1: at the motor")
        share = shape("motor_share", 0.3, 0.05, 0.8, start_count=1)
        return (*[side] * (not scales.encoders), *[share] * (not (scales.rotor_inertia > 0).all()))

    def inertia(self, values: Values) -> Array:
        """Return the inertia that turns with the motor, (B, n) [kg m^2], including that which ``rotor_inertia`` adds."""
        scales, added = values.scales, values.of_other_cause("rotor_inertia")
        if (scales.rotor_inertia > 0).all():
            return scales.rotor_inertia + added
        return (
            np.where(scales.rotor_inertia > 0, scales.rotor_inertia, values.shared("motor_share") * scales.free_inertia) + added
        )

    def armature(self, values: Values) -> Array:
        """Return the inertia that turns with the motor as a negative addition to that of the joint, (B, n) [kg m^2]."""
        return np.where(self.is_present(values), -self.inertia(values), 0.0)

    def encoder_lead(self, values: Values, state: Motor) -> tuple[Array, Array]:
        """Return the lead of the encoders over the joints [rad], and the relative speed of the motors [rad/s]."""
        encoders = values.scales.encoders
        side = float(encoders == "motor") if encoders else values.shared("encoder_side")
        return np.where(self.is_present(values), side * state.lead, 0.0), np.where(self.is_present(values), state.lead_rate, 0.0)

    def initial_state(self, values: Values, now: StepStart, a: Array) -> Motor:
        """Return the state in which the transmission carries the motor torque minus the inertial torque of the rotor."""
        return Motor(self.static_lead(values, now.motor_torque - self.inertia(values) * a), np.zeros_like(now.v))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the transmitted torque minus the motor's own torque, and its decrease per speed, each (B, n)."""
        torque, slope, ratio = self._step(values, now)
        present, share = self.is_present(values), 1 / (1 + ratio)
        added = share * (torque + ratio * now.motor_torque) - now.motor_torque
        return np.where(present, added, 0.0), np.where(present, share * (slope + ratio * now.slope) - now.slope, 0.0)

    def next_state(self, values: Values, now: StepStart, a: Array) -> Motor:
        """Return the state of the motors at the end of a step with joint accelerations a (B, n) [rad/s^2]."""
        torque, slope, ratio = self._step(values, now)
        motor_torque = now.motor_torque - now.slope * now.h * a
        own = (motor_torque - torque + slope * now.h * a) / (self.inertia(values) * (1 + ratio))
        relative, motor = own - a, now.state
        return Motor(motor.lead + now.h * motor.lead_rate + now.h**2 / 2 * relative, motor.lead_rate + now.h * relative)

    def _step(self, values: Values, now: StepStart) -> tuple[Array, Array, Array]:
        torque, slope = self.transmitted(values, now.state, now.h)
        return torque, slope, slope * now.h / self.inertia(values)
