"""Elastic laws in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arm import Array
from ..law import Joints, Law, State, strength, uniform
from .scale import moment_scale, scaling

_FINE = (np.arange(400) + 0.5) / 400  # grid for means over the arm, over L


@dataclass(frozen=True)
class TaperedRadius(Law, name="stiffness_gradient", variant="tapered_radius"):
    """A radius that varies linearly along the arm, so that EI varies with its fourth power.

    A tapered rod (F. Renda et al., Dynamic Model of a Multibending Soft Robot Arm Driven by Cables, IEEE T-RO 30,
    2014); the series stiffness is kept.

    taper: (radius(tip) - radius(base)) / radius(middle) [-].
    """

    taper: float = strength(0.12, limit=0.8, signed=True)

    def stiffness(self, s: Array) -> Array:
        compliance = np.mean((1 + self.taper * (_FINE - 0.5)) ** -4)
        return np.asarray(compliance * (1 + self.taper * (s - 0.5)) ** 4)


@dataclass(frozen=True)
class TwoSections(Law, name="stiffness_gradient", variant="two_sections"):
    """Two sections of different stiffness; the series stiffness is kept.

    Arms are built of sections (R. J. Webster, B. A. Jones, Design and Kinematic Modeling of Constant Curvature
    Continuum Robots: a Review, IJRR 29, 2010).

    step: logarithm of EI beyond the joint over EI before it [-]; joint: place where they meet, over L.
    """

    step: float = strength(0.3, limit=1.6, signed=True)
    joint: float = uniform(0.4, 0.6, default=0.5)

    def stiffness(self, s: Array) -> Array:
        ratio = np.exp(self.step)
        return np.asarray(np.where(s < self.joint, 1.0, ratio) * (self.joint + (1 - self.joint) / ratio))


@dataclass(frozen=True)
class BoxSpot(Law, name="soft_spot", variant="box"):
    """A softer part with sharp edges, such as a replaced or cut sleeve.

    The stepped beam (H. P. Lee, T. Y. Ng, Vibration and Buckling of a Stepped Beam, Appl. Acoust. 42, 1994).

    depth: relative decrease of EI there [-]; centre, half_width: over L.
    """

    depth: float = strength(0.4, limit=0.9)
    centre: float = uniform(0.2, 0.75, default=0.5)
    half_width: float = uniform(0.06, 0.14, default=0.08)

    def stiffness(self, s: Array) -> Array:
        return np.where(np.abs(s - self.centre) < self.half_width, 1 - self.depth, 1.0)


@dataclass(frozen=True)
class CrackedSpot(Law, name="soft_spot", variant="crack"):
    """A crack whose compliance decays exponentially on both sides.

    S. Christides, A. D. S. Barr, One-Dimensional Theory of Cracked Bernoulli-Euler Beams, Int. J. Mech. Sci. 26, 1984.

    depth: 1/EI grows by depth/(1 - depth) at the crack [-]; centre, reach: over L.
    """

    depth: float = strength(0.5, limit=0.93)
    centre: float = uniform(0.15, 0.7, default=0.5)
    reach: float = uniform(0.04, 0.08, default=0.06)

    def stiffness(self, s: Array) -> Array:
        return np.asarray(1 / (1 + self.depth / (1 - self.depth) * np.exp(-np.abs(s - self.centre) / self.reach)))


@dataclass(frozen=True)
class Quintic(Law, name="stiffening", variant="quintic"):
    """A spring with a fifth-power term, M = K b (1 + e b^4) (I. Kovacic, M. J. Brennan, The Duffing Equation, Wiley 2011, ch. 2).

    quintic: e [1/rad4]; scale: quantity with which the fifth-power term scales.
    """

    quintic: float = strength(0.03, limit=0.6)
    scale: str = scaling("stays", "stiffness", default="stiffness")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return self.quintic * moment_scale(self.scale, joints) * state.bend**5, memory


@dataclass(frozen=True)
class Saturating(Law, name="stiffening", variant="saturating"):
    """Stiffening that levels off, M = K b (1 + g x^2 / (1 + x^2)), x = b / b0.

    The fibres of the braid become straight (G. A. Holzapfel, Nonlinear Solid Mechanics, Wiley 2000, ch. 6).

    gain: g [-]; knee: b0 [rad]; scale: quantity with which the gain scales.
    """

    gain: float = strength(0.2, limit=4.0)
    knee: float = uniform(0.4, 0.9, default=0.6)
    scale: str = scaling("stays", "stiffness", default="stiffness")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        x2 = (state.bend / self.knee) ** 2
        return self.gain * moment_scale(self.scale, joints) * state.bend * x2 / (1 + x2), memory


@dataclass(frozen=True)
class ImpactStop(Law, name="bending_stop", variant="impact"):
    """A stop with a dissipative force that grows with the power 1.5.

    K. H. Hunt, F. R. E. Crossley, Coefficient of Restitution Interpreted as Damping in Vibroimpact, J. Appl. Mech. 42,
    1975: M = K r d^1.5 (1 + a d') for d > 0 beyond the angle, on both sides; it never pulls.

    ratio: r [rad^-0.5]; angle: [rad]; loss: a [s/rad].
    """

    ratio: float = strength(1.5, limit=40.0)
    angle: float = uniform(0.3, 0.65, default=0.6)
    loss: float = uniform(0.02, 0.15, default=0.1)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        side = np.sign(state.bend)
        depth = np.maximum(np.abs(state.bend) - self.angle, 0.0)
        push = np.maximum(1 + self.loss * side * state.rate, 0.0)
        return self.ratio * joints.stiffness * side * depth**1.5 * push, memory


@dataclass(frozen=True)
class GradualStop(Law, name="bending_stop", variant="gradual"):
    """A stop on one side that sets in over a range of angles, because the links lock one after the other.

    Piecewise linear with a spread of thresholds (W. D. Iwan, A Distributed-Element Model for Hysteresis, J. Appl. Mech.
    33, 1966, taken as an elastic one): M = K r w log(1 + exp((b - angle) / w)).

    ratio: r [-]; angle: [rad], towards `side`; spread: w [rad].
    """

    ratio: float = strength(0.6, limit=20.0)
    angle: float = uniform(0.35, 0.7, default=0.6)
    spread: float = uniform(0.04, 0.1, default=0.05)
    side: int = 1

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        beyond = self.spread * np.logaddexp(0.0, (self.side * state.bend - self.angle) / self.spread)
        return self.side * self.ratio * joints.stiffness * beyond, memory


@dataclass(frozen=True)
class SmoothPlay(Law, name="backlash", variant="smooth"):
    """Play with smooth edges, M = -K g/2 tanh(2 b / g).

    A smooth dead zone (R. Merzouki et al., Backlash Phenomenon Observation and Identification in Electromechanical
    System, Control Eng. Pract. 15, 2007).

    gap: g, in bending of the whole arm [rad].
    """

    gap: float = strength(0.1, limit=0.8)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        half = max(self.gap / 2, 1e-9)
        return -joints.stiffness * half * np.tanh(state.bend / half), memory


@dataclass(frozen=True)
class LocalPlay(Law, name="backlash", variant="local"):
    """Play in a few worn links only (M. Nordin, P.-O. Gutman, Controlling Mechanical Systems with Backlash, Automatica 38, 2002).

    gap: play of the worn part, in bending of the whole arm [rad]; centre, half_width: place of the worn part, over L.
    """

    gap: float = strength(0.25, limit=1.6)
    centre: float = uniform(0.2, 0.6, default=0.3)
    half_width: float = uniform(0.15, 0.3, default=0.25)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        worn = np.abs(joints.s - self.centre) < self.half_width
        return -joints.stiffness * np.clip(state.bend, -self.gap / 2, self.gap / 2) * worn, memory
