"""Friction of the joints in proportion to their speed."""

from __future__ import annotations

from collections.abc import Sequence

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.trajectory import Array


class ViscousFriction(JointCause):
    """Friction of the joints in proportion to their speed."""

    name = "viscous_friction"
    kind = "damping"
    description = "friction of the joints in proportion to their speed"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A coefficient of each joint."""
        scales = 0.1 * sizes.torque / sizes.speed
        return tuple(amplitude(joint, scales[k], "N m s/rad", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Against the motion; half of the slope, as for a trapezoidal rule."""
        slope = values.of_joints()
        return -slope * now.v, slope / 2
