"""Laws between the command and the moment along the arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from hsr_pin.errors import EffectError

from ..arm import Array
from .law import Law, sign


@dataclass(frozen=True)
class ActuatorLag(Law):
    """Actuator with a first-order lag of the torque.

    First-order filling of the muscles, T p' = p_c - p (V. Falkenhahn et al., Dynamic Modeling of
    Bellows-Actuated Continuum Robots, IEEE T-RO 31, 2015), solved exactly for a held command.

    time: T [s].
    """

    name: ClassVar[str] = "actuator_lag"
    strength: ClassVar[str] = "time"
    limit: ClassVar[float] = 0.5
    time: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> ActuatorLag:
        return cls(0.03)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.time <= 0:
            return tau
        from scipy.signal import lfilter

        a = np.exp(-(t[1] - t[0]) / self.time)
        out, _ = lfilter([0.0, 1 - a], [1.0, -a], tau, zi=[tau[0]])
        return np.asarray(out)


@dataclass(frozen=True)
class DeadTime(Law):
    """Transport delay of the command (J. E. Normey-Rico, E. F. Camacho, Control of Dead-time Processes, 2007).

    delay: delay [s].
    """

    name: ClassVar[str] = "dead_time"
    strength: ClassVar[str] = "delay"
    limit: ClassVar[float] = 0.3
    delay: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> DeadTime:
        return cls(0.03)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        dt = t[1] - t[0]
        whole = int(self.delay / dt)
        part = self.delay / dt - whole
        late = np.concatenate([np.full(whole + 1, tau[0]), tau])
        shifted: Array = (1 - part) * late[1 : tau.size + 1] + part * late[: tau.size]
        return shifted


@dataclass(frozen=True)
class TorqueBias(Law):
    """A constant moment along the arm, such as from unequal actuators or pressure offsets.

    bias: moment [N m].
    """

    name: ClassVar[str] = "torque_bias"
    strength: ClassVar[str] = "bias"
    limit: ClassVar[float] = 0.5
    bias: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TorqueBias:
        return cls(0.05 * sign(rng))

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau + self.bias


@dataclass(frozen=True)
class TorqueMap(Law):
    """Nonlinear relation between command and torque.

    The moment is quadratic in the commanded bending, tau = Keq phi (1 + a phi): muscle force is a quadratic function of
    contraction, not a linear one (B. Tondu, Modelling of the McKibben Artificial Muscle: a Review, J. Intell. Mater. Syst.
    Struct. 23, 2012).

    quadratic: a [1/rad].
    """

    name: ClassVar[str] = "torque_map"
    strength: ClassVar[str] = "quadratic"
    limit: ClassVar[float] = 0.5
    quadratic: float = 0.0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TorqueMap:
        return cls(0.1 * sign(rng))

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau * (1 + self.quadratic * tau / keq)


@dataclass(frozen=True)
class TorqueDecay(Law):
    """Actuation that decreases from base to tip by friction along the backbone.

    form ``exponential``: exp(-a s), the capstan equation (M. Kaneko et al., Control Engineering of Tendon
    Sheath, IEEE ICRA 1991); ``linear``: 1 - a s.

    decay: a [-].
    """

    name: ClassVar[str] = "torque_decay"
    strength: ClassVar[str] = "decay"
    limit: ClassVar[float] = 0.95
    decay: float = 0.0
    form: str = "exponential"

    def __post_init__(self) -> None:
        if self.form not in ("exponential", "linear"):
            raise EffectError("torque_decay form", expected="exponential or linear", received=self.form)

    @classmethod
    def draw(cls, rng: np.random.Generator) -> TorqueDecay:
        return cls(0.15, str(rng.choice(["exponential", "linear"])))

    def torque(self, s: Array) -> Array:
        return np.exp(-self.decay * s) if self.form == "exponential" else 1 - self.decay * s
