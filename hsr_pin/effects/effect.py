"""What an effect is: one law that the nominal model lacks, with its parameters, and the place where it acts.

A law sees the arm per unit of bending, not per joint: ``angle`` is N q_i, the bending angle that the whole arm would have if it
were curved everywhere as it is at joint i. Its moment is the one carried there. So a law and its parameters mean the same for
every number of links. Angles, rates and states have the shape (N, B): N joints, B columns simulated side by side. A parameter is
a number, or (B,) when each column has its own.
"""

from __future__ import annotations

import dataclasses
import itertools
from abc import ABC
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hsr_pin.errors import EffectError
from hsr_pin.parameters import Parameter, parameters_of
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array


class Bending(NamedTuple):
    """How the arm is bent now, as a law sees it.

    Attributes:
        angle: (N, B) [rad] bending angle of a whole arm with this curvature.
        rate: (N, B) [rad/s] its rate.
        keq: (B,) [Nm/rad] bending stiffness of the whole arm.
        stiffness: (N, 1) or (N, B) stiffness along the arm, relative to keq.
        state: (states, N, B) the law's internal state.
    """

    angle: Array
    rate: Array
    keq: Array
    stiffness: Array
    state: Array


@dataclass(frozen=True, eq=False)
class View:
    """What the cameras see.

    Attributes:
        positions: (T, B, M, 3) [m] of the markers, in the world frame.
        normals: (T, B, M, 3) across the backbone there, towards positive bending.
        arc_lengths: (M,) [m].
        axis: (3,) the joint axis, in the world frame.
    """

    positions: Array
    normals: Array
    arc_lengths: Array
    axis: Array


def option(*choices: str, description: str) -> Any:
    """A dataclass field that says which reading of a law is meant: one of ``choices``, never fitted; its default is the first."""
    return dataclasses.field(default=choices[0], metadata={"option": choices, "description": description})


@dataclass(frozen=True)
class Effect(ABC):
    """One unmodelled effect.

    A subclass is a frozen dataclass whose fields are :func:`hsr_pin.parameters.parameter` or :func:`option`. It overrides the one
    method (or two) where it acts; the others leave the nominal model as it is. Setting its amplitude parameters to their neutral
    values must give back the nominal model exactly.
    """

    name: ClassVar[str]
    lacks: ClassVar[str]
    cause: ClassVar[str]
    citation: ClassVar[str]
    states: ClassVar[int] = 0
    passive: ClassVar[bool] = False
    #: Whether the true tangent often lies far below what :meth:`tangent` gives: a two-stage method (ros2) then rings.
    loosely_bounded: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for fact in self.parameters():
            value = getattr(self, fact.name)
            if not np.all((np.asarray(value) >= fact.lower) & (np.asarray(value) <= fact.upper)):
                raise EffectError(
                    f"{self.name}.{fact.name}", expected=f"{fact.lower:g} to {fact.upper:g} [{fact.unit}]", received=value
                )
        for name, choices in self.choices().items():
            if getattr(self, name) not in choices:
                raise EffectError(f"{self.name}.{name}", expected=" or ".join(choices), received=repr(getattr(self, name)))

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """Names, units, bounds and neutral values, in the order of the fields."""
        return parameters_of(cls)

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """The options and the values that each can take, the default first."""
        return {field.name: field.metadata["option"] for field in dataclasses.fields(cls) if "option" in field.metadata}

    @classmethod
    def variants(cls) -> tuple[dict[str, str], ...]:
        """Every reading of this law, as keyword arguments; the default first. One empty dict for a law without options."""
        choices = cls.choices()
        return tuple(dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values()))

    @property
    def options(self) -> tuple[tuple[str, str], ...]:
        """The options and their values here."""
        return tuple((name, getattr(self, name)) for name in self.choices())

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        """The arm with this effect, where it changes the rigid bodies or the mount."""
        return specification

    def stiffness(self, s: Array) -> Array | None:
        """Stiffness at arc length s (..., 1) in [0, 1], relative to the uniform arm; None: unchanged."""
        return None

    def damping(self, s: Array) -> Array | None:
        """Damping at arc length s (..., 1) in [0, 1], relative to the uniform arm; None: unchanged."""
        return None

    def actuation(self, s: Array) -> Array | None:
        """Torque that arrives at arc length s (..., 1) in [0, 1], relative to the command; None: all of it."""
        return None

    def command(self, torque: Array, past: Any, step: float, keq: Array) -> tuple[Array, Any]:
        """What the muscles make of a command held over one step, and what they will remember of it.

        Args:
            torque: (B,) [N m] commanded.
            past: what they remember of the steps before, as this method gave it; None: the command has always been this torque.
            step: [s].
            keq: (B,) [Nm/rad].

        Returns:
            (B,) [N m] the mean over the step, and the next ``past`` (None for a law without a memory).
        """
        return torque, None

    def moment(self, bending: Bending) -> Array | None:
        """(N, B) [N m] further moment with which the arm resists bending; None: nothing."""
        return None

    def tangent(self, keq: Array) -> tuple[Any, Any]:
        """Of d moment / d angle [Nm/rad] and d moment / d rate [Nm s/rad], what the integrator treats implicitly.

        Half of the upper bound: less, and a step may be unstable; more, and a law that seldom reaches its bound loses accuracy.
        """
        return 0.0, 0.0

    def update(self, state: Array, start: Array, end: Array, elapsed: float) -> Array:
        """The internal state (states, N, B) after the angle went evenly from ``start`` to ``end`` (N, B) in ``elapsed`` [s].

        ``elapsed`` is infinite when the arm was settled at ``end`` before the simulation began.
        """
        return state

    def observe(self, view: View) -> Array:
        """(T, B, M, 3) [m] marker positions as they are seen."""
        return view.positions

    def acts_through(self, hook: str) -> bool:
        """Whether this effect overrides a method."""
        return getattr(type(self), hook) is not getattr(Effect, hook)


def stack(effects: list[Effect]) -> Effect:
    """One effect whose parameters are (B,) arrays, from B effects of the same type and options."""
    return dataclasses.replace(
        effects[0], **{fact.name: np.array([getattr(e, fact.name) for e in effects]) for fact in effects[0].parameters()}
    )


def columns_of(effect: Effect, members: list[int]) -> Effect:
    """Some columns of a stacked effect."""
    return dataclasses.replace(effect, **{fact.name: getattr(effect, fact.name)[members] for fact in effect.parameters()})


def neutral(effect: type[Effect], **options: str) -> Effect:
    """The effect with every parameter at its neutral value."""
    return effect(**{fact.name: fact.neutral for fact in effect.parameters()}, **options)


def with_values(effect: Effect, **values: float) -> Effect:
    """A copy with some parameters changed."""
    return dataclasses.replace(effect, **values)
