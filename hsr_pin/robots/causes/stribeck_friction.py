"""Friction of the joints that falls from rest to a lower level as they move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values, of
from hsr_pin.robots.friction import sliding
from hsr_pin.trajectory import Array


class StribeckFriction(JointCause):
    """Friction of the joints that falls from rest to a lower level as they move."""

    name = "stribeck_friction"
    kind = "friction"
    description = "friction of the joints that falls from rest to a lower level as they move"
    citation = "R. Stribeck, VDI-Zeitschrift 46 (1902); B. Armstrong-Helouvry et al., Automatica 30 (1994)"
    contains = ("coulomb_friction",)

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A level and what is added at rest, of each joint; the speed over which that goes."""
        return (
            *(amplitude(of("level", joint), 0.1 * sizes.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints)),
            *(amplitude(of("at_rest", joint), 0.1 * sizes.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints)),
            shape("speed", 0.1, 0.02, 1.0, "rad/s"),
        )

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """Against the motion."""
        more = values.of_joints("at_rest") * np.exp(-((now.v / values.shared("speed")) ** 2))
        return sliding(values.of_joints("level") + more, now.v)
