"""Columns from their start to their last sample: by the compiled loops or by those over Pinocchio."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError
from hsr_pin.simulation import march, reference, rest
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered, by_law, by_machine, deliver
from hsr_pin.simulation.compiled import Loops, loops
from hsr_pin.simulation.integrator import FIRST, LONGEST, Integrator
from hsr_pin.trajectory import Array

Dynamics = Literal["compiled", "aba", "rnea"]
#: More links than these are simulated by the compiled loops.
MANY_LINKS = 64


def usual(links: int, space: bool) -> Dynamics:
    """Pinocchio for arms of few links; its memory grows with their cube, that of the compiled loops with their number."""
    if links > MANY_LINKS:
        return "compiled"
    return "rnea" if space else "aba"


@dataclass(frozen=True, eq=False)
class State:
    """What B arms are at one instant.

    Attributes:
        q, v: (B, N) [rad], [rad/s]; in space (B, 3 N).
        z: (states, B, N) memories of the laws in the joints.
    """

    q: Array
    v: Array
    z: Array


@dataclass(frozen=True, eq=False)
class Motion:
    """Of B arms.

    Attributes:
        angles, rates: (S, B, N) [rad], [rad/s] at the samples; 0 after a failure.
        lost: (B,) [s] from the start to the end of the step in which an arm went beyond its limit, or had no number; infinite:
            never.
        beyond: (B, N) [rad] where they were then.
        end: the state after the last step.
        steps: [s] the lengths of those that all took; none where each took its own.
    """

    angles: Array
    rates: Array
    lost: Array
    beyond: Array
    end: State
    steps: Array


class Engine:
    """The loops with the arms that they move.

    Args:
        columns: the arms.
        dynamics: "compiled", or "aba" or "rnea" over Pinocchio.
    """

    def __init__(self, columns: Columns, dynamics: Dynamics) -> None:
        if dynamics not in get_args(Dynamics):
            raise InputError("dynamics", expected=" or ".join(get_args(Dynamics)), received=repr(dynamics))
        self.columns, self._limit = columns, np.ascontiguousarray(columns.arms.bending_limit)
        self._compiled, self._space = dynamics == "compiled", columns.space
        self._system: Any
        self._brief: Callable[..., int]
        if columns.space and dynamics == "aba":
            raise InputError("dynamics", expected="compiled or rnea for an arm in space", received="'aba'")
        if columns.space:
            from hsr_pin.simulation.space.reference import python_loops

            self._loops = _space_loops() if self._compiled else python_loops()
            self._system = columns.system if self._compiled else columns.pinocchio(dynamics)
            self._arrays = self._system if self._compiled else columns.arrays
        elif self._compiled:
            self._loops, self._system, self._arrays = loops(), columns.system, columns.system
            self._brief = partial(self._loops.advance, *columns.system.in_few())
        else:
            self._loops = Loops(march.march, march.march_apart, march.advance, rest.rest)
            self._system, self._arrays = columns.pinocchio(dynamics), columns.arrays

    def deliver(
        self, torque: Array, initial: Array, step: float, *, interpolated: bool = False, substeps: int = 1, smooth: bool = False
    ) -> Delivered:
        """As :func:`hsr_pin.simulation.command.deliver`; complex in space: (T, B, S), or (T, B) for all sections alike."""
        respond = by_machine if self._compiled else by_law
        given = partial(
            deliver, self.columns, step=step, interpolated=interpolated, substeps=substeps, smooth=smooth, respond=respond
        )
        if not self.columns.space:
            return given(torque, initial)
        from hsr_pin.simulation.space.drive import in_components

        if torque.ndim == 2:
            torque, initial = torque[..., None], initial[:, None]
        torque, initial = self._by_section(torque), self._by_section(initial)
        each = list(zip(np.moveaxis(torque, 2, 0), np.moveaxis(initial, 1, 0), strict=True))
        parts = [given(part, before) for part, before in each]
        if len({part.per_sample for part in parts}) > 1:  # the command of one section is a curve, of another it is not
            parts = [given(part, before, smooth=False) for part, before in each]
        return in_components(parts)

    def settled(self, torque: Array, wanted: NDArray[np.bool_], near: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Where the arms rest under constant torques.

        Args:
            torque: (B,) or (1,) [N m] that arrives; in space complex, of S sections (B, S), or (B, 2 S) and loads.
            wanted: (B,) columns to solve for.
            near: (B, N) [rad] where the search begins.

        Returns:
            (B, N) [rad], 0 where there is no such pose or none was wanted, and (B,) whether there is one.
        """
        if np.iscomplexobj(torque):
            torque = self._by_section(torque if torque.ndim == 2 else torque[:, None])
            torque = np.stack([torque.real, torque.imag], axis=2).reshape(len(torque), -1)
        q, found = np.array(near, order="C"), np.zeros(len(near), dtype=bool)
        with np.errstate(all="ignore"):
            self._loops.rest(self._system, self._arrays, self._of_each(torque), wanted, q, found, self.columns.states)
        return q, found

    def _of_each(self, given: Array) -> Array:
        """(B, ...) in one block, of that or of one row for all."""
        return np.ascontiguousarray(given if len(given) == len(self.columns) else np.repeat(given, len(self.columns), axis=0))

    def _by_section(self, torque: Array) -> Array:
        """(..., S) for each section, of (..., S), or of (..., 1) for all alike."""
        count = self._arrays.inputs.shape[1]
        if torque.shape[-1] not in (1, count):
            raise InputError("torque", expected=f"one for each of {count} sections, or one for all", received=torque.shape[-1])
        return np.broadcast_to(torque, (*torque.shape[:-1], count))

    def loaded(self, q: Array, v: Array) -> State:
        """The state of arms at q, v (B, N) that were never bent before and settled there."""
        columns = self.columns
        z = np.zeros((columns.states, len(columns), columns.links), dtype=complex if columns.space else float)
        if len(z):
            reached = _bends(q) if columns.space else q
            reference.remembered(columns.laws, z.copy(), np.zeros_like(reached), reached, inf, z)
        return State(np.array(q), np.array(v), z)

    def advance(self, state: Array, impulse: Array, cell: float, weights: Array) -> int:
        """As :func:`hsr_pin.simulation.march.advance`: angles, rates and memories are one (2 + states, B, N).

        In space (2 + states, B, 3 N), memories as vectors; the impulse (B, C + 1), or (B, C + 1, S), is then complex.
        """
        if self._space:
            given = self._by_section(impulse if impulse.ndim == 3 else impulse[..., None])
            torque = np.stack([given.real, given.imag], axis=3).reshape(*given.shape[:2], -1)
            z = np.array(self.columns.bends(state[2:]), order="C")
            with np.errstate(all="ignore"):
                gone = self._loops.advance(self._system, state[0], state[1], z, torque, cell, weights, self._limit)
            state[2:] = self.columns.rows(z)
            return int(gone)
        if self._compiled:  # there is no time to lose
            return self._brief(state, impulse, cell, weights, self._limit)
        with np.errstate(all="ignore"):
            parts = state[0], state[1], state[2:]
            return int(self._loops.advance(self._system, *parts, impulse, cell, weights, self._limit))

    def run(self, state: State, command: Delivered, samples: int, method: Integrator, found: NDArray[np.bool_]) -> Motion:
        """The motion from a state under a command; columns that are not ``found`` (B,) stay where they are."""
        shape = (samples, *state.q.shape)
        angles, rates = np.zeros(shape), np.zeros(shape)
        lost, beyond = np.where(found, inf, 0.0), np.array(state.q, order="C")
        taken = np.zeros(max(64, 4 * command.impulse.shape[1]))
        q, v, z = (np.array(part, order="C") for part in (state.q, state.v, state.z))
        tolerance, first, longest, until = self._steps(command, method, together=True)
        with np.errstate(all="ignore"):  # a column that diverges is reported as such
            steps = self._loops.march(
                self._system, q, v, z, self._of_each(command.impulse), command.cell, command.per_sample, until[0],
                self.weights(method), float(tolerance[0]), first, longest, self._limit, angles, rates, lost, taken, beyond,
            )  # fmt: skip
        return Motion(angles, rates, lost * command.cell, beyond, State(q, v, z), taken[:steps] * command.cell)

    def run_apart(
        self, state: State, command: Delivered, samples: int, method: Integrator, found: NDArray[np.bool_], threads: int = 1
    ) -> Motion:
        """The same with steps of its own for every column, whose lengths are not told; ``threads`` share the columns."""
        count, links = state.q.shape
        angles, rates = np.zeros((2, count, samples, 1, links))
        lost, beyond = np.where(found, inf, 0.0), np.array(state.q, order="C")
        q, v = np.array(state.q, order="C"), np.array(state.v, order="C")
        z = np.array(state.z.swapaxes(0, 1)[:, :, None], order="C")
        weights, impulse = self.weights(method), self._of_each(command.impulse)
        tolerance, first, longest, until = self._steps(replace(command, impulse=impulse), method)

        def share(begin: int, end: int) -> None:
            with np.errstate(all="ignore"):
                self._loops.apart(
                    self._system, begin, end, q, v, z, impulse, command.cell, command.per_sample, until, weights,
                    tolerance, first, longest, self._limit, angles, rates, lost, beyond,
                )  # fmt: skip

        ends = np.linspace(0, count, max(1, min(threads, count)) + 1).astype(int).tolist()
        if len(ends) == 2:
            share(0, count)
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(share, ends[:-1], ends[1:]))
        angles, rates = (part[:, :, 0].swapaxes(0, 1) for part in (angles, rates))  # (S, B, N)
        last = State(q, v, np.array(z[:, :, 0].swapaxes(0, 1)))
        return Motion(angles, rates, lost * command.cell, beyond, last, np.zeros(0))

    def weights(self, method: Integrator) -> Array:
        """(2, p) of the method that suits the first of the arms."""
        return method.suited(bool(self.columns.ringing[0])).weights

    def _steps(self, command: Delivered, method: Integrator, *, together: bool = False) -> tuple[Array, float, float, Array]:
        """(B,) tolerance in radians; the first and the longest step, in cells; (B, C + 1) what no step may pass.

        Of columns that step ``together`` (1, C + 1).
        """
        if method.step is not None:
            shape = command.impulse.shape[:2]
            until = np.broadcast_to(np.arange(1.0, shape[1] + 1), shape)
            return np.full(len(self.columns), inf), 1.0, 1.0, np.array(until, order="C")
        first, longest = (2.0 ** round(np.log2(time / command.cell)) for time in (FIRST, LONGEST))
        until = command.until_together if together else command.until
        return method.tolerance / self.columns.arms.length, max(first, 1 / 16), max(longest, 1.0), until


def _space_loops() -> Loops:
    from hsr_pin.simulation.space.loops import space_loops  # here: it is for arms in space alone

    return space_loops()


def _bends(q: Array) -> Array:
    from hsr_pin.simulation.space.kernel import bends

    return bends(q)  # type: ignore[no-any-return]  # complex numbers
