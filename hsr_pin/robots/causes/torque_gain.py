"""Torques larger or smaller than recorded, in proportion."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class TorqueGain(JointCause):
    """Torques larger or smaller than recorded, in proportion."""

    name = "torque_gain"
    kind = "actuation_map"
    description = "torques larger or smaller than recorded, in proportion"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A share of each joint."""
        return tuple(amplitude(joint, 0.05, lower=-0.9, upper=5.0) for k, joint in enumerate(joints))

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array]:
        """In proportion."""
        factor = 1 + values.of_joints()
        return torque * factor, factor
