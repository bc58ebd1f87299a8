"""Cause ``viscous_friction``: friction of the joints in proportion to their speed."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.trajectory import Array


class ViscousFriction(JointCause):
    """Friction of the joints in proportion to their speed."""

    name = "viscous_friction"
    kind = "damping"
    description = "friction of the joints in proportion to their speed"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the coefficient of each joint."""
        amplitudes = 0.1 * scales.torque / scales.speed
        return tuple(amplitude(joint, amplitudes[k], "N m s/rad", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the viscous torque, and half of its slope, as in a trapezoidal rule."""
        slope = values.of_joints()
        return -slope * now.v, slope / 2
