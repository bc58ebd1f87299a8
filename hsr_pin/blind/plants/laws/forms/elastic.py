"""Elastic laws in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arm import Array
from ..law import Joints, Law, State, sign
from .scale import check_scale, drawn_scale, moment_scale

_FINE = (np.arange(400) + 0.5) / 400  # grid for means over the arm, over L


@dataclass(frozen=True)
class TaperedRadius(Law):
    """A radius that varies linearly along the arm, so that EI varies with its fourth power.

    A tapered rod (F. Renda et al., Dynamic Model of a Multibending Soft Robot Arm Driven by Cables, IEEE T-RO 30,
    2014); the series stiffness is kept.

    taper: (radius(tip) - radius(base)) / radius(middle) [-].
    """

    name: ClassVar[str] = "stiffness_gradient"
    variant: ClassVar[str] = "tapered_radius"
    strength: ClassVar[str] = "taper"
    limit: ClassVar[float] = 0.8
    taper: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TaperedRadius:
        return cls(0.12 * sign(rng))

    def stiffness(self, s: Array) -> Array:
        compliance = np.mean((1 + self.taper * (_FINE - 0.5)) ** -4)
        return np.asarray(compliance * (1 + self.taper * (s - 0.5)) ** 4)


@dataclass(frozen=True)
class TwoSections(Law):
    """Two sections of different stiffness; the series stiffness is kept.

    Arms are built of sections (R. J. Webster, B. A. Jones, Design and Kinematic Modeling of Constant Curvature
    Continuum Robots: a Review, IJRR 29, 2010).

    step: logarithm of EI beyond the joint over EI before it [-]; joint: place where they meet, over L.
    """

    name: ClassVar[str] = "stiffness_gradient"
    variant: ClassVar[str] = "two_sections"
    strength: ClassVar[str] = "step"
    limit: ClassVar[float] = 1.6
    step: float = 0.0
    joint: float = 0.5

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TwoSections:
        return cls(0.3 * sign(rng), float(rng.uniform(0.4, 0.6)))

    def stiffness(self, s: Array) -> Array:
        ratio = np.exp(self.step)
        return np.asarray(np.where(s < self.joint, 1.0, ratio) * (self.joint + (1 - self.joint) / ratio))


@dataclass(frozen=True)
class BoxSpot(Law):
    """A softer part with sharp edges, such as a replaced or cut sleeve.

    The stepped beam (H. P. Lee, T. Y. Ng, Vibration and Buckling of a Stepped Beam, Appl. Acoust. 42, 1994).

    depth: relative decrease of EI there [-]; centre, half_width: over L.
    """

    name: ClassVar[str] = "soft_spot"
    variant: ClassVar[str] = "box"
    strength: ClassVar[str] = "depth"
    limit: ClassVar[float] = 0.9
    depth: float = 0.0
    centre: float = 0.5
    half_width: float = 0.08

    @classmethod
    def draw(cls, rng: np.random.Generator) -> BoxSpot:
        return cls(0.4, float(rng.uniform(0.2, 0.75)), float(rng.uniform(0.06, 0.14)))

    def stiffness(self, s: Array) -> Array:
        return np.where(np.abs(s - self.centre) < self.half_width, 1 - self.depth, 1.0)


@dataclass(frozen=True)
class CrackedSpot(Law):
    """A crack whose compliance decays exponentially on both sides.

    S. Christides, A. D. S. Barr, One-Dimensional Theory of Cracked Bernoulli-Euler Beams, Int. J. Mech. Sci. 26, 1984.

    depth: 1/EI grows by depth/(1 - depth) at the crack [-]; centre, reach: over L.
    """

    name: ClassVar[str] = "soft_spot"
    variant: ClassVar[str] = "crack"
    strength: ClassVar[str] = "depth"
    limit: ClassVar[float] = 0.93
    depth: float = 0.0
    centre: float = 0.5
    reach: float = 0.06

    @classmethod
    def draw(cls, rng: np.random.Generator) -> CrackedSpot:
        return cls(0.5, float(rng.uniform(0.15, 0.7)), float(rng.uniform(0.04, 0.08)))

    def stiffness(self, s: Array) -> Array:
        return np.asarray(1 / (1 + self.depth / (1 - self.depth) * np.exp(-np.abs(s - self.centre) / self.reach)))


@dataclass(frozen=True)
class Quintic(Law):
    """A spring with a fifth-power term, M = K b (1 + e b^4) (I. Kovacic, M. J. Brennan, The Duffing Equation, Wiley 2011, ch. 2).

    quintic: e [1/rad4]; scale: quantity with which the fifth-power term scales.
    """

    name: ClassVar[str] = "stiffening"
    variant: ClassVar[str] = "quintic"
    strength: ClassVar[str] = "quintic"
    limit: ClassVar[float] = 0.6
    quintic: float = 0.0
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Quintic:
        return cls(0.03, drawn_scale(rng, "stays", "stiffness"))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return self.quintic * moment_scale(self.scale, joints) * state.bend**5, memory


@dataclass(frozen=True)
class Saturating(Law):
    """Stiffening that levels off, M = K b (1 + g x^2 / (1 + x^2)), x = b / b0.

    The fibres of the braid become straight (G. A. Holzapfel, Nonlinear Solid Mechanics, Wiley 2000, ch. 6).

    gain: g [-]; knee: b0 [rad]; scale: quantity with which the gain scales.
    """

    name: ClassVar[str] = "stiffening"
    variant: ClassVar[str] = "saturating"
    strength: ClassVar[str] = "gain"
    limit: ClassVar[float] = 4.0
    gain: float = 0.0
    knee: float = 0.6
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Saturating:
        return cls(0.2, float(rng.uniform(0.4, 0.9)), drawn_scale(rng, "stays", "stiffness"))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        x2 = (state.bend / self.knee) ** 2
        return self.gain * moment_scale(self.scale, joints) * state.bend * x2 / (1 + x2), memory


@dataclass(frozen=True)
class ImpactStop(Law):
    """A stop with a dissipative force that grows with the power 1.5.

    K. H. Hunt, F. R. E. Crossley, Coefficient of Restitution Interpreted as Damping in Vibroimpact, J. Appl. Mech. 42,
    1975: M = K r d^1.5 (1 + a d') for d > 0 beyond the angle, on both sides; it never pulls.

    ratio: r [rad^-0.5]; angle: [rad]; loss: a [s/rad].
    """

    name: ClassVar[str] = "bending_stop"
    variant: ClassVar[str] = "impact"
    strength: ClassVar[str] = "ratio"
    limit: ClassVar[float] = 40.0
    ratio: float = 0.0
    angle: float = 0.6
    loss: float = 0.1

    @classmethod
    def draw(cls, rng: np.random.Generator) -> ImpactStop:
        return cls(1.5, float(rng.uniform(0.3, 0.65)), float(rng.uniform(0.02, 0.15)))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        side = np.sign(state.bend)
        depth = np.maximum(np.abs(state.bend) - self.angle, 0.0)
        push = np.maximum(1 + self.loss * side * state.rate, 0.0)
        return self.ratio * joints.stiffness * side * depth**1.5 * push, memory


@dataclass(frozen=True)
class GradualStop(Law):
    """A stop on one side that sets in over a range of angles, because the links lock one after the other.

    Piecewise linear with a spread of thresholds (W. D. Iwan, A Distributed-Element Model for Hysteresis, J. Appl. Mech.
    33, 1966, taken as an elastic one): M = K r w log(1 + exp((b - angle) / w)).

    ratio: r [-]; angle: [rad], towards `side`; spread: w [rad].
    """

    name: ClassVar[str] = "bending_stop"
    variant: ClassVar[str] = "gradual"
    strength: ClassVar[str] = "ratio"
    limit: ClassVar[float] = 20.0
    ratio: float = 0.0
    angle: float = 0.6
    spread: float = 0.05
    side: int = 1

    @classmethod
    def draw(cls, rng: np.random.Generator) -> GradualStop:
        return cls(0.6, float(rng.uniform(0.35, 0.7)), float(rng.uniform(0.04, 0.1)))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        beyond = self.spread * np.logaddexp(0.0, (self.side * state.bend - self.angle) / self.spread)
        return self.side * self.ratio * joints.stiffness * beyond, memory


@dataclass(frozen=True)
class SmoothPlay(Law):
    """Play with smooth edges, M = -K g/2 tanh(2 b / g).

    A smooth dead zone (R. Merzouki et al., Backlash Phenomenon Observation and Identification in Electromechanical
    System, Control Eng. Pract. 15, 2007).

    gap: g, in bending of the whole arm [rad].
    """

    name: ClassVar[str] = "backlash"
    variant: ClassVar[str] = "smooth"
    strength: ClassVar[str] = "gap"
    limit: ClassVar[float] = 0.8
    gap: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> SmoothPlay:
        return cls(0.1)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        half = max(self.gap / 2, 1e-9)
        return -joints.stiffness * half * np.tanh(state.bend / half), memory


@dataclass(frozen=True)
class LocalPlay(Law):
    """Play in a few worn links only (M. Nordin, P.-O. Gutman, Controlling Mechanical Systems with Backlash, Automatica 38, 2002).

    gap: play of the worn part, in bending of the whole arm [rad]; centre, half_width: place of the worn part, over L.
    """

    name: ClassVar[str] = "backlash"
    variant: ClassVar[str] = "local"
    strength: ClassVar[str] = "gap"
    limit: ClassVar[float] = 1.6
    gap: float = 0.0
    centre: float = 0.3
    half_width: float = 0.25

    @classmethod
    def draw(cls, rng: np.random.Generator) -> LocalPlay:
        return cls(0.25, float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.15, 0.3)))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        worn = np.abs(joints.s - self.centre) < self.half_width
        return -joints.stiffness * np.clip(state.bend, -self.gap / 2, self.gap / 2) * worn, memory
