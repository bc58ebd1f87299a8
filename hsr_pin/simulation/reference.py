"""What the march asks of the arms, by Pinocchio: the reference for the compiled loops, and the way of ``hsr-sim``.

One call of ABA with ``armature`` = d D + d^2 K solves the linearly implicit Euler step of length d exactly: Pinocchio adds it to
the diagonal of the mass matrix. "rnea": bias by the recursive Newton-Euler algorithm, mass matrix by CRBA, the path that the
paper names as future work; O(N^3).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from hsr_pin.effects.effect import Bending, Effect, columns_of, middles
from hsr_pin.simulation import kernel
from hsr_pin.simulation.kernel import ROWS
from hsr_pin.trajectory import Array

__all__ = ["ROWS", "add", "alone", "bent", "between", "remember", "remembered", "resist", "substep"]


@dataclass(frozen=True, eq=False)
class PinocchioSystem:
    """B arms for Python: the arrays of :class:`hsr_pin.simulation.columns.System`, their models and their laws.

    Attributes:
        arrays: as the compiled loops take them.
        models, data: (B,) of Pinocchio's.
        effects: those that act in the joints, with the columns' parameters.
        solve: "aba" or "rnea".
    """

    arrays: Any
    models: tuple[pin.Model, ...]
    data: tuple[pin.Data, ...]
    effects: tuple[Effect, ...]
    solve: str
    laws: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "laws", np.zeros((len(self.effects), 4)))  # as many rows as there are laws


def substep(system: PinocchioSystem, q: Array, v: Array, moment: Array, torque: Array, d: float, scratch: Array) -> None:
    """As :func:`hsr_pin.simulation.kernel.substep`."""
    a = system.arrays
    tau = a.share * torque[:, None] - a.spring * q - (a.damper + d * a.stiff) * v - moment
    armature = d * (a.drag + d * a.stiff)
    forward = _newton_euler if system.solve == "rnea" else pin.aba
    for b, (model, data) in enumerate(zip(system.models, system.data, strict=True)):
        model.armature = armature[b]
        v[b] += d * forward(model, data, q[b], v[b], tau[b])
    q += d * v


def _newton_euler(model: pin.Model, data: pin.Data, q: Array, v: Array, tau: Array) -> Array:
    armature = np.diag(model.armature)
    bias = pin.rnea(model, data, q, v, np.zeros_like(v))
    model.armature = np.zeros_like(v)  # whether CRBA counts it depends on Pinocchio's version
    upper = np.triu(pin.crba(model, data, q))
    return np.asarray(np.linalg.solve(upper + np.triu(upper, 1).T + armature, tau - bias))


def resist(system: PinocchioSystem, q: Array, v: Array, z: Array, moment: Array) -> None:
    """Add the moments of the laws (B, N) [N m] to ``moment``."""
    links, first = q.shape[1], 0
    for effect in system.effects:
        memory = tuple(z[first : first + effect.states])
        bending = Bending(links * q, links * v, system.arrays.keq[:, None], system.arrays.profile, middles(links), memory)
        moment += effect.moment(_columns(effect.p), bending)
        if effect.acts_through("touch"):
            moment += touched(effect, q, system.arrays.reach)
        first += effect.states


def touched(effect: Effect, q: Array, reach: Array) -> Array:
    """(B, N) [N m] with which a force beside the arm resists bending; angles and links (B, N) [rad], [m]."""
    theta, p = q.cumsum(axis=1), _columns(effect.p)
    rest = reach[:, ::-1].cumsum(axis=1)[:, ::-1]  # from each joint to the tip
    beyond = (1 - effect.place(p)) * (rest[:, :1] + reach[:, :1] - reach[:, -1:])  # from where the force acts
    carried = np.clip(rest - beyond, 0.0, reach)  # of each link, as far as where the force acts
    force = effect.touch(p, (carried * np.sin(theta)).sum(axis=1, keepdims=True))
    return np.asarray(-force * (carried * np.cos(theta))[:, ::-1].cumsum(axis=1)[:, ::-1])


def remember(system: PinocchioSystem, z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """The laws' memories (states, B, N) after the joints went from ``start`` to ``end`` (B, N) [rad] in ``elapsed`` [s]."""
    remembered(system.effects, z, start, end, elapsed, out)


def remembered(effects: tuple[Effect, ...], z: Array, start: Array, end: Array, elapsed: float, out: Array) -> None:
    """The same for laws with the columns' parameters."""
    links, first = start.shape[1], 0
    for effect in effects:
        p = _columns(effect.p)
        for k in range(effect.states):
            out[first + k] = effect.update(p, k, z[first + k], links * start, links * end, elapsed)
        first += effect.states


def _columns(p: Any) -> Any:
    """The parameters of B arms, so that they broadcast to (B, N)."""
    return type(p)(*(value[:, None] if isinstance(value, np.ndarray) else value for value in p))


def alone(system: PinocchioSystem, b: int) -> PinocchioSystem:
    """One of the arms."""
    chosen = slice(b, b + 1)
    effects = tuple(columns_of(effect, chosen) for effect in system.effects)
    return PinocchioSystem(kernel.alone(system.arrays, b), system.models[chosen], system.data[chosen], effects, system.solve)


def add(total: Array, weight: float, term: Array) -> None:
    """Add ``weight`` times ``term`` to ``total``."""
    total += weight * term


def between(q: Array, v: Array, q_end: Array, v_end: Array, h: float, x: float, angle: Array, rate: Array) -> None:
    """As :func:`hsr_pin.simulation.kernel.between`."""
    rise = q_end - q
    first, last = h * v - rise, rise - h * v_end
    bow = first * (1 - x) + last * x
    angle[:] = (1 - x) * q + x * q_end + x * (1 - x) * bow
    rate[:] = (rise + (1 - 2 * x) * bow + x * (1 - x) * (last - first)) / h


def bent(q: Array, column: int) -> float:
    """Bending angle [rad] of a whole arm."""
    return float(q[column].sum())
