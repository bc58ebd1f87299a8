"""Laws of space alone, and those of the catalogue that need another form about two axes; all moments are complex, x + i y.

Those that scale moments, masses or time (gradients, lags, creep, payloads) are as they are in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..arm import Arm, Array
from ..laws import actuation, dissipative, elastic, mounting, outside
from ..laws.law import Joints, Law, State, sign
from ..program import Trial

AnySided = TypeVar("AnySided", bound="Sided")


@dataclass(frozen=True)
class Sided(Law):
    """A law with a direction of its own; ``usual`` is a moderate strength. side: from x towards y [rad]."""

    usual: ClassVar[float]
    side: float = field(default=0.0, kw_only=True)

    @classmethod
    def draw(cls: type[AnySided], rng: np.random.Generator) -> AnySided:
        return cls(**{cls.strength: cls.usual, "side": float(rng.uniform(-np.pi, np.pi))})

    @property
    def way(self) -> complex:
        """The strength towards the side, x + i y."""
        return complex(getattr(self, self.strength) * np.exp(1j * self.side))


def _limited(z: Array, longest: Any) -> Array:
    return np.asarray(z * np.minimum(1.0, longest / np.maximum(np.abs(z), 1e-12)))


@dataclass(frozen=True)
class UnequalStiffness(Sided):
    """Stiffer by `share` about one axis, softer by it about the other: a flat section. side: the stiff direction [rad]."""

    name: ClassVar[str] = "unequal_stiffness"
    strength: ClassVar[str] = "share"
    limit: ClassVar[float] = 0.5
    usual: ClassVar[float] = 0.1
    share: float = 0.0

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        along = state.bend * np.exp(-1j * self.side)
        return joints.stiffness * self.share * (along.real - 1j * along.imag) * np.exp(1j * self.side), memory


@dataclass(frozen=True)
class BendAtRest(Sided):
    """Moulded bent: the springs pull towards a bend of `angle` [rad] to one `side` [rad], fixed in the arm."""

    name: ClassVar[str] = "bend_at_rest"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 1.0
    usual: ClassVar[float] = 0.05
    angle: float = 0.0

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return -joints.stiffness * self.way + 0 * state.bend, memory  # type: ignore[return-value]


@dataclass(frozen=True)
class TurnedActuation(Law):
    """Muscles mounted turned about the arm by `angle` [rad]."""

    name: ClassVar[str] = "turned_actuation"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 1.2
    angle: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TurnedActuation:
        return cls(0.08 * sign(rng))

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return np.asarray(tau * np.exp(1j * self.angle))


@dataclass(frozen=True)
class WeakChamber(Sided):
    """One of three chambers at 120 degrees, at `side` [rad], gives `loss` less [-]; at any instant one of them is empty."""

    name: ClassVar[str] = "weak_chamber"
    strength: ClassVar[str] = "loss"
    limit: ClassVar[float] = 0.9
    usual: ClassVar[float] = 0.15
    loss: float = 0.0

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        ways = np.exp(1j * (self.side + 2 * np.pi / 3 * np.arange(3)))
        given = np.linalg.lstsq(np.array([ways.real, ways.imag]), np.array([np.real(tau), np.imag(tau)]), rcond=None)[0]
        given -= given.min(axis=0)  # the least pressures that make the torque
        given[0] *= 1 - self.loss
        return np.asarray(ways @ given)


@dataclass(frozen=True)
class TorqueOffset(Sided):
    """A constant moment `bias` [N m] towards one `side` [rad]."""

    name: ClassVar[str] = "torque_offset"
    strength: ClassVar[str] = "bias"
    limit: ClassVar[float] = 0.5
    usual: ClassVar[float] = 0.05
    bias: float = 0.0

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return np.asarray(tau + self.way)


@dataclass(frozen=True)
class BaseTilt(Sided):
    """The base is mounted turned by `angle` towards one `side` [rad], as the markers show."""

    name: ClassVar[str] = "base_tilt"
    strength: ClassVar[str] = "angle"
    limit: ClassVar[float] = 0.5
    usual: ClassVar[float] = 0.05
    angle: float = 0.0

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, tilt=arm.tilt + self.way.real, side_tilt=arm.side_tilt + self.way.imag)  # type: ignore[call-arg, attr-defined]


@dataclass(frozen=True)
class MarkersBeside(Sided):
    """Marker plates: all markers but the base's sit `distance` [m] off the line to one `side` [rad]."""

    name: ClassVar[str] = "markers_beside"
    strength: ClassVar[str] = "distance"
    limit: ClassVar[float] = 0.03
    usual: ClassVar[float] = 0.004
    distance: float = 0.0

    @property
    def beside(self) -> complex:
        """From the line, x + i y [m]."""
        return self.way


@dataclass(frozen=True)
class CrossCoupling(Law):
    """Bending to one side drives the arm to the next: M = i `gain` K b, which no spring does, but a helix that is pulled may."""

    name: ClassVar[str] = "cross_coupling"
    strength: ClassVar[str] = "gain"
    limit: ClassVar[float] = 0.5
    gain: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> CrossCoupling:
        return cls(0.1 * sign(rng))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return 1j * self.gain * joints.stiffness * state.bend, memory  # type: ignore[return-value]


class Stiffening(elastic.Stiffening):
    """Along the bending, with its length: M = K |b|^2 b beta."""

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return joints.stiffness * self.cubic * np.abs(state.bend) ** 2 * state.bend, memory


class DryFriction(dissipative.DryFriction):
    """A bristle that bends to any side until its length is that of slip (the vector form of Prandtl's element)."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> DryFriction:
        return cls(0.05, "prandtl")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = _limited(memory + state.rate * state.dt, self.bristle)
        return self.level * joints.keq / self.bristle * z, z


class Hysteresis(dissipative.Hysteresis):
    """Five such elements beside one another (Iwan)."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Hysteresis:
        return cls(0.3, float(rng.uniform(0.08, 0.3)), form="iwan")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        slip = _limited(memory + state.rate * state.dt, self.yield_angle * self._SPREAD[:, None])
        return self.amplitude * joints.keq * slip.mean(axis=0), slip


#: Name -> law. Soft spots, gradients, creep, damping, lags and masses as in the plane.
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

#: Name -> law that no model has.
OUTSIDE: dict[str, type[Law]] = {
    law.name: law for law in (CrossCoupling, outside.PulsingStiffness, outside.SupplyRipple, outside.WarmingArm)
}
