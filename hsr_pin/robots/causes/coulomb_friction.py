"""Cause ``coulomb_friction``: friction of the joints that does not depend on their speed."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.robots.friction import sliding_friction
from hsr_pin.trajectory import Array


class CoulombFriction(JointCause):
    """Friction of the joints that does not depend on their speed."""

    name = "coulomb_friction"
    kind = "friction"
    description = "friction of the joints that does not depend on their speed"
    citation = "P. Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968); regularised"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the friction level of each joint."""
        return tuple(amplitude(joint, 0.1 * scales.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the regularised friction torque and its slope."""
        return sliding_friction(values.of_joints(), now.v)
