"""Laws of friction, hysteresis, creep and damping."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..arm import Array
from .law import Joints, Law, Nodes, State, bristle, one_of, slider, strength, uniform


@dataclass(frozen=True)
class DryFriction(Law, name="dry_friction"):
    """Coulomb friction with sticking, the same moment in every joint.

    form ``lugre``: bristles without micro-damping, z' = v - |v| z / z_c(v), M = M_c z / z_0 (C. Canudas de
    Wit et al., A New Model for Control of Systems with Friction, IEEE TAC 40, 1995); ``prandtl``: a spring
    and a slider in series, M = M_c clip(z / z_0) (L. Prandtl, ZAMM 8, 1928; one Jenkin element). MuJoCo's
    own frictionloss is not used: it is regularised, and creeps on links as light as these.

    level: Coulomb moment over Keq [rad]; bristle: z_0, bending before slip [rad]; breakaway: static over
    kinetic friction; stribeck: rate at which the excess fades [rad/s]; the last two only for ``lugre``.
    """

    level: float = strength(0.05, limit=0.6)
    form: str = one_of("lugre", "prandtl")
    bristle: float = 0.004
    breakaway: float = uniform(1.0, 1.15, default=1.0)
    stribeck: float = 0.1

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        if self.form == "prandtl":
            z = slider(memory, state, self.bristle)
        else:
            excess = (self.breakaway - 1) * np.exp(-((state.rate / self.stribeck) ** 2))
            z = bristle(memory, state, self.bristle * (1 + excess))
        return self.level * joints.keq / self.bristle * z, z


@dataclass(frozen=True)
class Hysteresis(Law, name="hysteresis"):
    """Smooth rate-independent hysteresis loop.

    form ``bouc_wen``: z' = v (1 - |z|^n (1 + sgn(v z)) / 2) / b_y, M = A Keq b_y z (Y.-K. Wen, Method for
    Random Vibration of Hysteretic Systems, J. Eng. Mech. Div. ASCE 102, 1976); ``iwan``: five Jenkin
    elements whose yield angles are spread about b_y (W. D. Iwan, A Distributed-Element Model for
    Hysteresis, J. Appl. Mech. 33, 1966), as Maxwell-slip models of pneumatic muscles have (T. Vo-Minh et
    al., IEEE/ASME T-Mech. 16, 2011).

    amplitude: stiffness of the loop over Keq [-]; yield_angle: b_y [rad]; exponent: n [-].
    """

    amplitude: float = strength(0.3, limit=4.0)
    yield_angle: float = uniform(0.08, 0.3, default=0.15)
    exponent: float = 1.0
    form: str = one_of("bouc_wen", "iwan")
    _SPREAD: ClassVar[Array] = np.array([0.4, 0.7, 1.0, 1.3, 1.6])

    def memory(self, joints: Joints) -> Array:
        return np.zeros((self._SPREAD.size if self.form == "iwan" else 1, joints.s.size))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        stretch = state.rate * state.dt
        scale = self.amplitude * joints.keq
        if self.form == "iwan":
            top = self.yield_angle * self._SPREAD[:, None]
            slip = np.clip(memory + stretch, -top, top)
            return scale * slip.mean(axis=0), slip
        z = memory[0]
        gain = 1 - np.abs(z) ** self.exponent * (1 + np.sign(stretch * z)) / 2
        z = np.clip(z + stretch * gain / self.yield_angle, -1.0, 1.0)
        return scale * self.yield_angle * z, z[None]


@dataclass(frozen=True)
class Viscoelastic(Law, name="viscoelastic"):
    """Creep and relaxation by a Maxwell branch in parallel with the spring.

    This is the standard linear solid (J. C. Simo, T. J. R. Hughes, Computational Inelasticity, Springer 1998, sec. 10.2, with its
    exact recursion).

    ratio: stiffness of the branch over K [-]; time: relaxation time [s].
    """

    ratio: float = strength(0.3, limit=3.0)
    time: float = uniform(0.25, 1.2, default=0.5)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        # `memory` is the bending at which the branch is relaxed; while the arm settles, the branch relaxes completely.
        keep = 0.0 if state.rest else np.exp(-state.dt / self.time)
        anchor = state.bend + (memory - state.bend) * keep
        return self.ratio * joints.stiffness * (state.bend - anchor), anchor


@dataclass(frozen=True)
class QuadraticDamping(Law, name="quadratic_damping"):
    """Damping that grows with the square of the rate.

    form ``joint``: M = c2 |b'| b' in every joint, fluid pressed through the muscles (Nayfeh, Mook,
    Nonlinear Oscillations, 1979, sec. 3.3); ``drag``: c2 is the coefficient of a drag on the moving
    sections, f = -c2 |v_n| v_n / L^4 per length (J. R. Morison et al., J. Petrol. Tech. 2, 1950).

    coefficient: c2 [Nm s2/rad2].
    """

    coefficient: float = strength(0.005, limit=0.1)
    form: str = field(default="joint", metadata={"choices": ("joint", "drag")})
    length: float = 0.24  # m, used by ``drag`` only

    def acts(self, place: str) -> bool:
        other_form = "force" if self.form == "joint" else "viscous"
        return place != other_form and super().acts(place)

    def viscous(self, joints: Joints, state: State) -> Array:
        return np.asarray(self.coefficient * np.abs(state.rate))

    def force(self, state: State, nodes: Nodes) -> Array:
        normal = np.stack([np.cos(nodes.angle), -np.sin(nodes.angle)])
        v = np.sum(normal * nodes.velocity, axis=0)
        share = np.full(v.size, self.length / (v.size - 1))
        share[[0, -1]] /= 2
        return np.asarray(-self.coefficient / self.length**4 * share * np.abs(v) * v * normal)


@dataclass(frozen=True)
class DampingGradient(Law, name="damping_gradient"):
    """Damping that varies along the arm.

    Damping varies linearly from base to tip with a constant mean: non-proportional damping (S. Adhikari, Structural Dynamic
    Analysis with Generalized Damping Models, Wiley 2014, ch. 2).

    slope: (C(tip) - C(base)) / C(middle) [-].
    """

    slope: float = strength(0.6, limit=1.9, signed=True)

    def damping(self, s: Array) -> Array:
        return 1 + self.slope * (s - 0.5)
