"""Laws outside of any catalogue, unlike its laws and unlike one another; no diagnosis should name them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arm import Arm, Array
from ..program import Trial
from .law import Joints, Law, Nodes, State, random_seed, strength, uniform


@dataclass(frozen=True)
class BaseShake(Law, name="base_shake"):
    """Vibration of the structure that carries the base.

    The structure swings along x (support excitation: R. W. Clough, J. Penzien,
    Dynamics of Structures, ch. 2). It starts smoothly at the first sample; base markers show it.

    amplitude: [m]; frequency: [Hz].
    """

    amplitude: float = strength(0.003, limit=0.03)
    frequency: float = uniform(1.5, 5.0, default=3.0)

    def base(self, t: Array) -> Array:
        u = np.clip(t * self.frequency / 2, 0.0, 1.0)
        ramp = u**3 * (10 - 15 * u + 6 * u * u)
        return np.asarray(self.amplitude * ramp * np.sin(2 * np.pi * self.frequency * t))


@dataclass(frozen=True)
class WarmingArm(Law, name="warming_arm"):
    """Softening of the arm over the session.

    Stiffness falls over the session as the silicone warms with work (L. Mullins, Softening of Rubber by
    Deformation, Rubber Chem. Technol. 42, 1969), and does not recover: each trial is softer than the one before.

    loss: final relative loss of stiffness [-]; time: time constant, in session time [s].
    """

    loss: float = strength(0.15, limit=0.7)
    time: float = uniform(30, 120, default=60.0)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        lost = self.loss * (1 - np.exp(-(state.clock + state.t) / self.time))
        return -lost * joints.stiffness * state.bend, memory


@dataclass(frozen=True)
class PulsingStiffness(Law, name="pulsing_stiffness"):
    """Periodic stiffness.

    The stiffness pulses with the supply of the actuators: parametric excitation (Nayfeh, Mook, Nonlinear
    Oscillations, ch. 5).

    depth: relative amplitude [-]; frequency: [Hz]; phase: in session time [rad].
    """

    depth: float = strength(0.08, limit=0.6)
    frequency: float = uniform(0.8, 4.0, default=2.0)
    phase: float = uniform(0, 2 * np.pi, default=0.0)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        wave = np.sin(2 * np.pi * self.frequency * (state.clock + state.t) + self.phase)
        gain = 0.0 if state.rest else self.depth * wave
        return gain * joints.stiffness * state.bend, memory


@dataclass(frozen=True)
class SupplyRipple(Law, name="supply_ripple"):
    """Ripple of the supply pressure.

    The cycle of a compressor adds a sawtooth of fixed amplitude to the torque, independent of the command.

    amplitude: [N m]; frequency: [Hz]; phase: in session time [cycles].
    """

    amplitude: float = strength(0.05, limit=0.5)
    frequency: float = uniform(0.7, 3.0, default=1.5)
    phase: float = uniform(0, 1, default=0.0)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        cycle = (self.frequency * (clock + t) + self.phase) % 1.0
        saw = np.where(cycle < 0.2, 10 * cycle - 1, 1 - 2.5 * (cycle - 0.2))
        return tau + np.where(t < 0, 0.0, self.amplitude * saw)


@dataclass(frozen=True)
class TipGust(Law, name="tip_gust"):
    """Wind on the tip.

    A fan's turbulent side force at the tip: first-order (Dryden-like) coloured noise (MIL-F-8785C,
    sec. 3.7), as a sum of random harmonics; it starts at the first sample.

    force_rms: standard deviation [N]; corner: corner frequency [Hz]; seed: seed of the phases.
    """

    force_rms: float = strength(0.2, limit=2.0)
    corner: float = uniform(0.5, 2.0, default=1.0)
    seed: int = random_seed()

    def __post_init__(self) -> None:
        rng = np.random.default_rng(self.seed)
        f = 0.1 * np.arange(1, 101) * rng.uniform(0.9, 1.1, 100)
        a = 1 / np.sqrt(1 + (f / self.corner) ** 2)
        a *= self.force_rms * np.sqrt(2 / np.sum(a**2))
        object.__setattr__(self, "_waves", (a, 2 * np.pi * f, rng.uniform(0, 2 * np.pi, 100)))

    def force(self, state: State, nodes: Nodes) -> Array:
        out = np.zeros_like(nodes.position)
        if not state.rest:
            a, w, phase = self._waves  # type: ignore[attr-defined]
            out[0, -1] = a @ np.sin(w * (state.clock + state.t) + phase)
        return out


@dataclass(frozen=True)
class Tether(Law, name="tether"):
    """A hose at the tip.

    A supply hose from the tip to a fixed point: slack, then taut (a one-sided spring: Shaw, Holmes, J.
    Sound Vib. 90, 1983).

    stiffness_taut: [N/m]; reach: free length [m]; x, z: fixed point in the arm frame [m].
    """

    stiffness_taut: float = strength(10.0, limit=300.0)
    reach: float = 0.2
    x: float = -0.15
    z: float = 0.1

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Tether:
        x, z = float(rng.uniform(-0.25, -0.15)), float(rng.uniform(0.15, 0.3))
        slack = float(rng.uniform(0.01, 0.04))
        return cls(10.0, float(np.hypot(x, 0.24 - z)) + slack, x, z)

    def force(self, state: State, nodes: Nodes) -> Array:
        out = np.zeros_like(nodes.position)
        pull = np.array([self.x, self.z]) - nodes.position[:, -1]
        distance = float(np.hypot(*pull))
        tension = self.stiffness_taut * max(distance - self.reach, 0.0)
        out[:, -1] = tension * pull / max(distance, 1e-9)
        return out


@dataclass(frozen=True)
class FollowerThrust(Law, name="follower_thrust"):
    """Thrust of a leak at the tip.

    The leak blows along the arm: a follower force that grows with the square of the torque
    (M. Beck's column: V. V. Bolotin, Nonconservative Problems of the Theory of Elastic Stability, 1963).

    thrust: force towards the base at 1 N m [N/(N m)2].
    """

    thrust: float = strength(0.3, limit=3.0, signed=True)

    def force(self, state: State, nodes: Nodes) -> Array:
        out = np.zeros_like(nodes.position)
        a = nodes.angle[-1]
        out[:, -1] = -self.thrust * state.tau**2 * np.array([np.sin(a), np.cos(a)])
        return out


@dataclass(frozen=True)
class Wall(Law, name="wall"):
    """A wall next to the arm: the engine's own contact with friction (Todorov, ICRA 2014); chain only.

    nearness: distance of the wall from `far` towards the arm [m]; far: distance at which no motion touches it [m].
    """

    nearness: float = strength(0.15, limit=0.24)
    far: float = 0.3

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        return replace(arm, wall=self.far - self.nearness)


@dataclass(frozen=True)
class SkewPlane(Law, name="skew_plane"):
    """Skewed actuators: the arm bends in a plane rotated about its straight axis (vertical mounts).

    angle: [rad].
    """

    angle: float = strength(0.08, limit=0.8, signed=True)

    def seen(self, points: Array) -> Array:
        c, s = np.cos(self.angle), np.sin(self.angle)
        x, y, z = np.moveaxis(points, -1, 0)
        return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


@dataclass(frozen=True)
class CameraScale(Law, name="camera_scale"):
    """Wrong scale of the cameras, from a calibration wand of wrong length: everything appears larger.

    Z. Zhang, Camera Calibration with One-Dimensional Objects, IEEE T-PAMI 26, 2004.

    excess: relative excess over the true size [-].
    """

    excess: float = strength(0.02, limit=0.1, signed=True)

    def seen(self, points: Array) -> Array:
        return points * (1 + self.excess)


@dataclass(frozen=True)
class MarkerSlip(Law, name="marker_slip"):
    """Slipped markers: all markers except the one at the base are closer to the base than declared.

    U. Della Croce et al., Gait & Posture 21, 2005: misplacement of landmarks.

    slip: displacement of the tip's marker [m]; that of the others is in proportion to their arc length.
    """

    slip: float = strength(0.006, limit=0.05)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        return np.full_like(angle, -self.slip * s), np.zeros_like(angle)
