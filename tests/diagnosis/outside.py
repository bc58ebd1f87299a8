"""Laws outside the catalogue, for recordings that no candidate should explain."""

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude, shape
from hsr_pin.parameters import amplitude as amplitude_field


class Clocked(Effect):
    """A law that depends on the time since the start of the recording, its first internal state."""

    states = 1

    @staticmethod
    def update(p, k, memory, start, end, elapsed):
        return memory + elapsed if elapsed < np.inf else 0.0 * memory


@dataclass(frozen=True)
class PulsingStiffness(Clocked):
    """k(t) = Keq (1 + depth sin(2 pi frequency t)): parametric excitation."""

    name = "pulsing_stiffness"
    kind = "elastic"
    depth: float = amplitude(0.1, "1", lower=0.0, upper=0.6, description="relative")
    frequency: float = shape(1.7, 0.5, "Hz", lower=0.1, upper=10.0, description="of the pulses")

    @staticmethod
    def moment(p, bending):
        return p.depth * np.sin(2 * np.pi * p.frequency * bending.memory[0]) * bending.keq * bending.angle


@dataclass(frozen=True)
class SwitchingStiffness(Clocked):
    """A tube comes off: from ``time`` on, the arm has lost a part of its stiffness."""

    name = "switching_stiffness"
    kind = "elastic"
    loss: float = amplitude(0.1, "1", lower=0.0, upper=0.8, description="relative")
    time: float = shape(0.6, 0.1, "s", lower=0.0, upper=10.0, description="of the loss")

    @staticmethod
    def moment(p, bending):
        return -p.loss * (bending.memory[0] > p.time) * bending.keq * bending.angle


@dataclass(frozen=True)
class Lean(Clocked):
    """A person leans on the arm, which bends it along its whole length, from ``start`` for ``duration``."""

    name = "lean"
    kind = "contact"
    size: float = amplitude(0.1, "Nm", lower=-2.0, upper=2.0, description="of the moment")
    start: float = shape(0.5, 0.1, "s", lower=0.0, upper=10.0, description="of the push")
    duration: float = shape(0.35, 0.1, "s", lower=0.0, upper=10.0, description="of the push")

    @staticmethod
    def moment(p, bending):
        since = bending.memory[0] - p.start
        return -p.size * ((since > 0) & (since < p.duration)) + 0.0 * bending.angle


@dataclass(frozen=True)
class Ripple(Effect):
    """The supply pulsates: a periodic torque that does not depend on the command."""

    name = "ripple"
    kind = "actuation_map"
    memories = 1
    amplitude: float = amplitude_field(0.05, "Nm", lower=0.0, upper=1.0, description="of the torque")
    frequency: float = shape(2.6, 0.5, "Hz", lower=0.1, upper=10.0, description="of the torque")

    @staticmethod
    def actuator_response(p, torque, memory, step, keq):
        time = memory[0]
        return torque + p.amplitude * np.sin(2 * np.pi * p.frequency * time), (time + step,)


@dataclass(frozen=True)
class Dropout(Effect):
    """A regulator fails periodically: for ``duration`` in every ``period`` the command has no effect."""

    name = "dropout"
    kind = "actuation_time"
    memories = 1
    duration: float = amplitude(0.05, "s", lower=0.0, upper=1.0, description="of each dropout")
    period: float = shape(0.7, 0.1, "s", lower=0.1, upper=10.0, description="between dropouts")

    @staticmethod
    def actuator_response(p, torque, memory, step, keq):
        time = memory[0]
        return torque * (time % p.period <= p.period - p.duration), (time + step,)


@dataclass(frozen=True)
class SlewLimit(Effect):
    """Valves of limited flow: the torque changes no faster than ``1 / slowness``."""

    name = "slew_limit"
    kind = "actuation_time"
    memories = 1
    slowness: float = amplitude(0.1, "s/Nm", lower=0.0, upper=5.0, description="1 / fastest rate")

    @staticmethod
    def actuator_response(p, torque, memory, step, keq):
        most = step / np.maximum(p.slowness, 1e-9)
        now = memory[0] + np.minimum(np.maximum(torque - memory[0], -most), most)
        return (memory[0] + now) / 2, (now,)


@dataclass(frozen=True)
class Tether(Effect):
    """A sleeve that becomes taut on one side: stiff beyond a bending angle of ``slack``, and without resistance below."""

    name = "tether"
    kind = "contact"
    ratio: float = amplitude(0.3, "1", lower=0.0, upper=30.0, description="stiffness over Keq")
    slack: float = shape(0.4, 0.1, "rad", lower=0.0, upper=3.0, description="bending of the whole arm")

    @staticmethod
    def moment(p, bending):
        return p.ratio * bending.keq * np.maximum(bending.angle - p.slack, 0.0)

    def tangent(self, keq, length):
        return self.ratio * keq / 2, 0.0


OUTSIDE = {
    law.name: law
    for law in (
        PulsingStiffness(0.25),
        SwitchingStiffness(0.25),
        Lean(0.3),
        Ripple(0.08),
        Dropout(0.12),
        SlewLimit(0.4),
        Tether(2.0),
    )
}
