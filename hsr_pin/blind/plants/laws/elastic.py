"""Laws of the elastic moment."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm import Array
from .law import Joints, Law, State, strength, uniform


@dataclass(frozen=True)
class StiffnessGradient(Law, name="stiffness_gradient"):
    """Stiffness that varies along the arm.

    EI varies linearly from base to tip, as in a tapered rod (F. Renda et al., Dynamic Model of a Multibending Soft Robot Arm
    Driven by Cables, IEEE T-RO 30, 2014); the series stiffness is kept.

    slope: (EI(tip) - EI(base)) / EI(middle) [-].
    """

    slope: float = strength(0.4, limit=1.6, signed=True)

    def stiffness(self, s: Array) -> Array:
        a = self.slope
        compliance = np.log((2 + a) / (2 - a)) / a if a else 1.0  # mean over the arm of 1 / (1 + a (s - 1/2))
        return np.asarray(compliance * (1 + a * (s - 0.5)))


@dataclass(frozen=True)
class SoftSpot(Law, name="soft_spot"):
    """A part of the arm that is softer or stiffer.

    A defect as an added local compliance, the rotational spring of a cracked beam smeared over a
    stretch (A. D. Dimarogonas, Vibration of Cracked Structures, Eng. Fract. Mech. 55, 1996).

    centre: over L [-]; depth: 1/EI grows by depth/(1 - depth) at the centre, so EI falls by `depth`
    there (negative: stiffer) [-]; width: standard deviation over L [-].
    """

    centre: float = uniform(0.15, 0.75, default=0.5)
    depth: float = strength(0.4, limit=0.9)
    width: float = uniform(0.04, 0.1, default=0.06)

    def stiffness(self, s: Array) -> Array:
        bump = np.exp(-(((s - self.centre) / self.width) ** 2) / 2)
        return np.asarray(1 / (1 + self.depth / (1 - self.depth) * bump))


@dataclass(frozen=True)
class Stiffening(Law, name="stiffening"):
    """Stiffness that grows or falls with bending.

    Cubic (Duffing) spring, M = K b (1 + beta b^2), b the local bending (A. H. Nayfeh, D. T. Mook,
    Nonlinear Oscillations, Wiley 1979, ch. 4).

    cubic: beta [1/rad2].
    """

    cubic: float = strength(0.05, limit=1.0)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Stiffening:
        # Softening is kept mild: the moment has a peak at b^2 = 1/(3 |beta|), beyond which the arm folds.
        return cls(0.05 * (1 if rng.random() < 0.75 else -1))

    def scaled(self, factor: float) -> Stiffening:
        return replace(self, cubic=float(np.clip(self.cubic * factor, -0.06, self.limit)))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return joints.stiffness * self.cubic * state.bend**3, memory


@dataclass(frozen=True)
class BendingStop(Law, name="bending_stop"):
    """Stiffness that jumps beyond an angle.

    Piecewise linear elastic stops, on both sides (S. W. Shaw, P. J. Holmes, A Periodically Forced
    Piecewise Linear Oscillator, J. Sound Vib. 90, 1983).

    angle: bending at which the links lock [rad]; ratio: stiffness of the stop over K [-].
    """

    angle: float = uniform(0.35, 0.75, default=0.6)
    ratio: float = strength(0.5, limit=30.0)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        beyond = state.bend - np.clip(state.bend, -self.angle, self.angle)
        return self.ratio * joints.stiffness * beyond, memory


@dataclass(frozen=True)
class Backlash(Law, name="backlash"):
    """Play between links.

    Dead-zone spring: no elastic moment while |b| <= gap / 2 (M. Nordin, P.-O. Gutman, Controlling
    Mechanical Systems with Backlash, a Survey, Automatica 38, 2002, eq. (3)); the damper acts throughout.

    gap: width of the dead zone, in bending of the whole arm [rad].
    """

    gap: float = strength(0.1, limit=0.8)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        return -joints.stiffness * np.clip(state.bend, -self.gap / 2, self.gap / 2), memory
