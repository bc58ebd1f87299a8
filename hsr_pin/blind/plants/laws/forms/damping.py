"""Creep and damping in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arm import Array
from ..law import Joints, Law, State, drawn, sign, strength, uniform
from .scale import DAMPING, KEQ, moment_scale, scaling


def _branches(times: Array, shares: Array, state: State, memory: Array) -> tuple[Array, Array]:
    """Return the weighted bending (n,) [rad] that Maxwell branches carry, and their relaxed bending after the step, (k, n)."""
    keep = np.zeros((times.size, 1)) if state.rest else np.exp(-state.dt / times)[:, None]
    anchor = state.bend + (memory - state.bend) * keep
    return shares @ (state.bend - anchor), anchor


@dataclass(frozen=True)
class Relaxations(Law, name="viscoelastic", variant="three_times"):
    """Creep with three relaxation times.

    The generalised Maxwell solid (R. M. Christensen, Theory of Viscoelasticity, 2nd ed., 1982, ch. 1).

    ratio: stiffness of the three branches together over K [-]; time: the middle relaxation time [s]; spread: ratio of
    neighbouring times [-]; scale: quantity with which the branches' stiffness scales.
    """

    ratio: float = strength(0.3, limit=3.0)
    time: float = uniform(0.3, 0.7, default=0.4)
    spread: float = uniform(5.0, 9.0, default=6.0)
    scale: str = scaling(default="stiffness")

    def memory(self, joints: Joints) -> Array:
        return np.zeros((3, joints.s.size))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        times = self.time * self.spread ** np.array([-1.0, 0.0, 1.0])
        carried, anchor = _branches(times, np.full(3, 1 / 3), state, memory)
        return self.ratio * moment_scale(self.scale, joints) * carried, anchor


@dataclass(frozen=True)
class PowerLawCreep(Law, name="viscoelastic", variant="power_law"):
    """Creep that follows a power of time without a characteristic time, as in rubber.

    The springpot (F. Mainardi, Fractional Calculus and Waves in Linear Viscoelasticity, Imperial College Press 2010), by
    eight Maxwell branches from 0.02 to 60 s whose stiffness falls with the power `order` of their time.

    ratio: stiffness of all branches together over K [-]; order: 0 to 1 [-]; scale: quantity with which the stiffness scales.
    """

    ratio: float = strength(0.4, limit=4.0)
    order: float = uniform(0.15, 0.4, default=0.3)
    scale: str = scaling("stays", "stiffness", default="stiffness")
    _TIMES: ClassVar[Array] = np.geomspace(0.02, 60.0, 8)

    def memory(self, joints: Joints) -> Array:
        return np.zeros((self._TIMES.size, joints.s.size))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        shares = self._TIMES**-self.order
        carried, anchor = _branches(self._TIMES, shares / shares.sum(), state, memory)
        return self.ratio * moment_scale(self.scale, joints) * carried, anchor


@dataclass(frozen=True)
class PowerDamping(Law, name="quadratic_damping", variant="power"):
    """Damping with an exponent other than two, M = c |b'|^(p - 1) b'.

    Powers of the rate: B. Ravindra, A. K. Mallik, Performance of Non-linear Vibration Isolators under Harmonic Excitation,
    J. Sound Vib. 170, 1994; 1.5 stands for flow between laminar and turbulent.

    coefficient: c at 1 rad/s, over the declared damping at the lower level [-]; power: p; scale: quantity with which c scales.
    """

    coefficient: float = strength(0.1, limit=3.0)
    power: float = 1.5
    scale: str = scaling(default="damping")

    def viscous(self, joints: Joints, state: State) -> Array:
        at_one = self.coefficient * DAMPING / KEQ * moment_scale(self.scale, joints)
        return np.asarray(at_one * np.abs(state.rate) ** (self.power - 1))


@dataclass(frozen=True)
class OneWayDamping(Law, name="quadratic_damping", variant="one_way"):
    """Quadratic damping in one direction only, as if air enters through a wide valve and leaves through a narrow one.

    J. C. Dixon, The Shock Absorber Handbook, 2nd ed., 2007, ch. 6: M = c |b'| b' while b' has the sign of `way`.

    coefficient: c at 1 rad/s, over the declared damping at the lower level [-]; scale: quantity with which c scales.
    """

    coefficient: float = strength(0.1, limit=3.0)
    way: int = drawn(lambda rng: int(sign(rng)), default=1)
    scale: str = scaling(default="damping")

    def viscous(self, joints: Joints, state: State) -> Array:
        at_one = self.coefficient * DAMPING / KEQ * moment_scale(self.scale, joints)
        return np.asarray(at_one * np.maximum(self.way * state.rate, 0.0))


@dataclass(frozen=True)
class CuffDamping(Law, name="damping_gradient", variant="cuff"):
    """Higher damping at one end of the arm by a cuff; the mean over the arm is kept.

    Lumped, non-proportional damping (S. Adhikari, Structural Dynamic Analysis with Generalized Damping Models, Wiley 2014,
    ch. 2).

    excess: C in the cuff over C elsewhere, minus one [-]; reach: length of the cuff over L; end: 0 base, 1 tip.
    """

    excess: float = strength(1.0, limit=30.0)
    reach: float = uniform(0.2, 0.35, default=0.3)
    end: int = drawn(lambda rng: int(rng.integers(2)), default=0)

    def damping(self, s: Array) -> Array:
        inside = np.abs(s - self.end) < self.reach
        return np.where(inside, 1 + self.excess, 1.0) / (1 + self.excess * self.reach)


@dataclass(frozen=True)
class ExponentialDamping(Law, name="damping_gradient", variant="exponential"):
    """Damping that varies exponentially along the arm with a constant mean (S. Adhikari, as above, ch. 2).

    rate: logarithm of C at the tip over C at the base [-].
    """

    rate: float = strength(0.8, limit=5.0, signed=True)

    def damping(self, s: Array) -> Array:
        mean = np.expm1(self.rate) / self.rate if self.rate else 1.0
        return np.asarray(np.exp(self.rate * s) / mean)
