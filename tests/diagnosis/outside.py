"""Laws that are in no catalogue, unlike it and unlike one another: used to make recordings that nothing should explain."""

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Bending, Effect
from hsr_pin.parameters import parameter

#: Of the arm in every recording made with these laws [m].
LENGTH = 0.24


class Clocked(Effect):
    """A law that knows the time since the recording began: its first internal state."""

    states = 1

    def update(self, state, start, end, elapsed):
        return state + elapsed if np.isfinite(elapsed) else np.zeros_like(state)


@dataclass(frozen=True)
class PulsingStiffness(Clocked):
    """k(t) = Keq (1 + depth sin(2 pi frequency t)): parametric excitation."""

    name = "pulsing_stiffness"
    depth: float = parameter(0.0, lower=0.0, upper=0.6, unit="1", scale=0.1, amplitude=True, description="relative")
    frequency: float = parameter(1.7, lower=0.1, upper=10.0, unit="Hz", scale=0.5, description="of the pulses")

    def moment(self, bending: Bending):
        return self.depth * np.sin(2 * np.pi * self.frequency * bending.state[0]) * bending.keq * bending.angle


@dataclass(frozen=True)
class SwitchingStiffness(Clocked):
    """A tube comes off: from ``time`` on, the arm has lost a part of its stiffness."""

    name = "switching_stiffness"
    loss: float = parameter(0.0, lower=0.0, upper=0.8, unit="1", scale=0.1, amplitude=True, description="relative")
    time: float = parameter(0.6, lower=0.0, upper=10.0, unit="s", scale=0.1, description="of the loss")

    def moment(self, bending: Bending):
        return -self.loss * (bending.state[0] > self.time) * bending.keq * bending.angle


@dataclass(frozen=True)
class Gust(Clocked):
    """A follower force at the tip, across the arm there, that blows from ``start`` for ``duration``."""

    name = "gust"
    force: float = parameter(0.0, lower=-3.0, upper=3.0, unit="N", scale=0.2, amplitude=True, description="across the tip")
    start: float = parameter(0.5, lower=0.0, upper=10.0, unit="s", scale=0.1, description="of the gust")
    duration: float = parameter(0.35, lower=0.0, upper=10.0, unit="s", scale=0.1, description="of the gust")

    def moment(self, bending: Bending):
        links = len(bending.angle)
        theta = np.cumsum(bending.angle / links, axis=0)
        along = LENGTH / links * np.cos(theta - theta[-1])
        along[-1] /= 2  # joints are in the middle of the elements
        arm = np.cumsum(along[::-1], axis=0)[::-1]  # of the force about each joint
        blows = (bending.state[0] > self.start) & (bending.state[0] < self.start + self.duration)
        return -self.force * blows * arm


@dataclass(frozen=True)
class Ripple(Effect):
    """The supply pulses: a torque that swings whatever is commanded."""

    name = "ripple"
    amplitude: float = parameter(0.0, lower=0.0, upper=1.0, unit="Nm", scale=0.05, amplitude=True, description="of the torque")
    frequency: float = parameter(2.6, lower=0.1, upper=10.0, unit="Hz", scale=0.5, description="of the torque")

    def command(self, torque, past, step, keq):
        time = 0.0 if past is None else past
        return torque + self.amplitude * np.sin(2 * np.pi * self.frequency * time), (0.0 if past is None else time + step)


@dataclass(frozen=True)
class Dropout(Effect):
    """A regulator that lets go now and then: for ``duration`` in every ``period`` nothing arrives of the command."""

    name = "dropout"
    duration: float = parameter(0.0, lower=0.0, upper=1.0, unit="s", scale=0.05, amplitude=True, description="of each dropout")
    period: float = parameter(0.7, lower=0.1, upper=10.0, unit="s", scale=0.1, description="between dropouts")

    def command(self, torque, past, step, keq):
        if past is None:
            return torque, 0.0
        return np.where((past % self.period) > self.period - self.duration, 0.0, torque), past + step


@dataclass(frozen=True)
class SlewLimit(Effect):
    """Valves of limited flow: the torque changes no faster than ``1 / slowness``."""

    name = "slew_limit"
    slowness: float = parameter(0.0, lower=0.0, upper=5.0, unit="s/Nm", scale=0.1, amplitude=True, description="1 / fastest rate")

    def command(self, torque, past, step, keq):
        if past is None:
            return torque, torque
        most = step / np.maximum(self.slowness, 1e-9)
        now = past + np.clip(torque - past, -most, most)
        return (past + now) / 2, now


@dataclass(frozen=True)
class Tether(Effect):
    """A hose that comes taut on one side: no resistance up to a bending angle of ``slack``, a stiff one beyond."""

    name = "tether"
    ratio: float = parameter(0.0, lower=0.0, upper=30.0, unit="1", scale=0.3, amplitude=True, description="stiffness over Keq")
    slack: float = parameter(0.4, lower=0.0, upper=3.0, unit="rad", scale=0.1, description="bending of the whole arm")

    def moment(self, bending: Bending):
        whole = bending.angle.mean(axis=0)  # the hose runs along the whole arm: its tension bends every joint back
        return self.ratio * bending.keq * np.maximum(whole - self.slack, 0.0) * np.ones_like(bending.angle)

    def tangent(self, keq):
        return self.ratio * keq / 2, 0.0


OUTSIDE = {
    law.name: law
    for law in (
        PulsingStiffness(0.25),
        SwitchingStiffness(0.25),
        Gust(0.6),
        Ripple(0.08),
        Dropout(0.12),
        SlewLimit(0.4),
        Tether(2.0),
    )
}
