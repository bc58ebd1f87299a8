"""Cause ``torque_gain``: motor torques larger or smaller than recorded, by a factor."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class TorqueGain(JointCause):
    """Motor torques larger or smaller than recorded, by a factor."""

    name = "torque_gain"
    kind = "actuation_map"
    description = "motor torques larger or smaller than recorded, by a factor"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the relative error of the torque of each joint."""
        return tuple(amplitude(joint, 0.05, lower=-0.9, upper=5.0) for k, joint in enumerate(joints))

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """Return the torque multiplied by the gain, and the gain as derivative."""
        factor = 1 + values.of_joints()
        return torque * factor, factor
