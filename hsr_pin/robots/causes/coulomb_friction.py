"""Friction of the joints that does not depend on their speed."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.robots.friction import sliding
from hsr_pin.trajectory import Array


class CoulombFriction(JointCause):
    """Friction of the joints that does not depend on their speed."""

    name = "coulomb_friction"
    kind = "friction"
    description = "friction of the joints that does not depend on their speed"
    citation = "P. Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968); regularised"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A level of each joint."""
        return tuple(amplitude(joint, 0.1 * sizes.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Against the motion."""
        return sliding(values.of_joints(), now.v)
