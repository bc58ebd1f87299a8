"""Friction and hysteresis in forms that differ from the catalogue's, all of them rate-independent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arm import Array
from ..law import Joints, Law, State, bristle, slider, strength, uniform
from .scale import moment_scale, scaling


@dataclass(frozen=True)
class StribeckFriction(Law, name="dry_friction", variant="stribeck"):
    """Friction that falls with the sliding rate, which causes stick-slip.

    The Stribeck curve in LuGre's bristles (C. Canudas de Wit et al., A New Model for Control of Systems with Friction,
    IEEE TAC 40, 1995): from `breakaway` times the level down to the level within about `stribeck` [rad/s].

    level: moment over Keq when sliding [rad]; bristle: bending before slip [rad]; scale: quantity with which the level scales.
    """

    level: float = strength(0.04, limit=0.5)
    breakaway: float = uniform(1.3, 1.8, default=1.6)
    stribeck: float = uniform(0.15, 0.6, default=0.3)
    bristle: float = 0.006
    scale: str = scaling(default="stiffness")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        excess = (self.breakaway - 1) * np.exp(-((state.rate / self.stribeck) ** 2))
        z = bristle(memory, state, self.bristle * (1 + excess))
        return self.level * moment_scale(self.scale, joints) / self.bristle * z, z


@dataclass(frozen=True)
class LoadFriction(Law, name="dry_friction", variant="load"):
    """Friction that grows with the torque of the actuators.

    C.-P. Chou, B. Hannaford, Measurement and Modeling of McKibben Pneumatic Artificial Muscles, IEEE T-RA 12, 1996.

    level: coefficient on the magnitude of the torque plus a share `idle` of Keq [-]; bristle: bending before slip [rad].
    """

    level: float = strength(0.06, limit=0.5)
    idle: float = uniform(0.1, 0.4, default=0.15)
    bristle: float = 0.005

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = slider(memory, state, self.bristle)
        return self.level * (abs(state.tau) + self.idle * joints.keq) / self.bristle * z, z


@dataclass(frozen=True)
class BaseFriction(Law, name="dry_friction", variant="base"):
    """Friction that decreases from base to tip, like the tension of tubes and tendons.

    M. Kaneko et al., Control Engineering of Tendon Sheath, IEEE ICRA 1991.

    level: at the base, over Keq [rad]; fall: exponent from base to tip [-]; scale: quantity with which the level scales.
    """

    level: float = strength(0.08, limit=0.8)
    fall: float = uniform(1.0, 2.5, default=2.0)
    bristle: float = 0.005
    scale: str = scaling(default="stiffness")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = slider(memory, state, self.bristle)
        return self.level * moment_scale(self.scale, joints) * np.exp(-self.fall * joints.s) / self.bristle * z, z


#: Thresholds of the Preisach plane, relative to its reach: hysterons switch up at `_UP`, down at `_DOWN`.
_GRID = np.linspace(-1.0, 1.0, 11)
_UP, _DOWN = (side[np.subtract.outer(_GRID, _GRID).T > 1e-9] for side in np.meshgrid(_GRID, _GRID))


@dataclass(frozen=True)
class Preisach(Law, name="hysteresis", variant="preisach"):
    """Hysteresis by a plane of hysterons, each with its own two thresholds.

    F. Preisach, Z. Phys. 94, 1935, with the sloped hysterons of M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with
    Hysteresis, Springer 1989, so that the moment does not jump: M = A K b_r (b / b_r - mean of the hysterons), a spring in
    series with the yielding of the hysterons. Minor loops are congruent, unlike those of the Bouc-Wen model.

    amplitude: A, stiffness of the loop over Keq [-]; reach: b_r, largest threshold [rad]; lean: additional weight of hysterons
    with higher thresholds [-]; scale: quantity with which the amplitude scales.
    """

    amplitude: float = strength(0.3, limit=3.0)
    reach: float = uniform(0.6, 1.0, default=0.8)
    lean: float = uniform(-0.6, 0.6, default=0.0)
    scale: str = scaling(default="stiffness")

    def __post_init__(self) -> None:
        super().__post_init__()
        weight = 1 + self.lean * (_UP + _DOWN) / 2
        object.__setattr__(self, "_weight", weight / weight.sum())

    def memory(self, joints: Joints) -> Array:
        return np.zeros((_UP.size, joints.s.size))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        x = (state.bend + state.rate * state.dt) / self.reach
        slope = 2 / (_GRID[1] - _GRID[0])
        low, high = (np.clip(slope * (x - edge[:, None]), -1.0, 1.0) for edge in (_UP, _DOWN))
        z = np.maximum(low, np.minimum(high, memory))
        yielded = self._weight @ z  # type: ignore[attr-defined]
        return self.amplitude * moment_scale(self.scale, joints) * self.reach * (x - yielded), z


@dataclass(frozen=True)
class SkewedLoop(Law, name="hysteresis", variant="skewed"):
    """An asymmetric Bouc-Wen loop that yields sharply.

    J. Song, A. Der Kiureghian, Generalized Bouc-Wen Model for Highly Asymmetric Hysteresis, J. Eng. Mech. 132, 2006, with
    three of its six shape parameters.

    amplitude: stiffness of the loop over Keq [-]; yield_angle: [rad]; skew: asymmetry of the heights above and below [-]; unload:
    -1 to 1, curvature of unloading; exponent: [-]; scale: quantity with which the amplitude scales.
    """

    amplitude: float = strength(0.3, limit=4.0)
    yield_angle: float = uniform(0.08, 0.3, default=0.15)
    skew: float = uniform(-0.5, 0.5, default=0.0)
    unload: float = uniform(-0.3, 0.6, default=0.5)
    exponent: float = 2.0
    scale: str = scaling(default="stiffness")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        stretch = state.rate * state.dt / self.yield_angle
        loading = np.sign(stretch * memory) > 0
        shape = np.where(loading, 1.0, self.unload) * (1 + self.skew * np.sign(memory)) ** self.exponent
        # The loop is bounded by its own height, S^(-1/n) for a shape S.
        top = 1 / (1 + self.skew * np.sign(memory + stretch))
        z = np.clip(memory + stretch * (1 - np.abs(memory) ** self.exponent * shape), -top, top)
        return self.amplitude * moment_scale(self.scale, joints) * self.yield_angle * z, z
