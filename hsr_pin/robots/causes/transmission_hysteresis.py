"""Cause ``transmission_hysteresis``: friction of the joints with elastic presliding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.robots.friction import SLIDING_SPEED
from hsr_pin.trajectory import Array


class TransmissionHysteresis(JointCause):
    """Friction of the joints with elastic presliding."""

    name = "transmission_hysteresis"
    kind = "friction"
    description = "friction of the joints with elastic presliding, as in a strain wave gear"
    citation = "P. Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968)"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the friction level of each joint, and the presliding distance."""
        own = (amplitude(joint, 0.1 * scales.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints))
        return (*own, shape("way", 0.05, 0.005, 0.5, "rad"))

    def initial_state(self, values: Values, now: StepStart, a: Array) -> Array:
        """Return the friction as a share of its level, (B, n); it is fully developed in moving joints."""
        return np.asarray(np.tanh(now.v / SLIDING_SPEED))

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array]:
        """Return the friction torque at the end of the step, and its slope."""
        grows = values.of_joints() * (1 - now.state * np.sign(now.v)) / values.shared("way") * now.h
        return -values.of_joints() * now.state - grows * now.v, grows

    def next_state(self, values: Values, now: StepStart, a: Array) -> Array:
        """Return the share of the friction level at the end of a step with joint accelerations a (B, n) [rad/s^2]."""
        way = (now.h * now.v + now.h**2 / 2 * a) / values.shared("way")
        return np.asarray(np.clip(np.sign(way) + (now.state - np.sign(way)) * np.exp(-np.abs(way)), -1.0, 1.0))
