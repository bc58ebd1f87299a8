"""The actuator response to commands that arrive step by step, and the memory of the actuators."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.command import cells_in
from hsr_pin.simulation.integrator import substeps
from hsr_pin.trajectory import Array


class ActuatorMemory(NamedTuple):
    """The memory of one effect on the command.

    Attributes:
        lengths: (K,) durations of the last torques, the newest first [s]; the last duration is infinite.
        torques: (K, B) the last torques [N m].
        memory: memory of the effect, (B,) each; see :meth:`hsr_pin.effects.effect.Effect.actuator_response`.
    """

    lengths: Array
    torques: Array
    memory: tuple[Any, ...]


class Actuators:
    """The effects on the command of B arms, applied cell by cell as :func:`hsr_pin.simulation.command.deliver` does.

    Args:
        batch: the arms.
        step: largest step of the integrator [s].
    """

    def __init__(self, batch: ArmBatch, step: float) -> None:
        self._step = step
        self._keq, self._has_memory = batch.nominal.keq, batch.has_actuator_memory
        self._effects = [(e, e.p, np.broadcast_to(e.command_delay(), len(batch))) for e in batch.actuator_effects]

    def settled(self, torque: Array) -> tuple[Array, tuple[ActuatorMemory, ...]]:
        """Return the torque (B,) [N m] that arrives for a constant command, and the settled memories."""
        memories = []
        for effect, p, _ in self._effects:
            before = torque
            torque, memory = effect.actuator_response(p, before, (before,) * effect.memories, 1.0, self._keq)
            memories.append(ActuatorMemory(np.array([np.inf]), before[None], memory))
        return torque, tuple(memories)

    def hold(
        self, torque: Array, duration: float, memories: tuple[ActuatorMemory, ...]
    ) -> tuple[Array, float, tuple[ActuatorMemory, ...]]:
        """Hold a command for one step.

        Args:
            torque: (B,) command [N m].
            duration: duration of the step [s].
            memories: memories of the effects before the step.

        Returns:
            The integral of the delivered torque (B, C + 1) [N m times cells]; the length of a cell [s]; the memories after the
            step.
        """
        cells, cell, ramp = _divided(duration, self._step, self._has_memory)
        if not self._effects:
            return torque[:, None].dot(ramp), cell, ()  # the fastest way to multiply
        flow = np.empty((cells + 1, len(torque)), dtype=torque.dtype)
        flow[0], flow[1:] = 0.0, torque
        for place, (effect, p, delay) in enumerate(self._effects):
            remembered = memories[place]
            for n in range(1, cells + 1):
                if effect.acts_through("command_delay"):
                    flow[n], remembered = _delayed(flow[n], remembered, delay, cell)
                flow[n], memory = effect.actuator_response(p, flow[n], remembered.memory, cell, self._keq)
                remembered = remembered._replace(memory=memory)
            memories = (*memories[:place], remembered, *memories[place + 1 :])
        return flow.cumsum(axis=0).T.copy(), cell, tuple(memories)

    @staticmethod
    def renewed(
        chosen: NDArray[np.bool_], fresh: Sequence[ActuatorMemory], memories: Sequence[ActuatorMemory]
    ) -> tuple[ActuatorMemory, ...]:
        """Return ``memories`` in which the ``chosen`` (B,) arms have the settled memories of ``fresh``."""
        return tuple(
            ActuatorMemory(
                old.lengths,
                np.where(chosen, new.torques[-1], old.torques),
                tuple(np.where(chosen, a, b) for a, b in zip(new.memory, old.memory, strict=True)),
            )
            for new, old in zip(fresh, memories, strict=True)
        )


@lru_cache(maxsize=64)
def _divided(duration: float, step: float, remembering: bool) -> tuple[int, float, Array]:
    """Return the number of cells of a step [s], their length [s], and the numbers from 0 to the number of cells as a row."""
    cells = cells_in(duration, substeps(duration, step), remembering)
    return cells, duration / cells, np.arange(cells + 1.0)[None]


def _delayed(torque: Array, remembered: ActuatorMemory, delay: Array, step: float) -> tuple[Array, ActuatorMemory]:
    """Return the mean torque over a step [s] of a torque that arrives after a ``delay`` (B,) [s], and the new memory."""
    lengths, torques = np.append(step, remembered.lengths), np.vstack([torque, remembered.torques])
    ages = np.append(0.0, lengths.cumsum())[:, None]  # [s] before the end of this step
    arriving = np.maximum(np.minimum(ages[1:], delay + step) - np.maximum(ages[:-1], delay), 0.0)  # [s] duration within this step
    needed = max(1, int(np.count_nonzero(ages[:-1] < delay.max())))
    lengths = np.append(lengths[: needed - 1], np.inf)
    return (arriving / arriving.sum(axis=0) * torques).sum(axis=0), ActuatorMemory(lengths, torques[:needed], remembered.memory)
