"""Encoders that show more or less than the angle, in proportion."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class EncoderGain(JointCause):
    """Encoders that show more or less than the angle, in proportion."""

    name = "encoder_gain"
    kind = "measurement"
    description = "encoders that show more or less than the angle, in proportion"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A share of each joint."""
        return tuple(amplitude(joint, 0.02, lower=-0.5, upper=1.0) for k, joint in enumerate(joints))

    def shown(self, values: Values, q: Array) -> Array:
        """In proportion."""
        gain = 1 + values.of_joints()
        return q * gain.reshape(len(gain), *(1,) * (q.ndim - 2), gain.shape[1])

    def read(self, values: Values, q: Array) -> Array:
        """The angle itself."""
        return q / (1 + values.of_joints())
