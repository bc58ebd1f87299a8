"""Arms side by side as arrays: bodies, springs, dampers and effect laws of B columns with N joints, (B, N) each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect, columns_of, stack
from hsr_pin.robot.chain import Arms, chain_of
from hsr_pin.robot.model import build_model, rigid_body
from hsr_pin.robot.sections import along_sections
from hsr_pin.robot.space import space_model
from hsr_pin.simulation.integrator import HARDLY_DAMPED
from hsr_pin.simulation.kernel import System
from hsr_pin.simulation.reference import PinocchioSystem
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array

#: Gauss-Legendre points on [0, 1] over which a property is averaged within the stretch of arm that a joint stands for.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


@dataclass(frozen=True, eq=False)
class Columns:
    """B arms of one shape with effects of the same types and options.

    Attributes:
        nominal: the arms without what the effects make of their bodies.
        effects: with (B,) parameters.
        points: (B, K) [m] arc lengths at which loads act, in space; None: none.
    """

    nominal: Arms
    effects: tuple[Effect, ...]
    points: Array | None = None

    @classmethod
    def of(cls, scenarios: Sequence[Scenario]) -> Columns:
        """The arms of some scenarios."""
        count = len(scenarios[0].effects)
        effects = tuple(stack([scenario.effects[i] for scenario in scenarios]) for i in range(count))
        points = np.array([s.points for s in scenarios]) if scenarios[0].loads else None
        return cls(Arms.of([scenario.arm for scenario in scenarios]), effects, points)

    def __len__(self) -> int:
        return len(self.nominal)

    def members(self, chosen: slice | NDArray[np.intp] | NDArray[np.bool_]) -> Columns:
        """Some of the columns, by a slice, by their indices, or by a truth for each."""
        points = None if self.points is None else self.points[chosen]
        return Columns(self.nominal.columns(chosen), tuple(columns_of(effect, chosen) for effect in self.effects), points)

    @property
    def links(self) -> int:
        """N."""
        return self.nominal.links

    @property
    def space(self) -> bool:
        """Whether the arms bend in space."""
        return self.nominal.bending == "space"

    @property
    def coordinates(self) -> int:
        """N, in space 3 N."""
        return (3 if self.space else 1) * self.links

    def evenly(self, bending: Array) -> Array:
        """(B, N) [rad] joint angles of arms that are bent evenly by (B,) [rad]; in space (B, 3 N) for complex numbers."""
        return self.rows(np.repeat(bending[:, None] / self.links, self.links, axis=1))

    def rows(self, bends: Array) -> Array:
        """The other way round of :meth:`bends`."""
        if not self.space:
            return bends
        return np.stack([bends.real, bends.imag, np.zeros(bends.shape)], axis=-1).reshape(*bends.shape[:-1], 3 * self.links)

    def by_joint(self, angles: Array) -> Array:
        """Rows (..., N) as they are; in space (..., N, 3) of rows (..., 3 N)."""
        return angles.reshape(*angles.shape[:-1], self.links, 3) if self.space else angles

    def bends(self, angles: Array) -> Array:
        """(..., N) of rows (..., N); in space complex numbers of rows (..., 3 N), without twist."""
        return np.asarray(angles[..., 0::3] + 1j * angles[..., 1::3] if self.space else angles)

    @cached_property
    def arms(self) -> Arms:
        """The arms with the changes that the effects make to their rigid bodies and mount."""
        arms = self.nominal
        for effect in self.effects:
            arms = effect.arm(arms)  # type: ignore[arg-type, assignment]  # the numbers of an arm, as arrays
        return arms

    @cached_property
    def ringing(self) -> NDArray[np.bool_]:
        """(B,) whether hardly anything damps an arm, told from its springs, dampers and its inertia about the base."""
        inertia = self.arms.length**2 * (self.arms.mass / 3 + self.arms.tip_mass)
        return np.asarray(self.arms.damping < 2 * HARDLY_DAMPED * np.sqrt(self.arms.keq * inertia))

    @cached_property
    def laws(self) -> tuple[Effect, ...]:
        """The effects that act in the joints, or on them from beside the arm."""
        return tuple(effect for effect in self.effects if effect.acts_through("moment") or effect.acts_through("touch"))

    @cached_property
    def muscles(self) -> tuple[Effect, ...]:
        """The effects that act on the command."""
        return tuple(effect for effect in self.effects if effect.acts_through("respond") or effect.acts_through("late"))

    @cached_property
    def remembering(self) -> bool:
        """Whether one of those has a memory, or is late."""
        return any(effect.memories or effect.acts_through("late") for effect in self.muscles)

    @property
    def states(self) -> int:
        """Numbers that the laws remember of each joint."""
        return sum(law.states for law in self.laws)

    @cached_property
    def arrays(self) -> Any:
        """Everything but the machine code of the laws (whose rows are empty)."""
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
            return space_system(arms, dict(zip(names, (spring, damper, stiff, drag, share, profile), strict=True)), points)
        chain = chain_of(arms)
        beyond = chain.mass[:, ::-1].cumsum(axis=1)[:, ::-1] - chain.mass
        # in one block: the compiled loops take one layout alone
        joints = np.array(
            (
                *(chain.mass, chain.lever, chain.inertia, chain.reach, chain.mass * chain.lever + chain.reach * beyond),
                *(spring, damper, stiff, drag, share, profile),
            )
        )
        whole = np.ascontiguousarray(chain.gravity), np.ascontiguousarray(arms.keq)
        return System._make((*joints, *whole, np.zeros((0, 4), dtype=np.int64), np.zeros((0, 1, len(self)))))

    @cached_property
    def system(self) -> Any:
        """For the compiled loops."""
        from hsr_pin.simulation.laws import address  # here: machine code is made only where it is wanted

        if not self.laws:
            return self.arrays
        rows, numbers, first = [], [self.numbers_of(law) for law in self.laws], 0
        for law in self.laws:
            update = address(law, "update", space=self.space) if law.states else 0
            hook = "moment" if law.acts_through("moment") else "touch"
            rows.append((address(law, hook, space=self.space), update, first, law.states))
            first += law.states
        table = np.zeros((len(rows), max(len(n) for n in numbers), len(self)))
        for row, values in zip(table, numbers, strict=True):
            row[: len(values)] = values
        return self.arrays._replace(laws=np.array(rows, dtype=np.int64), numbers=table)

    def pinocchio(self, solve: str) -> PinocchioSystem:
        """For the loops over Pinocchio: "aba" or "rnea"."""
        every = [self.arms.specification(b) for b in range(len(self))]
        models = tuple((space_model(rigid_body(arm)) if self.space else build_model(arm).model).copy() for arm in every)
        return PinocchioSystem(self.arrays, models, tuple(m.createData() for m in models), self.laws, solve)

    def rigid_torques(self) -> Callable[[Array, Array, Array], Array]:
        """The torques [N m] that the bodies of the first arm take in a motion q, v, a, (N,) each, in space (3 N,)."""
        system = self.members(slice(0, 1)).pinocchio("rnea")
        if not self.space:
            return partial(pin.rnea, system.models[0], system.data[0])
        from hsr_pin.simulation.space.reference import rigid_torques

        return partial(rigid_torques, system.models[0], system.data[0])

    def numbers_of(self, effect: Effect) -> Array:
        """(P, B) the parameters of one of the effects."""
        return np.array([np.broadcast_to(getattr(effect, fact.name), len(self)) for fact in effect.parameters()], dtype=float)


def likeness(scenario: Scenario) -> object:
    """What must be the same in scenarios whose arms are to stand side by side."""
    arm = scenario.arm
    kinds = tuple((type(effect), effect.options) for effect in scenario.effects)
    return arm.links, arm.placement, arm.mount, arm.bending, arm.sections, kinds, len(scenario.markers), len(scenario.loads)


def along(effects: Sequence[Effect], hook: str, links: int, count: int = 1) -> Array:
    """(B, N) the product of a property of the effects along the arm, relative to the uniform arm.

    Within the stretch that a joint stands for, compliances add (springs in series); damping and actuation are averaged.
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
    product = np.ascontiguousarray(np.moveaxis(product, 2, 0))  # (B, N, points): summed alike however many arms there are
    averaged = 1 / (_WEIGHTS / product).sum(axis=2) if hook == "stiffness" else (_WEIGHTS * product).sum(axis=2)
    return np.array(np.broadcast_to(averaged, (count, links)))
