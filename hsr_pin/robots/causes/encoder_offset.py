"""Cause ``encoder_offset``: encoders whose zero differs from the declared one."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array


class EncoderOffset(JointCause):
    """Encoders whose zero differs from the declared one."""

    name = "encoder_offset"
    kind = "measurement"
    description = "encoders whose zero differs from the declared one"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the offset of each encoder."""
        return tuple(amplitude(joint, 0.02, "rad", lower=-1.0, upper=1.0) for k, joint in enumerate(joints))

    def encoder_reading(self, values: Values, q: Array) -> Array:
        """Return the angles plus the offsets."""
        return q + _broadcast(values.of_joints(), q)

    def true_angle(self, values: Values, q: Array) -> Array:
        """Return the shown angles minus the offsets."""
        return q - values.of_joints()


def _broadcast(values: Array, q: Array) -> Array:
    """Return values (B, n) as (B, 1, ..., n), with as many dimensions as the angles."""
    return values.reshape(len(values), *(1,) * (q.ndim - 2), values.shape[1])
