"""A drag on the joints that grows with the square of their speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.trajectory import Array


class QuadraticDamping(JointCause):
    """A drag on the joints that grows with the square of their speed."""

    name = "quadratic_damping"
    kind = "damping"
    description = "a drag on the joints that grows with the square of their speed"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A coefficient of each joint."""
        scales = 0.1 * sizes.torque / sizes.speed**2
        return tuple(amplitude(joint, scales[k], "N m s^2/rad^2", lower=0.0) for k, joint in enumerate(joints))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Against the motion; half of the slope, as for a trapezoidal rule."""
        size = values.of_joints()
        return -size * now.v * np.abs(now.v), size * np.abs(now.v)
