"""Laws between the command and the moment along the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arm import Array
from .law import Law, one_of, strength


@dataclass(frozen=True)
class ActuatorLag(Law, name="actuator_lag"):
    """Actuator with a first-order lag of the torque.

    First-order filling of the muscles, T p' = p_c - p (V. Falkenhahn et al., Dynamic Modeling of
    Bellows-Actuated Continuum Robots, IEEE T-RO 31, 2015), solved exactly for a held command.

    time: T [s].
    """

    time: float = strength(0.03, limit=0.5)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.time <= 0:
            return tau
        from scipy.signal import lfilter

        a = np.exp(-(t[1] - t[0]) / self.time)
        out, _ = lfilter([0.0, 1 - a], [1.0, -a], tau, zi=[tau[0]])
        return np.asarray(out)


@dataclass(frozen=True)
class DeadTime(Law, name="dead_time"):
    """Transport delay of the command (J. E. Normey-Rico, E. F. Camacho, Control of Dead-time Processes, 2007).

    delay: delay [s].
    """

    delay: float = strength(0.03, limit=0.3)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        dt = t[1] - t[0]
        whole = int(self.delay / dt)
        part = self.delay / dt - whole
        late = np.concatenate([np.full(whole + 1, tau[0]), tau])
        shifted: Array = (1 - part) * late[1 : tau.size + 1] + part * late[: tau.size]
        return shifted


@dataclass(frozen=True)
class TorqueBias(Law, name="torque_bias"):
    """A constant moment along the arm, such as from unequal actuators or pressure offsets.

    bias: moment [N m].
    """

    bias: float = strength(0.05, limit=0.5, signed=True)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau + self.bias


@dataclass(frozen=True)
class TorqueMap(Law, name="torque_map"):
    """Nonlinear relation between command and torque.

    The moment is quadratic in the commanded bending, tau = Keq phi (1 + a phi): muscle force is a quadratic function of
    contraction, not a linear one (B. Tondu, Modelling of the McKibben Artificial Muscle: a Review, J. Intell. Mater. Syst.
    Struct. 23, 2012).

    quadratic: a [1/rad].
    """

    quadratic: float = strength(0.1, limit=0.5, signed=True)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        return tau * (1 + self.quadratic * tau / keq)


@dataclass(frozen=True)
class TorqueDecay(Law, name="torque_decay"):
    """Actuation that decreases from base to tip by friction along the backbone.

    form ``exponential``: exp(-a s), the capstan equation (M. Kaneko et al., Control Engineering of Tendon
    Sheath, IEEE ICRA 1991); ``linear``: 1 - a s.

    decay: a [-].
    """

    decay: float = strength(0.15, limit=0.95)
    form: str = one_of("exponential", "linear")

    def torque(self, s: Array) -> Array:
        return np.exp(-self.decay * s) if self.form == "exponential" else 1 - self.decay * s
