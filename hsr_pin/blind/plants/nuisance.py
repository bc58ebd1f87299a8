"""What is always a little wrong: parameters, noise, and effects too small to be seen on their own."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .laws import actuation, mounting
from .laws.law import Law


@dataclass(frozen=True)
class Nuisance:
    """Errors of one dataset.

    Attributes:
        k, c: true over declared stiffness and damping [-].
        noise: standard deviation of the markers, each axis [m].
        placement: standard deviation of where markers truly sit, along and off the arm [m].
        lag: [s], tilt: [rad], bias: [N m], extra: at the tip [kg]: tiny effects.
    """

    k: float = 1.0
    c: float = 1.0
    noise: float = 0.0
    placement: float = 0.0
    lag: float = 0.0
    tilt: float = 0.0
    bias: float = 0.0
    extra: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Nuisance:
        """K off by up to 15 %, C by up to 30 %, 0.3 to 0.5 mm of noise, the rest well below it."""
        return cls(
            k=float(1 + rng.uniform(-0.15, 0.15)),
            c=float(1 + rng.uniform(-0.30, 0.30)),
            noise=float(rng.uniform(3e-4, 5e-4)),
            placement=5e-5,
            lag=float(rng.uniform(0, 3e-4)),
            tilt=float(rng.uniform(-5e-4, 5e-4)),
            bias=float(rng.uniform(-3e-4, 3e-4)),
            extra=float(rng.uniform(0, 2e-4)),
        )

    def laws(self) -> tuple[Law, ...]:
        """The tiny effects, as laws."""
        return (
            actuation.ActuatorLag(self.lag),
            actuation.TorqueBias(self.bias),
            mounting.GravityTilt(self.tilt),
            mounting.TipMass(self.extra),
        )

    def describe(self) -> dict[str, Any]:
        """For an answer file."""
        return asdict(self)


def noise_floor(noise: float, axes: int = 2) -> float:
    """RMS marker distance that noise alone gives in the plane of bending, or along so many axes [same unit as `noise`]."""
    return float(np.sqrt(axes) * noise)
