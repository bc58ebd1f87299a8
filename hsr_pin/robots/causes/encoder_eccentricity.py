"""Cause ``encoder_eccentricity``: encoder discs that are mounted off the axes of their joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.trajectory import Array

#: Iterations of the inverse; each reduces its error by the amplitude, which is much smaller than one radian.
_ITERATIONS = 20


class EncoderEccentricity(JointCause):
    """Encoders whose error is a sine of the angle, because their disc is mounted off the axis of the joint."""

    name = "encoder_eccentricity"
    kind = "measurement"
    description = "encoders whose error is a sine of the angle, because their disc is mounted off the axis of the joint"
    citation = "J. R. R. Mayer, High-resolution of rotary encoder analog quadrature signals, IEEE Trans. Instrum. Meas. 43 (1994)"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the two amplitudes of each joint, of the sine and of the cosine of the angle, which give size and phase."""
        return tuple(
            amplitude(f"{name}:{joint}", 0.02, "rad", lower=-0.4, upper=0.4) for joint in joints for name in ("sine", "cosine")
        )

    def encoder_reading(self, values: Values, q: Array) -> Array:
        """Return the angles plus the sines of them."""
        sine, cosine = (
            part.reshape(len(part), *(1,) * (q.ndim - 2), part.shape[1])
            for part in (values.of_joints("sine"), values.of_joints("cosine"))
        )
        return q + sine * np.sin(q) + cosine * np.cos(q)

    def true_angle(self, values: Values, q: Array) -> Array:
        """Return the angles at which the encoders show the given ones, by fixed-point iteration."""
        true = q
        for _ in range(_ITERATIONS):
            true = true + q - self.encoder_reading(values, true)
        return true
