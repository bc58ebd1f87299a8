"""Laws between the command and the moment along the arm, in forms that differ from the catalogue's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arm import Array
from ...program import RATE
from ..law import Joints, Law, State, drawn, random_of_trial, random_seed, strength, uniform
from .scale import KEQ, scaling


def _level(scale: str, keq: float) -> float:
    """Return how much larger a size is at this stiffness level than at the lower one."""
    return keq / KEQ if scale == "stiffness" else 1.0


@dataclass(frozen=True)
class SecondOrderLag(Law, name="actuator_lag", variant="second_order"):
    """A lag of second order, T^2 y'' + 2 z T y' + y = u: supply line and actuator in series, possibly underdamped.

    Exact for a held command (K. J. Åström, B. Wittenmark, Computer-Controlled Systems, 3rd ed., 1997, ch. 2).

    time: T [s]; ratio: z [-]; scale: quantity with which the time scales (``stays`` or ``stiffness``: higher pressure, slower
    line).
    """

    time: float = strength(0.015, limit=0.3)
    ratio: float = uniform(0.6, 1.2, default=1.0)
    scale: str = scaling("stays", "stiffness", default="stays")

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.time <= 0:
            return tau
        from scipy.signal import cont2discrete, lfilter, lfilter_zi

        lag = self.time * _level(self.scale, keq)
        b, a, _ = cont2discrete(([1.0], [lag**2, 2 * self.ratio * lag, 1.0]), t[1] - t[0], method="zoh")
        out, _ = lfilter(b.ravel(), a, tau, zi=lfilter_zi(b.ravel(), a) * tau[0])
        return np.asarray(out)


@dataclass(frozen=True)
class UnequalLag(Law, name="actuator_lag", variant="unequal"):
    """A lag with different times for filling and venting.

    P. Beater, Pneumatic Drives, Springer 2007, ch. 5: first order, with one time constant while the magnitude of the torque
    grows, and another while it falls.

    time: time constant of filling [s]; ratio: venting over filling [-].
    """

    time: float = strength(0.025, limit=0.4)
    ratio: float = drawn(lambda rng: float(rng.choice([rng.uniform(0.3, 0.55), rng.uniform(1.8, 3.2)])), default=2.0)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.time <= 0:
            return tau
        dt = float(t[1] - t[0])
        fill, vent = (-np.expm1(-dt / time) for time in (self.time, self.time * self.ratio))
        out, now = np.empty_like(tau), float(tau[0])
        for k, wanted in enumerate(tau.tolist()):
            out[k] = now
            now += (fill if abs(wanted) > abs(now) else vent) * (wanted - now)
        return out


@dataclass(frozen=True)
class ChokedLag(Law, name="actuator_lag", variant="choked"):
    """A lag with choked flow: far from its target the torque changes at a fixed rate, near it with a first-order lag.

    Sonic flow through the valve (ISO 6358-1:2013): y' = clip((u - y) / T, -r, r) with r so that the whole of `span` Keq
    takes 3 T.

    time: T [s]; span: [rad].
    """

    time: float = strength(0.02, limit=0.4)
    span: float = uniform(0.6, 1.2, default=0.9)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.time <= 0:
            return tau
        dt = float(t[1] - t[0])
        share, most = -np.expm1(-dt / self.time), self.span * keq / (3 * self.time) * dt
        out, now = np.empty_like(tau), float(tau[0])
        for k, wanted in enumerate(tau.tolist()):
            out[k] = now
            now += min(max(share * (wanted - now), -most), most)
        return out


@dataclass(frozen=True)
class JitteredDelay(Law, name="dead_time", variant="jittered"):
    """A delay that differs between commands; commands keep their order, so that one may wait for those before it.

    J. Nilsson, Real-Time Control Systems with Delays, PhD thesis, Lund 1998, ch. 3.

    delay: mean delay without waiting [s]; jitter: largest relative deviation from it [-]; seed: seed of the delays.
    """

    delay: float = strength(0.03, limit=0.3)
    jitter: float = uniform(0.5, 0.95, default=0.7)
    seed: int = random_seed()

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        packet = np.floor(t * RATE + 1e-6).astype(int)  # index of the command at each instant
        first, index = np.unique(packet, return_index=True)
        rng = random_of_trial(self.seed, clock)
        late = self.delay * (1 + self.jitter * rng.uniform(-1, 1, first.size))
        arrival = np.maximum.accumulate(t[index] + late)
        known = np.searchsorted(arrival, t, side="right") - 1
        return np.asarray(tau[index][np.maximum(known, 0)])


@dataclass(frozen=True)
class RestartedDelay(Law, name="dead_time", variant="restarted"):
    """A delay that differs between trials, because the clocks of two computers are set again for each trial.

    D. L. Mills, Internet Time Synchronization: the Network Time Protocol, IEEE Trans. Commun. 39, 1991.

    delay: mean delay [s]; spread: largest relative deviation from it [-]; seed: seed of the delays.
    """

    delay: float = strength(0.03, limit=0.3)
    spread: float = uniform(0.3, 0.8, default=0.6)
    seed: int = random_seed()

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        own = random_of_trial(self.seed, clock).uniform(-1, 1)
        late = self.delay * (1 + self.spread * own)
        return np.interp(t - late, t, tau)


@dataclass(frozen=True)
class DriftingBias(Law, name="torque_bias", variant="drifting"):
    """A torque bias that grows over the session, as sensors and regulators warm up.

    J. Fraden, Handbook of Modern Sensors, 5th ed., 2016, ch. 3.

    bias: final bias [N m]; time: time constant, in session time [s]; scale: quantity with which the bias scales.
    """

    bias: float = strength(0.05, limit=0.5, signed=True)
    time: float = uniform(20.0, 60.0, default=60.0)
    scale: str = scaling("stays", "stiffness", default="stays")

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        grown = 1 - 0.7 * np.exp(-(clock + np.maximum(t, 0.0)) / self.time)
        return np.asarray(tau + self.bias * _level(self.scale, keq) * grown)


@dataclass(frozen=True)
class PartialBias(Law, name="torque_bias", variant="partial"):
    """A constant moment on the outer part of the arm, such as from a shorter actuator.

    R. J. Webster, B. A. Jones, IJRR 29, 2010: sections of piecewise constant moment.

    bias: [N m]; start: start of that part, over L; it ends at the tip; scale: quantity with which the bias scales (``stiffness``:
    the arm was glued bent).
    """

    bias: float = strength(0.06, limit=0.6, signed=True)
    start: float = uniform(0.2, 0.5, default=0.4)
    scale: str = scaling("stays", "stiffness", default="stays")

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        size = -self.bias * _level(self.scale, joints.keq)
        return np.where(joints.s > self.start, size, 0.0), memory


@dataclass(frozen=True)
class SaturatingMap(Law, name="torque_map", variant="saturating"):
    """A torque that saturates, tau = T tanh(tau_c / T), because muscles lose force as they shorten.

    B. Tondu, Modelling of the McKibben Artificial Muscle: a Review, J. Intell. Mater. Syst. Struct. 23, 2012.

    curvature: Keq / T [1/rad].
    """

    curvature: float = strength(0.4, limit=1.2)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        if self.curvature <= 0:
            return tau
        top = keq / self.curvature
        return np.asarray(top * np.tanh(tau / top))


@dataclass(frozen=True)
class ThresholdMap(Law, name="torque_map", variant="threshold"):
    """A torque with a smooth threshold, because a bladder must first fill its braid.

    C.-P. Chou, B. Hannaford, IEEE T-RA 12, 1996.

    threshold: [N m]; scale: quantity with which the threshold scales.
    """

    threshold: float = strength(0.06, limit=0.3)
    scale: str = scaling("stays", "stiffness", default="stays")

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        edge = self.threshold * _level(self.scale, keq)
        if edge <= 0:
            return tau
        return np.asarray(tau - edge * np.tanh(tau / edge))


@dataclass(frozen=True)
class ShortMuscles(Law, name="torque_decay", variant="short_muscles"):
    """Actuators that end before the tip.

    R. J. Webster, B. A. Jones, IJRR 29, 2010: the tip section carries no moment.

    bare: share of the arm without actuators [-].
    """

    bare: float = strength(0.15, limit=0.6)

    def torque(self, s: Array) -> Array:
        soft = 0.02  # over L: width of the transition at the end of the actuators
        return np.asarray(np.clip((1 - self.bare - s) / soft + 0.5, 0.0, 1.0)) if self.bare > 0 else np.ones_like(s)


@dataclass(frozen=True)
class ParabolicTorque(Law, name="torque_decay", variant="parabolic"):
    """Actuation that decreases parabolically towards the tip, 1 - a s^2, as in a tapered bellows.

    F. Renda et al., IEEE T-RO 30, 2014: the moment is proportional to the radius at which a cable or chamber sits.

    decay: a [-].
    """

    decay: float = strength(0.25, limit=1.0)

    def torque(self, s: Array) -> Array:
        return np.asarray(1 - self.decay * s**2)
