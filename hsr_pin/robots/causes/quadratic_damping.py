"""Cause ``quadratic_damping``: drag on the joints in proportion to the square of their speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.trajectory import Array


class QuadraticDamping(JointCause):
    """Drag on the joints in proportion to the square of their speed."""

    name = "quadratic_damping"
    kind = "damping"
    description = "drag on the joints in proportion to the square of their speed"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the drag coefficient of each joint."""
        amplitudes = 0.1 * scales.torque / scales.speed**2
        return tuple(amplitude(joint, amplitudes[k], "N m s^2/rad^2", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the drag torque, and half of its slope, as in a trapezoidal rule."""
        size = values.of_joints()
        return -size * now.v * np.abs(now.v), size * np.abs(now.v)
