"""The motion of a batch from its start to its last sample, by the compiled loops or by the loops with Pinocchio."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation import equilibrium, integrate, reference
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.command import Delivered, apply_compiled_law, apply_numpy_law, deliver
from hsr_pin.simulation.compiled import Loops, loops
from hsr_pin.simulation.contact_rest import rest_among_obstacles
from hsr_pin.simulation.integrator import FIRST, LONGEST, Integrator
from hsr_pin.trajectory import Array

Dynamics = Literal["compiled", "aba", "rnea"]
#: Weights of one step of the linearly implicit Euler method.
_EULER = np.array([[1.0], [0.0]])
#: Factor on the tolerance of a step among obstacles, where the errors of an impact do not average out.
_AMONG_OBSTACLES = 0.3
#: Largest number of links for which the loops with Pinocchio are the default.
MANY_LINKS = 64


def default_dynamics(arm: ArmSpecification | Arms, effects: Sequence[Effect] = ()) -> Dynamics:
    """Return the default dynamics of an arm: Pinocchio for few links, the compiled loops for many or among obstacles.

    The memory of Pinocchio grows with the cube of the number of links, that of the compiled loops linearly.
    """
    if arm.links > MANY_LINKS or arm.obstacles or any(effect.acts_through("obstacle") for effect in effects):
        return "compiled"
    return "rnea" if arm.bending == "space" else "aba"


@dataclass(frozen=True, eq=False)
class State:
    """The state of B arms at one instant.

    Attributes:
        q, v: (B, N) joint angles [rad] and rates [rad/s]; of arms in space (B, 3 N).
        z: (states, B, N) states of the laws in the joints.
    """

    q: Array
    v: Array
    z: Array


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of B arms.

    Attributes:
        angles, rates: (S, B, N) joint angles [rad] and rates [rad/s] at the samples; 0 after a failure.
        lost: (B,) time from the start to the end of the step in which an arm exceeded its limit or diverged [s]; infinite if
            neither occurred.
        beyond: (B, N) joint angles at that time [rad].
        end: the state after the last step.
        steps: lengths of the common steps of all arms [s]; empty if each arm has its own steps.
    """

    angles: Array
    rates: Array
    lost: Array
    beyond: Array
    end: State
    steps: Array


class Engine:
    """The loops together with the arms that they simulate.

    Args:
        batch: the arms.
        dynamics: "compiled", or "aba" or "rnea" with Pinocchio.
    """

    def __init__(self, batch: ArmBatch, dynamics: Dynamics) -> None:
        if dynamics not in get_args(Dynamics):
            raise InputError("dynamics", expected=" or ".join(get_args(Dynamics)), received=repr(dynamics))
        self.dynamics: Dynamics = dynamics
        self.batch, self._limit = batch, np.ascontiguousarray(batch.arms.bending_limit)
        self._compiled, self._space = dynamics == "compiled", batch.space
        self._system: Any
        self._advance_packed: Callable[..., int]
        if batch.space and dynamics == "aba":
            raise InputError("dynamics", expected="compiled or rnea for an arm in space", received="'aba'")
        if batch.space:
            from hsr_pin.simulation.space.reference import python_loops

            self._loops = _space_loops() if self._compiled else python_loops()
            self._system = batch.system if self._compiled else batch.pinocchio(dynamics)
            self._arrays = self._system if self._compiled else batch.arrays
        elif self._compiled:
            self._loops, self._system, self._arrays = loops(), batch.system, batch.system
            self._advance_packed = partial(self._loops.advance, *batch.system.packed())
        else:
            self._loops = Loops(integrate.integrate, integrate.integrate_separately, integrate.advance, equilibrium.equilibrium)
            self._system, self._arrays = batch.pinocchio(dynamics), batch.arrays

    def deliver(
        self, torque: Array, initial: Array, step: float, *, interpolated: bool = False, substeps: int = 1, smooth: bool = False
    ) -> Delivered:
        """Compute the delivered torque as :func:`hsr_pin.simulation.command.deliver` does, in space for each section.

        In space the torque is complex: (T, B, S), or (T, B) if it is the same for all sections.
        """
        apply_law = apply_compiled_law if self._compiled else apply_numpy_law
        given = partial(
            deliver, self.batch, step=step, interpolated=interpolated, substeps=substeps, smooth=smooth, apply_law=apply_law
        )
        if not self.batch.space:
            return given(torque, initial)
        from hsr_pin.simulation.space.drive import in_components

        if torque.ndim == 2:
            torque, initial = torque[..., None], initial[:, None]
        torque, initial = self._by_section(torque), self._by_section(initial)
        each = list(zip(np.moveaxis(torque, 2, 0), np.moveaxis(initial, 1, 0), strict=True))
        parts = [given(part, before) for part, before in each]
        if len({part.per_sample for part in parts}) > 1:  # the commands of some sections are curves, of others they are not
            parts = [given(part, before, smooth=False) for part, before in each]
        return in_components(parts)

    def settled(self, torque: Array, wanted: NDArray[np.bool_], near: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the equilibrium poses of the arms under constant torques.

        Args:
            torque: (B,) or (1,) torque that arrives [N m]; in space complex, (B, S) for S sections, or (B, 2 S) with loads.
            wanted: (B,) whether to solve for each arm.
            near: (B, N) initial poses of the search [rad].

        Returns:
            The poses (B, N) [rad], 0 if there is no equilibrium or none was wanted, and (B,) whether there is one.
        """
        if np.iscomplexobj(torque):
            torque = self._by_section(torque if torque.ndim == 2 else torque[:, None])
            torque = np.stack([torque.real, torque.imag], axis=2).reshape(len(torque), -1)
        if self.batch.world.shape[1]:
            return rest_among_obstacles(self, self._of_each(torque), wanted, near)
        q, found = np.array(near, order="C"), np.zeros(len(near), dtype=bool)
        with np.errstate(all="ignore"):
            self._loops.equilibrium(self._system, self._arrays, self._of_each(torque), wanted, q, found, self.batch.states)
        return q, found

    def of(self, members: NDArray[np.intp]) -> Engine:
        """Return the loops with some of the arms."""
        return Engine(self.batch.members(members), self.dynamics)

    def step_from_rest(self, q: Array, torque: Array, step: float) -> Array:
        """Return the coordinates (B, C) [rad] of arms after a linearly implicit step from rest at q (B, C), of ``step`` [s].

        The torque is (B,) [N m], or (B, U) torques and loads in space. A very long step is one of Newton's.
        """
        state = self.loaded(q, np.zeros_like(q))
        impulse = np.zeros((len(q), 2, *torque.shape[1:]))
        impulse[:, 1] = torque
        after, unlimited = state.q, np.full(len(q), inf)
        with np.errstate(all="ignore"):
            if self._compiled and not self._space:
                whole = np.concatenate([after[None], state.v[None], state.z])
                self._advance_packed(whole, impulse, step, _EULER, unlimited)
                return np.asarray(whole[0])
            self._loops.advance(self._system, after, state.v, state.z, impulse, step, _EULER, unlimited)
        return after

    def _of_each(self, given: Array) -> Array:
        """Return a contiguous array (B, ...), repeating a single row for all arms."""
        return np.ascontiguousarray(given if len(given) == len(self.batch) else np.repeat(given, len(self.batch), axis=0))

    def _by_section(self, torque: Array) -> Array:
        """Return torques (..., S) for all sections, from (..., S) or from (..., 1)."""
        count = self._arrays.inputs.shape[1]
        if torque.shape[-1] not in (1, count):
            raise InputError("torque", expected=f"one for each of {count} sections, or one for all", received=torque.shape[-1])
        return np.broadcast_to(torque, (*torque.shape[:-1], count))

    def loaded(self, q: Array, v: Array) -> State:
        """Return the state of arms at q and v (B, N), with the laws' states of a pose that was reached quasi-statically."""
        batch = self.batch
        z = np.zeros((batch.states, len(batch), batch.links), dtype=complex if batch.space else float)
        if len(z):
            reached = _bends(q) if batch.space else q
            reference.updated_states(batch.laws, z.copy(), np.zeros_like(reached), reached, inf, z)
        return State(np.array(q), np.array(v), z)

    def advance(self, state: Array, impulse: Array, cell: float, weights: Array) -> int:
        """Advance the state in place by steps of one cell each, as :func:`hsr_pin.simulation.integrate.advance`.

        The state is one array (2 + states, B, N) of angles, rates and states of the laws. In space it is (2 + states, B, 3 N),
        with states as vectors; the impulse (B, C + 1), or (B, C + 1, S), is then complex.
        """
        if self._space:
            given = self._by_section(impulse if impulse.ndim == 3 else impulse[..., None])
            torque = np.stack([given.real, given.imag], axis=3).reshape(*given.shape[:2], -1)
            z = np.array(self.batch.bends(state[2:]), order="C")
            with np.errstate(all="ignore"):
                gone = self._loops.advance(self._system, state[0], state[1], z, torque, cell, weights, self._limit)
            state[2:] = self.batch.rows(z)
            return int(gone)
        if self._compiled:  # the fastest path, for real-time use
            return self._advance_packed(state, impulse, cell, weights, self._limit)
        with np.errstate(all="ignore"):
            parts = state[0], state[1], state[2:]
            return int(self._loops.advance(self._system, *parts, impulse, cell, weights, self._limit))

    def run(self, state: State, command: Delivered, samples: int, method: Integrator, found: NDArray[np.bool_]) -> Motion:
        """Return the motion from a state under a command; arms that are not ``found`` (B,) stay in their initial poses."""
        shape = (samples, *state.q.shape)
        angles, rates = np.zeros(shape), np.zeros(shape)
        lost, beyond = np.where(found, inf, 0.0), np.array(state.q, order="C")
        taken = np.zeros(max(64, 4 * command.impulse.shape[1]))
        q, v, z = (np.array(part, order="C") for part in (state.q, state.v, state.z))
        tolerance, first, longest, until = self._steps(command, method, together=True)
        with np.errstate(all="ignore"):  # an arm that diverges is reported as such
            steps = self._loops.integrate(
                self._system, q, v, z, self._of_each(command.impulse), command.cell, command.per_sample, until[0],
                self.weights(method), float(tolerance[0]), first, longest, self._limit, angles, rates, lost, taken, beyond,
            )  # fmt: skip
        return Motion(angles, rates, lost * command.cell, beyond, State(q, v, z), taken[:steps] * command.cell)

    def run_separately(
        self, state: State, command: Delivered, samples: int, method: Integrator, found: NDArray[np.bool_], threads: int = 1
    ) -> Motion:
        """Return the motion with separate step lengths for each arm, which are not reported; ``threads`` divide the arms."""
        count, links = state.q.shape
        angles, rates = np.zeros((2, count, samples, 1, links))
        lost, beyond = np.where(found, inf, 0.0), np.array(state.q, order="C")
        q, v = np.array(state.q, order="C"), np.array(state.v, order="C")
        z = np.array(state.z.swapaxes(0, 1)[:, :, None], order="C")
        weights, impulse = self.weights(method), self._of_each(command.impulse)
        tolerance, first, longest, until = self._steps(replace(command, impulse=impulse), method)

        def share(begin: int, end: int) -> None:
            with np.errstate(all="ignore"):
                self._loops.integrate_separately(
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
        """Return the weights (2, p) of the method that suits the first arm."""
        return method.for_arm(bool(self.batch.ringing[0])).weights

    def _steps(self, command: Delivered, method: Integrator, *, together: bool = False) -> tuple[Array, float, float, Array]:
        """Return tolerances (B,) [rad], the first and the longest step [cells], and the cell ends (B, C + 1) that end a step.

        The cell ends are (1, C + 1) if all arms step ``together``.
        """
        if method.step is not None:
            shape = command.impulse.shape[:2]
            until = np.broadcast_to(np.arange(1.0, shape[1] + 1), shape)
            return np.full(len(self.batch), inf), 1.0, 1.0, np.array(until, order="C")
        first, longest = (2.0 ** round(np.log2(time / command.cell)) for time in (FIRST, LONGEST))
        until = command.until_together if together else command.until
        tolerance = method.tolerance * (_AMONG_OBSTACLES if self.batch.world.shape[1] else 1.0)
        return tolerance / self.batch.arms.length, max(first, 1 / 16), max(longest, 1.0), until


def _space_loops() -> Loops:
    from hsr_pin.simulation.space.loops import space_loops  # late import: needed for arms in space only

    return space_loops()


def _bends(q: Array) -> Array:
    from hsr_pin.simulation.space.kernel import bends

    return bends(q)  # type: ignore[no-any-return]  # complex numbers
