"""Laws that exist in space only, and laws of the catalogue that need another form for two axes; moments are complex, x + i y.

Laws that scale moments, masses or time (gradients, lags, creep, payloads) are the same as in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arm import Arm, Array
from ..laws import actuation, dissipative, elastic, mounting, outside
from ..laws.law import Joints, Law, State, strength, uniform
from ..program import Trial


@dataclass(frozen=True)
class Directional(Law):
    """A law with its own direction ``side``, from x towards y [rad]."""

    side: float = uniform(-np.pi, np.pi, default=0.0, kw_only=True)

    @property
    def vector(self) -> complex:
        """Strength times direction, x + i y."""
        return complex(getattr(self, self.strength) * np.exp(1j * self.side))


def _limited(z: Array, longest: Any) -> Array:
    return np.asarray(z * np.minimum(1.0, longest / np.maximum(np.abs(z), 1e-12)))


@dataclass(frozen=True)
class UnequalStiffness(Directional, name="unequal_stiffness"):
    """A flat section: stiffer by `share` about one axis, softer by `share` about the other; side: the stiff direction [rad]."""

    share: float = strength(0.1, limit=0.5)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        along = state.bend * np.exp(-1j * self.side)
        return joints.stiffness * self.share * (along.real - 1j * along.imag) * np.exp(1j * self.side), memory


@dataclass(frozen=True)
class BendAtRest(Directional, name="bend_at_rest"):
    """A moulded bend: the springs pull towards a bend of `angle` [rad] in the direction `side` [rad], fixed in the arm."""

    angle: float = strength(0.05, limit=1.0)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return -joints.stiffness * self.vector + 0 * state.bend, memory  # type: ignore[return-value]


@dataclass(frozen=True)
class TurnedActuation(Law, name="turned_actuation"):
    """Actuators mounted with a rotation about the arm by `angle` [rad]."""

    angle: float = strength(0.08, limit=1.2, signed=True)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return np.asarray(tau * np.exp(1j * self.angle))


@dataclass(frozen=True)
class WeakChamber(Directional, name="weak_chamber"):
    """A weak chamber: one of three chambers at 120 degrees, at `side` [rad], gives `loss` less [-].

    At any instant one of the chambers is empty.
    """

    loss: float = strength(0.15, limit=0.9)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        ways = np.exp(1j * (self.side + 2 * np.pi / 3 * np.arange(3)))
        given = np.linalg.lstsq(np.array([ways.real, ways.imag]), np.array([np.real(tau), np.imag(tau)]), rcond=None)[0]
        given -= given.min(axis=0)  # the smallest pressures that give the torque
        given[0] *= 1 - self.loss
        return np.asarray(ways @ given)


@dataclass(frozen=True)
class TorqueOffset(Directional, name="torque_offset"):
    """A constant moment `bias` [N m] in the direction `side` [rad]."""

    bias: float = strength(0.05, limit=0.5)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return np.asarray(tau + self.vector)


@dataclass(frozen=True)
class BaseTilt(Directional, name="base_tilt"):
    """A base tilted by `angle` in the direction `side` [rad]; the markers show the tilt."""

    angle: float = strength(0.05, limit=0.5)

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tilt=arm.tilt + self.vector.real, side_tilt=arm.side_tilt + self.vector.imag)  # type: ignore[call-arg, attr-defined]


@dataclass(frozen=True)
class MarkersBeside(Directional, name="markers_beside"):
    """Marker plates: all markers except the one at the base are `distance` [m] off the line, in the direction `side` [rad]."""

    distance: float = strength(0.004, limit=0.03)

    @property
    def beside(self) -> complex:
        """Offset of the markers from the line, x + i y [m]."""
        return self.vector


@dataclass(frozen=True)
class CrossCoupling(Law, name="cross_coupling"):
    """Coupling of bending to the perpendicular axis: M = i `gain` K b, which no spring has, but a tensioned helix may have."""

    gain: float = strength(0.1, limit=0.5, signed=True)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return 1j * self.gain * joints.stiffness * state.bend, memory  # type: ignore[return-value]


class Stiffening(elastic.Stiffening):
    """Cubic spring along the direction of bending: ``M = K beta |b|^2 b``."""

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return joints.stiffness * self.cubic * np.abs(state.bend) ** 2 * state.bend, memory


class DryFriction(dissipative.DryFriction):
    """Friction by a bristle that bends in any direction up to its slip length (the vector form of Prandtl's element)."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> DryFriction:
        return cls(0.05, "prandtl")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = _limited(memory + state.rate * state.dt, self.bristle)
        return self.level * joints.keq / self.bristle * z, z


class Hysteresis(dissipative.Hysteresis):
    """Hysteresis by five parallel friction elements with different slip lengths (Iwan)."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Hysteresis:
        return cls(0.3, float(rng.uniform(0.08, 0.3)), form="iwan")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        slip = _limited(memory + state.rate * state.dt, self.yield_angle * self._SPREAD[:, None])
        return self.amplitude * joints.keq * slip.mean(axis=0), slip


#: Name -> law; soft spots, gradients, creep, damping, lags and masses are the same as in the plane.
CATALOGUE: dict[str, type[Law]] = {
    law.name: law
    for law in (
        actuation.ActuatorLag,
        mounting.AddedMass,
        BaseTilt,
        BendAtRest,
        dissipative.DampingGradient,
        actuation.DeadTime,
        DryFriction,
        Hysteresis,
        MarkersBeside,
        dissipative.QuadraticDamping,
        elastic.SoftSpot,
        Stiffening,
        elastic.StiffnessGradient,
        mounting.TipMass,
        actuation.TorqueDecay,
        TorqueOffset,
        TurnedActuation,
        UnequalStiffness,
        dissipative.Viscoelastic,
        WeakChamber,
    )
}

#: Name -> law outside the catalogue.
OUTSIDE: dict[str, type[Law]] = {
    law.name: law for law in (CrossCoupling, outside.PulsingStiffness, outside.SupplyRipple, outside.WarmingArm)
}
