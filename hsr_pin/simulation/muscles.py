"""What the muscles make of commands that come step by step, and what they remember of those before."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import cells_in
from hsr_pin.simulation.integrator import substeps
from hsr_pin.trajectory import Array


class Past(NamedTuple):
    """What one effect remembers.

    Attributes:
        lengths: (K,) [s] for which each of the last torques was held, the newest first; the last of them for ever.
        torques: (K, B) [N m].
        memory: (B,) each; see :meth:`hsr_pin.effects.effect.Effect.respond`.
    """

    lengths: Array
    torques: Array
    memory: tuple[Any, ...]


class Muscles:
    """The effects on the command of B arms, as :func:`hsr_pin.simulation.command.deliver` applies them, cell by cell.

    Args:
        columns: the arms.
        step: largest step of the integrator [s].
    """

    def __init__(self, columns: Columns, step: float) -> None:
        self._step = step
        self._keq, self._remembering = columns.nominal.keq, columns.remembering
        self._effects = [(e, e.p, np.broadcast_to(e.late(), len(columns))) for e in columns.muscles]

    def rested(self, torque: Array) -> tuple[Array, tuple[Past, ...]]:
        """The torque (B,) [N m] that arrives of one commanded for ever, and what is remembered of it."""
        pasts = []
        for effect, p, _ in self._effects:
            before = torque
            torque, memory = effect.respond(p, before, (before,) * effect.memories, 1.0, self._keq)
            pasts.append(Past(np.array([np.inf]), before[None], memory))
        return torque, tuple(pasts)

    def hold(self, torque: Array, duration: float, pasts: tuple[Past, ...]) -> tuple[Array, float, tuple[Past, ...]]:
        """Hold a command.

        Args:
            torque: (B,) [N m].
            duration: [s].
            pasts: what is remembered.

        Returns:
            (B, C + 1) the integral of what arrives, in N m times cells; the length of a cell [s]; what is remembered then.
        """
        cells, cell, ramp = _divided(duration, self._step, self._remembering)
        if not self._effects:
            return torque[:, None].dot(ramp), cell, ()  # a product of two numbers each, at once
        flow = np.empty((cells + 1, len(torque)), dtype=torque.dtype)
        flow[0], flow[1:] = 0.0, torque
        for place, (effect, p, delay) in enumerate(self._effects):
            past = pasts[place]
            for n in range(1, cells + 1):
                if effect.acts_through("late"):
                    flow[n], past = _late(flow[n], past, delay, cell)
                flow[n], memory = effect.respond(p, flow[n], past.memory, cell, self._keq)
                past = past._replace(memory=memory)
            pasts = (*pasts[:place], past, *pasts[place + 1 :])
        return flow.cumsum(axis=0).T.copy(), cell, tuple(pasts)

    @staticmethod
    def renewed(chosen: NDArray[np.bool_], fresh: Sequence[Past], pasts: Sequence[Past]) -> tuple[Past, ...]:
        """``pasts`` where the ``chosen`` (B,) arms have at rest what they remember in ``fresh``."""
        return tuple(
            Past(
                old.lengths,
                np.where(chosen, new.torques[-1], old.torques),
                tuple(np.where(chosen, a, b) for a, b in zip(new.memory, old.memory, strict=True)),
            )
            for new, old in zip(fresh, pasts, strict=True)
        )


@lru_cache(maxsize=64)
def _divided(duration: float, step: float, remembering: bool) -> tuple[int, float, Array]:
    """The cells of a step [s], their length [s], and the numbers from 0 to their number as a row."""
    cells = cells_in(duration, substeps(duration, step), remembering)
    return cells, duration / cells, np.arange(cells + 1.0)[None]


def _late(torque: Array, past: Past, delay: Array, step: float) -> tuple[Array, Past]:
    """The mean over a step [s] of torques that come later by ``delay`` (B,) [s]."""
    lengths, torques = np.append(step, past.lengths), np.vstack([torque, past.torques])
    ages = np.append(0.0, lengths.cumsum())[:, None]  # of their ends, when this step ends
    heard = np.maximum(np.minimum(ages[1:], delay + step) - np.maximum(ages[:-1], delay), 0.0)  # [s] in this step
    needed = max(1, int(np.count_nonzero(ages[:-1] < delay.max())))
    lengths = np.append(lengths[: needed - 1], np.inf)
    return (heard / heard.sum(axis=0) * torques).sum(axis=0), Past(lengths, torques[:needed], past.memory)
