"""Many arms as arrays: bodies, springs, dampers and effect laws of B arms with N joints, (B, N) each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect, effect_subset, stack
from hsr_pin.obstacles import ENTRIES, FRICTION, STIFFNESS, rows_in
from hsr_pin.robot.chain import Arms, chain_of
from hsr_pin.robot.model import build_model, rigid_body
from hsr_pin.robot.sections import along_sections
from hsr_pin.robot.space import base_rotations, space_model
from hsr_pin.robot.specification import joint_arc_lengths
from hsr_pin.simulation.contact import COMPONENTS, compiled, points_per_link
from hsr_pin.simulation.contact import ENTRIES as CONTACT_ENTRIES
from hsr_pin.simulation.integrator import HARDLY_DAMPED
from hsr_pin.simulation.kernel import System
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array

#: Gauss-Legendre points on [0, 1] for the average of a property over the element of the arm that a joint represents.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


@dataclass(frozen=True, eq=False)
class ArmBatch:
    """A batch of B arms with the same structure and with effects of the same types and options.

    Attributes:
        nominal: the arms without the effects on their bodies.
        effects: the effects, with (B,) parameters.
        points: (B, K) arc lengths at which loads act on arms in space [m]; None if there are no loads.
    """

    nominal: Arms
    effects: tuple[Effect, ...]
    points: Array | None = None

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> ArmBatch:
        """Return the batch of the arms of several scenarios."""
        count = len(scenarios[0].effects)
        effects = tuple(stack([scenario.effects[i] for scenario in scenarios]) for i in range(count))
        points = np.array([s.points for s in scenarios]) if scenarios[0].loads else None
        return cls(Arms.of([scenario.arm for scenario in scenarios]), effects, points)

    def __len__(self) -> int:
        return len(self.nominal)

    def members(self, chosen: slice | NDArray[np.intp] | NDArray[np.bool_]) -> ArmBatch:
        """Return a batch of some of the arms, selected by a slice, an array of indices or a Boolean mask."""
        points = None if self.points is None else self.points[chosen]
        return ArmBatch(self.nominal.subset(chosen), tuple(effect_subset(effect, chosen) for effect in self.effects), points)

    @property
    def links(self) -> int:
        """Number N of links of each arm."""
        return self.nominal.links

    @property
    def space(self) -> bool:
        """Whether the arms bend in space."""
        return self.nominal.bending == "space"

    @property
    def coordinates(self) -> int:
        """Number of joint coordinates of each arm: N in the plane, 3 N in space."""
        return (3 if self.space else 1) * self.links

    def evenly(self, bending: Array) -> Array:
        """Return the joint angles (B, N) [rad] of arms that are bent uniformly by (B,) [rad].

        For arms in space the bending is complex, and the coordinates are (B, 3 N).
        """
        return self.rows(np.repeat(bending[:, None] / self.links, self.links, axis=1))

    def rows(self, bends: Array) -> Array:
        """Return coordinate rows (..., 3 N) for complex bending (..., N); the inverse of :meth:`bends`.

        Rows of planar arms are returned unchanged.
        """
        if not self.space:
            return bends
        return np.stack([bends.real, bends.imag, np.zeros(bends.shape)], axis=-1).reshape(*bends.shape[:-1], 3 * self.links)

    def by_joint(self, angles: Array) -> Array:
        """Return coordinate rows by joint: (..., N) in the plane, (..., N, 3) in space."""
        return angles.reshape(*angles.shape[:-1], self.links, 3) if self.space else angles

    def bends(self, angles: Array) -> Array:
        """Return the bending of each joint (..., N): real in the plane, complex and without twist in space."""
        return np.asarray(angles[..., 0::3] + 1j * angles[..., 1::3] if self.space else angles)

    @cached_property
    def arms(self) -> Arms:
        """The arms with the changes that the effects make to their rigid bodies and their mount."""
        arms = self.nominal
        for effect in self.effects:
            arms = effect.arm(arms)  # type: ignore[arg-type, assignment]  # the numbers of an arm, as arrays
        return arms

    @cached_property
    def ringing(self) -> NDArray[np.bool_]:
        """Whether each arm (B,) is lightly damped, judged by its stiffness, damping and inertia about the base."""
        inertia = self.arms.length**2 * (self.arms.mass / 3 + self.arms.tip_mass)
        return np.asarray(self.arms.damping < 2 * HARDLY_DAMPED * np.sqrt(self.arms.keq * inertia))

    @cached_property
    def laws(self) -> tuple[Effect, ...]:
        """The effects that act as moments in the joints or as contact forces on the arm."""
        return tuple(effect for effect in self.effects if effect.acts_through("moment") or effect.acts_through("contact_force"))

    @cached_property
    def actuator_effects(self) -> tuple[Effect, ...]:
        """The effects that act on the command."""
        return tuple(
            effect for effect in self.effects if effect.acts_through("actuator_response") or effect.acts_through("command_delay")
        )

    @cached_property
    def has_actuator_memory(self) -> bool:
        """Whether an effect on the command has a memory or a delay."""
        return any(effect.memories or effect.acts_through("command_delay") for effect in self.actuator_effects)

    @property
    def states(self) -> int:
        """Number of internal states of the laws and of friction with obstacles, per joint."""
        rubbing = self.touch[2] >= 0
        return self._law_states + (int(self.touch[3]) * COMPONENTS if rubbing else 0)

    @property
    def _law_states(self) -> int:
        return sum(law.states for law in self.laws)

    @cached_property
    def frames(self) -> Array:
        """The axes (B, 3, 3) of the bases in the world, as rows.

        In a plane: along the straight arm, towards positive bending, sideways; in space: towards positive bending, sideways,
        along.
        """
        if self.space:
            return base_rotations(self.arms).swapaxes(1, 2)
        along, across = self.arms.frame()
        return np.stack([along, across, np.cross(along, across)], axis=1)

    @cached_property
    def world(self) -> Array:
        """The obstacles (B, O, ENTRIES) as :mod:`hsr_pin.simulation.contact` gets them."""
        arms = self.arms
        if not arms.obstacles and not any(effect.acts_through("obstacle") for effect in self.effects):
            return np.zeros((len(self), 0, CONTACT_ENTRIES))
        rows = rows_in(self.frames, arms.obstacles)
        own = [found for e in self.effects if (found := e.obstacle(arms.length, arms.diameter)) is not None]
        each = (np.broadcast_to(row, (len(self), ENTRIES))[:, None] for row in own if np.any(row[..., STIFFNESS]))
        rows = np.concatenate([rows, *each], axis=1)
        skin = np.empty((*rows.shape[:2], 3))
        radius = arms.diameter / 2
        start = joint_arc_lengths(arms.links, arms.placement)[0] * arms.length
        skin[:] = np.stack([radius, radius, start], axis=-1)[:, None]
        return np.concatenate([rows, skin], axis=2)

    @cached_property
    def touch(self) -> NDArray[np.int64]:
        """The contact law without addresses; see :class:`hsr_pin.simulation.kernel.System`."""
        points, first = 0, -1
        if self.world.shape[1]:
            points = points_per_link(chain_of(self.arms).reach, self.arms.diameter)
            first = self._law_states if self.world[..., FRICTION].any() else -1
        return np.array([0, 0, first, points], dtype=np.int64)

    @cached_property
    def arrays(self) -> Any:
        """The arrays for the loops, except the machine code of the laws (whose rows are empty)."""
        arms, links = self.arms, self.links
        sections = along_sections(arms.sections, links) if arms.sections else (1.0, 1.0)
        profile = along(self.effects, "stiffness", links, len(self)) * sections[0]
        keq, damping = arms.keq[:, None], arms.damping[:, None]
        spring = links * keq * profile
        damper = links * damping * along(self.effects, "damping", links, len(self)) * sections[1]
        stiff, drag = spring.copy(), damper.copy()
        for effect in self.effects:
            stiffness, resistance = effect.tangent(arms.keq, arms.length)
            stiff += links * np.broadcast_to(stiffness, len(self))[:, None]
            drag += links * np.broadcast_to(resistance, len(self))[:, None]
        share = along(self.effects, "actuation", links, len(self))
        if self.space:
            from hsr_pin.simulation.space.system import space_system

            points = np.zeros((len(self), 0)) if self.points is None else self.points
            names = ("spring", "damper", "stiff", "drag", "share", "profile")
            joints = dict(zip(names, (spring, damper, stiff, drag, share, profile), strict=True))
            return space_system(arms, joints, points, self.world, self.touch)
        chain = chain_of(arms)
        beyond = chain.mass[:, ::-1].cumsum(axis=1)[:, ::-1] - chain.mass
        # in one block: the compiled loops take one layout alone
        bodies = np.array(
            (
                *(chain.mass, chain.lever, chain.inertia, chain.reach, chain.mass * chain.lever + chain.reach * beyond),
                *(spring, damper, stiff, drag, share, profile),
            )
        )
        whole = np.ascontiguousarray(chain.gravity), np.ascontiguousarray(arms.keq)
        return System._make(
            (*bodies, *whole, np.zeros((0, 4), dtype=np.int64), np.zeros((0, 1, len(self))), self.world, self.touch)
        )

    @cached_property
    def system(self) -> Any:
        """The arrays for the compiled loops, with the machine code of the laws."""
        from hsr_pin.simulation.laws import address  # late import: machine code is compiled only when needed

        arrays = self.arrays
        if self.world.shape[1]:
            press, slide = compiled(self.space)
            arrays = arrays._replace(touch=np.array([press.address, slide.address, *self.touch[2:]], dtype=np.int64))
        if not self.laws:
            return arrays
        rows, numbers, first = [], [self.numbers_of(law) for law in self.laws], 0
        for law in self.laws:
            update = address(law, "update", space=self.space) if law.states else 0
            hook = "moment" if law.acts_through("moment") else "contact_force"
            rows.append((address(law, hook, space=self.space), update, first, law.states))
            first += law.states
        table = np.zeros((len(rows), max(len(n) for n in numbers), len(self)))
        for row, values in zip(table, numbers, strict=True):
            row[: len(values)] = values
        return arrays._replace(laws=np.array(rows, dtype=np.int64), numbers=table)

    def pinocchio(self, solve: str) -> PinocchioSystem:
        """Return the batch for the loops with Pinocchio, which solve by "aba" or "rnea"."""
        every = [self.arms.specification(b) for b in range(len(self))]
        models = tuple((space_model(rigid_body(arm)) if self.space else build_model(arm).model).copy() for arm in every)
        return PinocchioSystem(self.arrays, models, tuple(m.createData() for m in models), self.laws, solve)

    def rigid_torques(self) -> Callable[[Array, Array, Array], Array]:
        """Return a function that computes the torques [N m] of the rigid bodies of the first arm for a motion.

        The function takes q, v and a, each (N,), of an arm in space (3 N,).
        """
        system = self.members(slice(0, 1)).pinocchio("rnea")
        if not self.space:
            return partial(pin.rnea, system.models[0], system.data[0])
        from hsr_pin.simulation.space.reference import rigid_torques

        return partial(rigid_torques, system.models[0], system.data[0])

    def numbers_of(self, effect: Effect) -> Array:
        """Return the parameters (P, B) of one of the effects."""
        return np.array([np.broadcast_to(getattr(effect, fact.name), len(self)) for fact in effect.parameters()], dtype=float)


def batch_key(scenario: Scenario) -> object:
    """Return the properties that scenarios must share to be simulated in one batch."""
    arm = scenario.arm
    kinds = tuple((type(effect), effect.options) for effect in scenario.effects)
    touches = arm.obstacles or any(effect.acts_through("obstacle") for effect in scenario.effects)
    return (
        arm.links,
        arm.placement,
        arm.mount,
        arm.bending,
        arm.sections,
        arm.obstacles,
        (arm.length, arm.diameter) if touches else None,  # they determine the number of points of contact
        kinds,
        len(scenario.markers),
        len(scenario.loads),
    )


def along(effects: Sequence[Effect], hook: str, links: int, count: int = 1) -> Array:
    """Return the profile (B, N) of a property along the arm, relative to the uniform arm: the product over all effects.

    Over the element of the arm that a joint represents, compliances are averaged (springs in series); damping and actuation are
    averaged directly.
    """
    acting = [effect for effect in effects if effect.acts_through(hook)]
    if not acting:
        return np.ones((count, links))
    edges = np.arange(links) / links
    s = edges[:, None, None] + _POINTS[None, :, None] / links  # (N, points, 1)
    product = np.ones((links, len(_POINTS), 1))
    for effect in acting:
        factor = getattr(effect, hook)(s)
        product = product if factor is None else product * factor
    product = np.ascontiguousarray(np.moveaxis(product, 2, 0))  # (B, N, points): the order of summation is independent of B
    averaged = 1 / (_WEIGHTS / product).sum(axis=2) if hook == "stiffness" else (_WEIGHTS * product).sum(axis=2)
    return np.array(np.broadcast_to(averaged, (count, links)))
