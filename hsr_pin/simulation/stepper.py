"""One step after the other: arms side by side, the state passed in and handed back."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.forward import forward_dynamics
from hsr_pin.simulation.integrators import Integrator
from hsr_pin.simulation.integrators.integrator import side_by_side, workspace
from hsr_pin.simulation.scenario import Pose, Settled
from hsr_pin.simulation.statics import equilibrium
from hsr_pin.trajectory import Array


class ChainState(NamedTuple):
    """All that B arms remember between two steps.

    Attributes:
        q: (N, B) [rad] joint angles.
        v: (N, B) [rad/s] joint rates.
        laws: internal states of the effects in the arm, (states, N, B) each.
        muscles: what the effects on the command remember of it, in forms of their own.
    """

    q: Array
    v: Array
    laws: tuple[Array, ...]
    muscles: tuple[Any, ...]


class Stepper:
    """Steps of one length for one set of columns.

    Args:
        columns: the arms.
        method: the integrator.
        step: [s].
        dynamics: "aba" or "rnea".
        threads: for the dynamics.
    """

    def __init__(self, columns: Columns, method: Integrator, step: float, dynamics: str = "aba", threads: int = 1) -> None:
        self.columns, self.step = columns, step
        self._method = method
        self._chain = _Step(columns, method.lengths(step), dynamics, threads)

    def advance(self, state: ChainState, torque: Array) -> ChainState:
        """The state one step later, under commands (B,) [N m]."""
        delivered, muscles = self.columns.deliver(torque, state.muscles, self.step)
        self._chain.begin(self.columns.drive * delivered, state.laws, state.q)
        q, v = self._method.advance(self._chain, state.q, state.v, self.step)
        return ChainState(q, v, self.columns.update(state.laws, state.q, q, self.step), muscles)


class _Slots(NamedTuple):
    """What belongs to the states in ``Work``, (S, N, B) each: coefficients, torques [N m], accelerations [rad/s^2]."""

    spring: Array
    damper: Array
    drive: Array
    viscous: Array
    torque: Array
    acceleration: Array


class _Step:
    """The equations of motion during one step: the drive and the laws' states are those at its beginning."""

    def __init__(self, columns: Columns, lengths: tuple[float, ...], dynamics: str, threads: int) -> None:
        self._columns, self._lengths = columns, lengths
        self.stiffness, self.damping = columns.stiffness, columns.damping
        armatures = [(d * self.damping + d * d * self.stiffness)[:, 0] for d in lengths]
        self._forward = forward_dynamics(dynamics, [arm.model for arm in columns.arm_models], armatures, threads)
        shape = len(lengths), columns.shape.links, len(columns.scenarios)
        self.work = workspace(lengths, *shape[1:])
        whole = self.work[0]
        dampers = -columns.damper - whole.d * self.stiffness
        slots = _Slots(*(side_by_side(values, *shape) for values in (-columns.spring, dampers, 0.0, 0.0, 0.0, 0.0)))
        self._drive = slots.drive
        self._slots = [_Slots(*(array[first:] for array in slots)) for first in range(len(lengths))]
        self._calls = list(zip(range(len(lengths)), whole.q, whole.v, slots.torque, slots.acceleration, strict=True))

    def begin(self, drive: Array, states: tuple[Array, ...], start: Array) -> None:
        self._drive[:] = drive
        self._states, self._start = states, start

    def solve(self, first: int, after: float, push: Array | None = None) -> Array:
        (q, v, _), (spring, damper, drive, viscous, torque, acceleration) = self.work[first], self._slots[first]
        np.multiply(spring, q, out=torque)
        np.multiply(damper, v, out=viscous)
        torque += viscous
        torque += drive
        if push is not None:
            torque += push
        for call in self._calls[first:]:
            if self._states:
                self._add_laws(*call, after)
            self._forward.solve(*call)
        return acceleration

    def _add_laws(self, slot: int, q: Array, v: Array, torque: Array, _: Array, after: float) -> None:
        states = self._states
        if after:
            states = self._columns.update(states, self._start, q, after * self._lengths[slot])
        torque -= self._columns.moment(q, v, states)


def starting_state(columns: Columns, torque: Array) -> tuple[ChainState, NDArray[np.bool_]]:
    """Where the scenarios start, the command having been ``torque`` (B,) [N m] before, and (B,) whether there is such a start."""
    poses = {b: s.start for b, s in enumerate(columns.scenarios) if isinstance(s.start, Pose)}
    settled = np.array([b not in poses for b in range(len(columns.scenarios))])
    delivered, muscles = columns.deliver(torque, (), columns.step)
    near = np.zeros((columns.shape.links, len(settled)), order="F")
    for b, scenario in enumerate(columns.scenarios):
        if isinstance(scenario.start, Settled) and scenario.start.near is not None:
            near[:, b] = scenario.start.near
    q, found = equilibrium(columns, delivered, settled, near)
    q = np.asfortranarray(q)
    v = np.zeros_like(q)
    for b, pose in poses.items():
        q[:, b], v[:, b] = pose.angles, pose.rates
    laws = columns.update(columns.virgin_states(), np.zeros_like(q), q, math.inf)
    return ChainState(q, v, laws, muscles), found | ~settled
