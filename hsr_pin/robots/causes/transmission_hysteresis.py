"""Friction of the joints that yields like a spring before it slides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude, shape
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.robots.friction import SLIDES
from hsr_pin.trajectory import Array


class TransmissionHysteresis(JointCause):
    """Friction of the joints that yields like a spring before it slides."""

    name = "transmission_hysteresis"
    kind = "friction"
    description = "friction of the joints that yields like a spring before it slides, as in a strain wave gear"
    citation = "P. Dahl, A solid friction model, Aerospace Corp. TOR-0158 (1968)"

    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """A level of each joint; the way over which it is built up."""
        own = (amplitude(joint, 0.1 * sizes.torque[k], "N m", lower=0.0) for k, joint in enumerate(joints))
        return (*own, shape("way", 0.05, 0.005, 0.5, "rad"))

    def start(self, values: Values, now: Now, a: Array) -> Array:
        """(B, n) share of the level: all of it in a joint that moves."""
        return np.asarray(np.tanh(now.v / SLIDES))

    def torque(self, values: Values, now: Now) -> tuple[Array, Array]:
        """As it is at the end of the step."""
        grows = values.of_joints() * (1 - now.state * np.sign(now.v)) / values.shared("way") * now.h
        return -values.of_joints() * now.state - grows * now.v, grows

    def after(self, values: Values, now: Now, a: Array) -> Array:
        """(B, n) share of the level at the end of the step in which the joints accelerate by a (B, n)."""
        way = (now.h * now.v + now.h**2 / 2 * a) / values.shared("way")
        return np.asarray(np.clip(np.sign(way) + (now.state - np.sign(way)) * np.exp(-np.abs(way)), -1.0, 1.0))
