"""Cause ``encoder_gain``: encoder angles that are too large or too small by a factor."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class EncoderGain(JointCause):
    """Encoders that show too large or too small an angle, by a factor."""

    name = "encoder_gain"
    kind = "measurement"
    description = "encoders that show too large or too small an angle, by a factor"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the relative error of each encoder."""
        return tuple(amplitude(joint, 0.02, lower=-0.5, upper=1.0) for k, joint in enumerate(joints))

    def encoder_reading(self, values: Values, q: Array) -> Array:
        """Return the angles multiplied by the gain."""
        gain = 1 + values.of_joints()
        return q * gain.reshape(len(gain), *(1,) * (q.ndim - 2), gain.shape[1])

    def true_angle(self, values: Values, q: Array) -> Array:
        """Return the shown angles divided by the gain."""
        return q / (1 + values.of_joints())
