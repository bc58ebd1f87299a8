"""Scenarios of one shape, side by side: the springs, dampers, effect laws and drives of B arms as arrays (N, B)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, stack
from hsr_pin.robot.model import build_model, rigid_body
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Array

#: Gauss-Legendre points on [0, 1] over which a property is averaged within the stretch of arm that a joint stands for.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


@dataclass(frozen=True)
class Shape:
    """What columns that are stepped side by side have in common.

    Attributes:
        links, placement: of the arms.
        step: between samples [s]; ``substeps`` steps of the integrator each.
        effects: their types and options.
        stiffness, damping: (N,) [Nm/rad], [Nm s/rad] at the joints, what the integrator treats implicitly.
        length_class: recordings of about the same number of samples go together.
    """

    links: int
    placement: str
    step: float
    substeps: int
    effects: tuple[tuple[type[Effect], tuple[tuple[str, str], ...]], ...]
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    length_class: int


def arm_of(scenario: Scenario) -> ArmSpecification:
    """The arm with the changes that its effects make to its rigid bodies and mount."""
    arm = scenario.arm
    for effect in scenario.effects:
        arm = effect.arm(arm)
    return arm


def shape_of(scenario: Scenario, largest_step: float) -> Shape:
    """Which batch a scenario goes to; ``largest_step`` [s] bounds the integrator's step."""
    substeps = max(1, math.ceil(scenario.step / largest_step - 1e-6))
    stiffness, damping = implicit_part(scenario.implicit_as or scenario)
    return Shape(
        links=scenario.arm.links,
        placement=scenario.arm.placement,
        step=round(scenario.step, 12),
        substeps=substeps,
        effects=tuple((type(effect), effect.options) for effect in scenario.effects),
        stiffness=stiffness,
        damping=damping,
        length_class=math.ceil(math.log(len(scenario.time), 1.25)),
    )


@lru_cache(maxsize=64)
def implicit_part(scenario: Scenario) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(N,) stiffness [Nm/rad] and damping [Nm s/rad] at the joints, with an upper bound of what the effects add."""
    arm = scenario.arm
    stiffness = arm.keq * along(scenario.effects, "stiffness", arm.links)[:, 0]
    damping = arm.damping * along(scenario.effects, "damping", arm.links)[:, 0]
    for effect in scenario.effects:
        more_stiffness, more_damping = effect.tangent(np.array([arm.keq]))
        stiffness = stiffness + more_stiffness
        damping = damping + more_damping
    return tuple((arm.links * stiffness).tolist()), tuple((arm.links * damping).tolist())


def along(effects: tuple[Effect, ...], hook: str, links: int) -> Array:
    """(N, 1) or (N, B) the product of a property of the effects along the arm, relative to the uniform arm.

    Within the stretch that a joint stands for, compliances add (springs in series); damping and actuation are averaged.
    """
    if not any(effect.acts_through(hook) for effect in effects):
        return np.ones((links, 1))
    edges = np.arange(links) / links
    s = edges[:, None, None] + _POINTS[None, :, None] / links  # (N, points, 1)
    product = np.ones((links, len(_POINTS), 1))
    for effect in effects:
        factor = getattr(effect, hook)(s)
        if factor is not None:
            product = product * factor
    if hook == "stiffness":
        return np.asarray(1 / np.einsum("p,npb->nb", _WEIGHTS, 1 / product))
    return np.asarray(np.einsum("p,npb->nb", _WEIGHTS, product))


class Columns:
    """B arms of one :class:`Shape`: the laws that the integrator integrates.

    Args:
        scenarios: of that shape, those with equal rigid bodies side by side.
        shape: as :func:`shape_of` gives it.
    """

    def __init__(self, scenarios: list[Scenario], shape: Shape) -> None:
        self.scenarios, self.shape = scenarios, shape
        links = shape.links
        self.arms = [arm_of(scenario) for scenario in scenarios]
        bodies = [rigid_body(arm) for arm in self.arms]
        models = {body: build_model(body) for body in dict.fromkeys(bodies)}
        self.arm_models = [models[body] for body in bodies]
        self.keq = np.array([arm.keq for arm in self.arms])
        self.effects = tuple(stack([scenario.effects[i] for scenario in scenarios]) for i in range(len(shape.effects)))
        self.profile = along(self.effects, "stiffness", links)
        damping = np.array([arm.damping for arm in self.arms])
        self.spring = np.asfortranarray(links * self.keq * self.profile)
        self.damper = np.asfortranarray(links * damping * along(self.effects, "damping", links))
        self.drive = along(self.effects, "actuation", links)
        self.muscles = tuple(effect for effect in self.effects if effect.acts_through("command"))
        self.laws = tuple(effect for effect in self.effects if effect.acts_through("moment"))
        self.stiffness = np.array(shape.stiffness)[:, None]
        self.damping = np.array(shape.damping)[:, None]

    @property
    def step(self) -> float:
        """The integrator's step [s]."""
        return self.shape.step / self.shape.substeps

    def commands(self) -> tuple[Array, Array]:
        """(S, B) [N m] what the scenarios command at each step of the integrator, and (B,) what they did before the first."""
        samples = max(len(scenario.time) for scenario in self.scenarios)
        held = np.empty((samples - 1, len(self.scenarios)))
        for column, scenario in enumerate(self.scenarios):
            count = min(len(scenario.torque), samples - 1)
            held[:count, column] = scenario.torque[:count]
            held[count:, column] = scenario.torque[-1]
        initial = np.array([s.start.torque if isinstance(s.start, Settled) else s.torque[0] for s in self.scenarios])
        return np.repeat(held, self.shape.substeps, axis=0), initial

    def deliver(self, torque: Array, pasts: tuple[Any, ...], step: float) -> tuple[Array, tuple[Any, ...]]:
        """What the muscles make of commands (B,) [N m] held over ``step`` [s], and what each effect on them will remember.

        ``pasts`` is what this method gave for the step before; empty: the commands have always been these.
        """
        remembered = []
        for effect, past in zip(self.muscles, pasts or (None,) * len(self.muscles), strict=True):
            torque, past = effect.command(torque, past, step, self.keq)
            remembered.append(past)
        return torque, tuple(remembered)

    def virgin_states(self) -> tuple[Array, ...]:
        """The laws' internal states in an arm that was never bent: (states, N, B) each."""
        return tuple(np.zeros((law.states, self.shape.links, len(self.scenarios))) for law in self.laws)

    def update(self, states: tuple[Array, ...], start: Array, end: Array, elapsed: float) -> tuple[Array, ...]:
        """The laws' internal states after the joints went from ``start`` to ``end`` (N, B) [rad] in ``elapsed`` [s]."""
        links = self.shape.links
        return tuple(
            law.update(state, links * start, links * end, elapsed) if law.states else state
            for law, state in zip(self.laws, states, strict=True)
        )

    def torque(self, q: Array, v: Array, states: tuple[Array, ...]) -> Array:
        """(N, B) [N m] of springs, dampers and effect laws at the joints."""
        total = -self.spring * q
        total -= self.damper * v
        total -= self.moment(q, v, states)
        return np.asarray(total)

    def moment(self, q: Array, v: Array, states: tuple[Array, ...]) -> Array | float:
        """(N, B) [N m] with which the effect laws resist at the joints, or 0 without laws."""
        angle, rate = self.shape.links * q, self.shape.links * v
        moments = (law.moment(Bending(angle, rate, self.keq, self.profile, s)) for law, s in zip(self.laws, states, strict=True))
        return sum((moment for moment in moments if moment is not None), start=0.0)
