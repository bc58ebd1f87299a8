"""Encoders whose zero is not where it is declared."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Sizes, Values
from hsr_pin.trajectory import Array


class EncoderOffset(JointCause):
    """Encoders whose zero is not where it is declared."""

    name = "encoder_offset"
    kind = "measurement"
    description = "encoders whose zero is not where it is declared"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """An angle of each joint."""
        return tuple(amplitude(joint, 0.02, "rad", lower=-1.0, upper=1.0) for k, joint in enumerate(joints))

    def shown(self, values: Values, q: Array) -> Array:
        """With the offset."""
        return q + _beside(values.of_joints(), q)

    def read(self, values: Values, q: Array) -> Array:
        """Without it."""
        return q - values.of_joints()


def _beside(values: Array, q: Array) -> Array:
    """(B, n) as (B, 1, ..., n) beside angles."""
    return values.reshape(len(values), *(1,) * (q.ndim - 2), values.shape[1])
