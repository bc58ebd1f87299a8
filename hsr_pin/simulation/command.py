"""The torque that arrives at the arms for a command: held or interpolated between samples, then filtered by the actuators.

A command that is known in advance is processed as a whole (:func:`deliver`), a command that arrives step by step by
:class:`~hsr_pin.simulation.actuators.Actuators`; both use the same cells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.trajectory import Array

#: Longest cell of constant torque [s], if the actuators have a memory or the command is interpolated.
CELL = 0.005
#: No integration step passes a change of the torque that exceeds this share of its largest value; the second share is for
#: commands that may be smoothed.
_JUMP, _SMOOTH_JUMP = 0.02, 0.05
#: A command is a curve if at least the share _CURVE of its samples change by more than steps may pass, but by no more than the
#: share _SMALL of the largest value. If it may be treated as smooth, small changes are spread over _SPREAD [s] about their
#: instants, in cells of _FINE [s].
_CURVE, _SMALL, _SPREAD, _FINE = 0.1, 0.12, 0.01, 0.0025


@dataclass(frozen=True, eq=False)
class Delivered:
    """The torque over time, constant within cells.

    Attributes:
        impulse: (B, C + 1) integral of the torque [N m times cells]; of arms in space complex, or (B, C + 1, U) with the loads.
            It has one row if all arms get the same torque.
        cell: length of a cell [s].
        per_sample: number of cells from sample to sample.
        initial: (B,) torque before the first sample [N m]; of arms in space complex, or (B, U). It has one row if all arms get
            the same torque.
        jump: change of the torque at which a step must end, as a share of the largest torque.
    """

    impulse: Array
    cell: float
    per_sample: int
    initial: Array
    jump: float = _JUMP

    def with_torque(self, torque: Array) -> Delivered:
        """Return the command with an added constant torque (B,) [N m] that bypasses the actuators.

        In space the torque is complex and the same for all sections.
        """
        added = self._with(torque, np.arange(self.impulse.shape[1]))
        return replace(added, initial=self.initial + self._loads(torque))

    def with_torque_between(self, torque: Array, begin: float, end: float) -> Delivered:
        """Return the command with an added torque (B,) [N m] from ``begin`` to ``end`` [s] after the start.

        It is added for at least one cell; the torque before the start is unchanged.
        """
        first = round(begin / self.cell)
        return self._with(torque, np.clip(np.arange(self.impulse.shape[1]) - first, 0, max(1, round(end / self.cell) - first)))

    def _with(self, torque: Array, cells: NDArray[np.int_]) -> Delivered:
        loads = self._loads(torque)
        return replace(self, impulse=self.impulse + loads[:, None] * cells.reshape(-1, *[1] * (loads.ndim - 1)))

    def _loads(self, torque: Array) -> Array:
        if self.impulse.ndim < 3:
            return torque
        return np.tile(np.stack([torque.real, torque.imag], axis=1), self.impulse.shape[2] // 2)

    @cached_property
    def until(self) -> Array:
        """For each cell, the next cell end (B, C + 1) at which the torque jumps, or the end of the command."""
        return self._next(self._jumps)

    @cached_property
    def until_together(self) -> Array:
        """For each cell, the next cell end (1, C + 1) at which the torque of any arm jumps, for arms with common steps."""
        return self._next(np.asarray(self._jumps.any(axis=0, keepdims=True)))

    @property
    def _jumps(self) -> NDArray[np.bool_]:
        """Whether the torque jumps from one cell to the next (B, C - 1)."""
        with np.errstate(over="ignore", invalid="ignore"):  # an excessive torque is reported later, as a motion that diverges
            torque = np.diff(self.impulse, axis=1)
            largest = np.maximum(np.abs(torque).max(axis=1, keepdims=True), 1e-12)
            jumps = np.abs(np.diff(torque, axis=1)) > self.jump * largest
        return np.asarray(jumps.any(axis=2) if jumps.ndim == 3 else jumps)

    @staticmethod
    def _next(jumps: NDArray[np.bool_]) -> Array:
        cells = jumps.shape[1] + 1
        ends = np.full((len(jumps), cells + 1), float(cells))
        ends[:, : cells - 1] = np.where(jumps, np.arange(1.0, cells), cells)
        return np.ascontiguousarray(np.minimum.accumulate(ends[:, ::-1], axis=1)[:, ::-1])


def deliver(
    batch: ArmBatch,
    torque: Array,
    initial: Array,
    step: float,
    *,
    interpolated: bool = False,
    substeps: int = 1,
    smooth: bool = False,
    apply_law: Callable[[ArmBatch, Effect, Array, float], Array] | None = None,
) -> Delivered:
    """Compute the torque that the actuators of all arms deliver for a command.

    Args:
        batch: the arms.
        torque: (S, B) or (S, 1) command at the samples [N m]; complex in space.
        initial: (B,) or (1,) command before the first sample [N m]; complex in space.
        step: sampling interval [s].
        interpolated: whether the command is interpolated linearly between samples instead of held.
        substeps: smallest number of cells per sample.
        smooth: whether a command that is a curve may be smoothed, so that steps need not end at its samples. The small steps of a
            held command are then replaced by ramps that are faster than an arm can follow; the integral of the torque over them
            is unchanged.
        apply_law: function that applies an effect's law to torques (C, B); default: :func:`apply_numpy_law`.
    """
    steps = _small_steps(torque) if smooth else torque[:0]
    per_sample = cells_in(
        step, substeps, batch.has_actuator_memory or interpolated or len(steps) > 0, _FINE if len(steps) else CELL
    )
    held = np.repeat(torque[:-1], per_sample, axis=0)
    if interpolated:
        share = (np.arange(per_sample) + 0.5) / per_sample
        held = held + np.repeat(np.diff(torque, axis=0), per_sample, axis=0) * np.tile(share, len(torque) - 1)[:, None]
    elif len(steps):
        _spread(held.reshape(-1, per_sample, held.shape[1]), steps, min(per_sample // 2, round(_SPREAD / 2 / step * per_sample)))
    width = len(batch) if batch.actuator_effects else held.shape[1]
    flow = np.empty((len(held) + 1, width), dtype=held.dtype)  # the first row is the constant torque before the first sample
    flow[0], flow[1:] = initial, held
    cell = step / per_sample
    for effect in batch.actuator_effects:
        flow = _delayed(flow, np.broadcast_to(effect.command_delay(), len(batch)), cell)
        if effect.acts_through("actuator_response"):
            flow = (apply_law or apply_numpy_law)(batch, effect, flow, cell)
    with np.errstate(over="ignore"):  # an excessive torque is reported later, as a motion that diverges
        impulse = np.vstack([np.zeros(width), flow[1:].cumsum(axis=0)]).T
    return Delivered(np.ascontiguousarray(impulse), cell, per_sample, flow[0], _SMOOTH_JUMP if len(steps) else _JUMP)


def cells_in(step: float, substeps: int, fine: bool, longest: float = CELL) -> int:
    """Return the number of cells for a command held for ``step`` [s]; more than ``substeps`` if ``fine`` cells must be short."""
    return max(substeps, ceil(step / longest - 1e-6)) if fine else substeps


def _small_steps(torque: Array) -> Array:
    """Return the changes (S - 2, B) of a command (S, B) between samples, with large changes set to 0.

    The result is empty (0, B) if the command is not a curve.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        change = np.diff(torque[:-1], axis=0)
        share = (np.abs(change) / np.maximum(np.abs(torque).max(axis=0), 1e-12)).max(axis=1, initial=0.0)
    small = share <= _SMALL
    curve = np.count_nonzero(small & (share > _JUMP)) >= _CURVE * max(len(share), 1)
    return change * small[:, None] if curve else change[:0]


def _spread(held: Array, steps: Array, reach: int) -> None:
    """Replace the steps (S - 2, B) of a command (S - 1, cells, B) by ramps of ``reach`` cells to both sides, in place."""
    for k in range(reach):
        share = (k + 0.5) / (2 * reach)
        held[:-1, held.shape[1] - reach + k] += share * steps
        held[1:, reach - 1 - k] -= share * steps


def _delayed(flow: Array, delay: Array, cell: float) -> Array:
    """Return torques (C, B) delayed by ``delay`` (B,) [s], as cell means; the first row is the constant torque before."""
    if not delay.any():
        return flow
    ends = np.arange(len(flow)) * 1.0
    late = flow.copy()
    for b, lag in enumerate(delay / cell):
        impulse = np.append(0.0, flow[1:, b].cumsum())
        shifted = ends - lag
        passed = np.where(shifted < 0, shifted * flow[0, b], np.interp(shifted, ends, impulse))
        late[1:, b] = np.diff(passed)
    return late


def apply_numpy_law(batch: ArmBatch, effect: Effect, flow: Array, cell: float) -> Array:
    """Apply an effect's law to torques (C, B) with NumPy; the first row is the constant torque before the start."""
    p, memory = effect.p, (flow[0],) * effect.memories
    answers = np.empty_like(flow)
    for n, torque in enumerate(flow):
        answers[n], memory = effect.actuator_response(p, torque, memory, cell, batch.nominal.keq)
    return answers


def apply_compiled_law(batch: ArmBatch, effect: Effect, flow: Array, cell: float) -> Array:
    """Apply an effect's law to torques (C, B) with compiled code; the first row is the constant torque before the start."""
    from ctypes import CFUNCTYPE, c_double, c_int64, c_void_p

    from hsr_pin.simulation.laws import address

    begin = address(effect, "actuator_response", space=np.iscomplexobj(flow))
    loop = CFUNCTYPE(None, *[c_void_p] * 4, c_int64, c_int64, c_double)(begin)
    answers, numbers, keq = np.empty_like(flow), batch.numbers_of(effect), np.ascontiguousarray(batch.nominal.keq)
    loop(flow.ctypes.data, keq.ctypes.data, numbers.ctypes.data, answers.ctypes.data, *flow.shape, cell)
    return answers
