"""Friction and hysteresis in forms that differ from the catalogue's, all of them rate-independent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arm import Array
from ..law import Joints, Law, State
from .scale import check_scale, drawn_scale, moment_scale


def _bristle(memory: Array, state: State, top: Array | float) -> Array:
    """Return LuGre's bristle deflection after a step, which tends to `top`: exact for a constant rate."""
    end = np.sign(state.rate) * top
    return np.asarray(end + (memory - end) * np.exp(-np.abs(state.rate) * state.dt / top))


@dataclass(frozen=True)
class StribeckFriction(Law):
    """Friction that falls with the sliding rate, which causes stick-slip.

    The Stribeck curve in LuGre's bristles (C. Canudas de Wit et al., A New Model for Control of Systems with Friction,
    IEEE TAC 40, 1995): from `breakaway` times the level down to the level within about `stribeck` [rad/s].

    level: moment over Keq when sliding [rad]; bristle: bending before slip [rad]; scale: quantity with which the level scales.
    """

    name: ClassVar[str] = "dry_friction"
    variant: ClassVar[str] = "stribeck"
    strength: ClassVar[str] = "level"
    limit: ClassVar[float] = 0.5
    level: float = 0.0
    breakaway: float = 1.6
    stribeck: float = 0.3
    bristle: float = 0.006
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> StribeckFriction:
        return cls(0.04, float(rng.uniform(1.3, 1.8)), float(rng.uniform(0.15, 0.6)), scale=drawn_scale(rng))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        excess = (self.breakaway - 1) * np.exp(-((state.rate / self.stribeck) ** 2))
        z = _bristle(memory, state, self.bristle * (1 + excess))
        return self.level * moment_scale(self.scale, joints) / self.bristle * z, z


@dataclass(frozen=True)
class LoadFriction(Law):
    """Friction that grows with the torque of the actuators.

    C.-P. Chou, B. Hannaford, Measurement and Modeling of McKibben Pneumatic Artificial Muscles, IEEE T-RA 12, 1996.

    level: coefficient on the magnitude of the torque plus a share `idle` of Keq [-]; bristle: bending before slip [rad].
    """

    name: ClassVar[str] = "dry_friction"
    variant: ClassVar[str] = "load"
    strength: ClassVar[str] = "level"
    limit: ClassVar[float] = 0.5
    level: float = 0.0
    idle: float = 0.15
    bristle: float = 0.005

    @classmethod
    def draw(cls, rng: np.random.Generator) -> LoadFriction:
        return cls(0.06, float(rng.uniform(0.1, 0.4)))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = np.clip(memory + state.rate * state.dt, -self.bristle, self.bristle)
        return self.level * (abs(state.tau) + self.idle * joints.keq) / self.bristle * z, z


@dataclass(frozen=True)
class BaseFriction(Law):
    """Friction that decreases from base to tip, like the tension of tubes and tendons.

    M. Kaneko et al., Control Engineering of Tendon Sheath, IEEE ICRA 1991.

    level: at the base, over Keq [rad]; fall: exponent from base to tip [-]; scale: quantity with which the level scales.
    """

    name: ClassVar[str] = "dry_friction"
    variant: ClassVar[str] = "base"
    strength: ClassVar[str] = "level"
    limit: ClassVar[float] = 0.8
    level: float = 0.0
    fall: float = 2.0
    bristle: float = 0.005
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> BaseFriction:
        return cls(0.08, float(rng.uniform(1.0, 2.5)), scale=drawn_scale(rng))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        z = np.clip(memory + state.rate * state.dt, -self.bristle, self.bristle)
        return self.level * moment_scale(self.scale, joints) * np.exp(-self.fall * joints.s) / self.bristle * z, z


#: Thresholds of the Preisach plane, relative to its reach: hysterons switch up at `_UP`, down at `_DOWN`.
_GRID = np.linspace(-1.0, 1.0, 11)
_UP, _DOWN = (side[np.subtract.outer(_GRID, _GRID).T > 1e-9] for side in np.meshgrid(_GRID, _GRID))


@dataclass(frozen=True)
class Preisach(Law):
    """Hysteresis by a plane of hysterons, each with its own two thresholds.

    F. Preisach, Z. Phys. 94, 1935, with the sloped hysterons of M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with
    Hysteresis, Springer 1989, so that the moment does not jump: M = A K b_r (b / b_r - mean of the hysterons), a spring in
    series with the yielding of the hysterons. Minor loops are congruent, unlike those of the Bouc-Wen model.

    amplitude: A, stiffness of the loop over Keq [-]; reach: b_r, largest threshold [rad]; lean: additional weight of hysterons
    with higher thresholds [-]; scale: quantity with which the amplitude scales.
    """

    name: ClassVar[str] = "hysteresis"
    variant: ClassVar[str] = "preisach"
    strength: ClassVar[str] = "amplitude"
    limit: ClassVar[float] = 3.0
    amplitude: float = 0.0
    reach: float = 0.8
    lean: float = 0.0
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)
        weight = 1 + self.lean * (_UP + _DOWN) / 2
        object.__setattr__(self, "_weight", weight / weight.sum())

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Preisach:
        return cls(0.3, float(rng.uniform(0.6, 1.0)), float(rng.uniform(-0.6, 0.6)), drawn_scale(rng))

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
class SkewedLoop(Law):
    """An asymmetric Bouc-Wen loop that yields sharply.

    J. Song, A. Der Kiureghian, Generalized Bouc-Wen Model for Highly Asymmetric Hysteresis, J. Eng. Mech. 132, 2006, with
    three of its six shape parameters.

    amplitude: stiffness of the loop over Keq [-]; yield_angle: [rad]; skew: asymmetry of the heights above and below [-]; unload:
    -1 to 1, curvature of unloading; exponent: [-]; scale: quantity with which the amplitude scales.
    """

    name: ClassVar[str] = "hysteresis"
    variant: ClassVar[str] = "skewed"
    strength: ClassVar[str] = "amplitude"
    limit: ClassVar[float] = 4.0
    amplitude: float = 0.0
    yield_angle: float = 0.15
    skew: float = 0.0
    unload: float = 0.5
    exponent: float = 2.0
    scale: str = "stiffness"

    def __post_init__(self) -> None:
        check_scale(self.scale)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> SkewedLoop:
        yields, skew, unload = (float(rng.uniform(*span)) for span in ((0.08, 0.3), (-0.5, 0.5), (-0.3, 0.6)))
        return cls(0.3, yields, skew, unload, scale=drawn_scale(rng))

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        stretch = state.rate * state.dt / self.yield_angle
        loading = np.sign(stretch * memory) > 0
        shape = np.where(loading, 1.0, self.unload) * (1 + self.skew * np.sign(memory)) ** self.exponent
        # The loop is bounded by its own height, S^(-1/n) for a shape S.
        top = 1 / (1 + self.skew * np.sign(memory + stretch))
        z = np.clip(memory + stretch * (1 - np.abs(memory) ** self.exponent * shape), -top, top)
        return self.amplitude * moment_scale(self.scale, joints) * self.yield_angle * z, z
