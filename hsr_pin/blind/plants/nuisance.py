"""Small errors that every recording has: wrong parameters, noise, and effects too small to be seen alone."""

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
        k: true stiffness relative to the declared one [-].
        c: true damping relative to the declared one [-].
        noise: standard deviation of the marker noise for each axis [m].
        placement: standard deviation of the true marker places, along and off the arm [m].
        lag: tiny actuator lag [s].
        tilt: tiny tilt of the base [rad].
        bias: tiny torque bias [N m].
        extra: tiny additional mass at the tip [kg].
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
        """Draw errors: stiffness within 15 %, damping within 30 %, noise of 0.3 to 0.5 mm, other effects far below it."""
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
        """Return the tiny effects as laws."""
        return (
            actuation.ActuatorLag(self.lag),
            actuation.TorqueBias(self.bias),
            mounting.GravityTilt(self.tilt),
            mounting.TipMass(self.extra),
        )

    def describe(self) -> dict[str, Any]:
        """Return the errors for an answer file."""
        return asdict(self)


def noise_floor(noise: float, axes: int = 2) -> float:
    """Return the RMS marker distance due to noise alone, along two or more axes [same unit as `noise`]."""
    return float(np.sqrt(axes) * noise)
