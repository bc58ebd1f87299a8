"""What arrives at the arms of a command: held or interpolated between samples, then what the muscles make of it.

A command that is known is passed through as a whole (:func:`deliver`), one that comes step by step by :class:`Muscles`; both in
the same cells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Where the muscles have a memory, or the command is interpolated, the torque is even over cells no longer than this [s].
CELL = 0.005
#: No step passes a change of the torque by more than this share of its largest, either way; of one that may be smooth, by more
#: than this.
_JUMP, _SMOOTH_JUMP = 0.02, 0.05
#: A command is a curve if at least this share of its samples change by more than steps may pass, but by no more than so much of
#: the largest. Where it may be smooth, small changes are spread over this long [s] about their instant, in cells of so much.
_CURVE, _SMALL, _SPREAD, _FINE = 0.1, 0.12, 0.01, 0.0025


@dataclass(frozen=True, eq=False)
class Delivered:
    """Torque over time, even within cells.

    Attributes:
        impulse: (B, C + 1) its integral, in N m times cells; in space complex, or (B, C + 1, U) with the loads. One row where all
            arms get the same.
        cell: [s].
        per_sample: cells from sample to sample.
        initial: (B,) [N m] before the first; in space complex, or (B, U). Likewise.
        jump: share of its largest by which it changes where a step has to end.
    """

    impulse: Array
    cell: float
    per_sample: int
    initial: Array
    jump: float = _JUMP

    def beside(self, torque: Array) -> Delivered:
        """With a torque (B,) [N m] that no muscle passes on, always there; in space complex, the same for all sections."""
        added = self._with(torque, np.arange(self.impulse.shape[1]))
        return replace(added, initial=self.initial + self._loads(torque))

    def beside_at_first(self, torque: Array, begin: float, end: float) -> Delivered:
        """Likewise from ``begin`` to ``end`` [s] after the start alone, of a cell at least; what was before stays."""
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
        """(B, C + 1) for each cell the next end of a cell at which the torque jumps, or the end of all."""
        return self._next(self._jumps)

    @cached_property
    def until_together(self) -> Array:
        """(1, C + 1) likewise for arms that step together: at which that of any of them does."""
        return self._next(np.asarray(self._jumps.any(axis=0, keepdims=True)))

    @property
    def _jumps(self) -> NDArray[np.bool_]:
        """(B, C - 1) whether the torque jumps from one cell to the next."""
        with np.errstate(over="ignore", invalid="ignore"):  # a torque that no arm bears is a motion that diverges
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
    columns: Columns,
    torque: Array,
    initial: Array,
    step: float,
    *,
    interpolated: bool = False,
    substeps: int = 1,
    smooth: bool = False,
    respond: Callable[[Columns, Effect, Array, float], Array] | None = None,
) -> Delivered:
    """Pass a command through the muscles of all columns.

    Args:
        columns: the arms.
        torque: (S, B) or (S, 1) [N m] at the samples; in space complex.
        initial: (B,) or (1,) [N m] before the first, likewise.
        step: from sample to sample [s].
        interpolated: the command goes straight from sample to sample instead of being held.
        substeps: cells in a sample, at least.
        smooth: a command that is a curve may be taken as one, so that steps need not end at its samples. A held one is changed
            by a saw of its small steps that is faster than an arm follows; the torque's integral over them stays.
        respond: how an effect's law is applied to (C, B) torques; default: :func:`by_law`.
    """
    steps = _small_steps(torque) if smooth else torque[:0]
    per_sample = cells_in(step, substeps, columns.remembering or interpolated or len(steps) > 0, _FINE if len(steps) else CELL)
    held = np.repeat(torque[:-1], per_sample, axis=0)
    if interpolated:
        share = (np.arange(per_sample) + 0.5) / per_sample
        held = held + np.repeat(np.diff(torque, axis=0), per_sample, axis=0) * np.tile(share, len(torque) - 1)[:, None]
    elif len(steps):
        _spread(held.reshape(-1, per_sample, held.shape[1]), steps, min(per_sample // 2, round(_SPREAD / 2 / step * per_sample)))
    width = len(columns) if columns.muscles else held.shape[1]
    flow = np.empty((len(held) + 1, width), dtype=held.dtype)  # the first row is what was before, for ever
    flow[0], flow[1:] = initial, held
    cell = step / per_sample
    for effect in columns.muscles:
        flow = _late(flow, np.broadcast_to(effect.late(), len(columns)), cell)
        if effect.acts_through("respond"):
            flow = (respond or by_law)(columns, effect, flow, cell)
    with np.errstate(over="ignore"):  # a torque that no arm bears is a motion that diverges
        impulse = np.vstack([np.zeros(width), flow[1:].cumsum(axis=0)]).T
    return Delivered(np.ascontiguousarray(impulse), cell, per_sample, flow[0], _SMOOTH_JUMP if len(steps) else _JUMP)


def cells_in(step: float, substeps: int, fine: bool, longest: float = CELL) -> int:
    """Cells in which a command held for ``step`` [s] is passed on: ``substeps`` at least, and where ``fine`` none is long."""
    return max(substeps, ceil(step / longest - 1e-6)) if fine else substeps


def _small_steps(torque: Array) -> Array:
    """(S - 2, B) by how much a command (S, B) changes from one sample to the next where that is little, else 0.

    None (0, B) if the command is no curve.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        change = np.diff(torque[:-1], axis=0)
        share = (np.abs(change) / np.maximum(np.abs(torque).max(axis=0), 1e-12)).max(axis=1, initial=0.0)
    small = share <= _SMALL
    curve = np.count_nonzero(small & (share > _JUMP)) >= _CURVE * max(len(share), 1)
    return change * small[:, None] if curve else change[:0]


def _spread(held: Array, steps: Array, reach: int) -> None:
    """In a command (S - 1, cells, B), ramps over ``reach`` cells before and after in place of its steps (S - 2, B)."""
    for k in range(reach):
        share = (k + 0.5) / (2 * reach)
        held[:-1, held.shape[1] - reach + k] += share * steps
        held[1:, reach - 1 - k] -= share * steps


def _late(flow: Array, delay: Array, cell: float) -> Array:
    """(C, B) the mean over each cell of torques that come later by ``delay`` (B,) [s]; the first row was there for ever."""
    if not delay.any():
        return flow
    ends = np.arange(len(flow)) * 1.0
    late = flow.copy()
    for b, lag in enumerate(delay / cell):
        impulse = np.append(0.0, flow[1:, b].cumsum())
        heard = ends - lag
        passed = np.where(heard < 0, heard * flow[0, b], np.interp(heard, ends, impulse))
        late[1:, b] = np.diff(passed)
    return late


def by_law(columns: Columns, effect: Effect, flow: Array, cell: float) -> Array:
    """An effect's law on torques (C, B), the first row for ever before, by NumPy."""
    p, memory = effect.p, (flow[0],) * effect.memories
    answers = np.empty_like(flow)
    for n, torque in enumerate(flow):
        answers[n], memory = effect.respond(p, torque, memory, cell, columns.nominal.keq)
    return answers


def by_machine(columns: Columns, effect: Effect, flow: Array, cell: float) -> Array:
    """The same by compiled code."""
    from ctypes import CFUNCTYPE, c_double, c_int64, c_void_p

    from hsr_pin.simulation.laws import address

    begin = address(effect, "respond", space=np.iscomplexobj(flow))
    loop = CFUNCTYPE(None, *[c_void_p] * 4, c_int64, c_int64, c_double)(begin)
    answers, numbers, keq = np.empty_like(flow), columns.numbers_of(effect), np.ascontiguousarray(columns.nominal.keq)
    loop(flow.ctypes.data, keq.ctypes.data, numbers.ctypes.data, answers.ctypes.data, *flow.shape, cell)
    return answers
