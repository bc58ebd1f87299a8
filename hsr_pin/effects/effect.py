"""What an effect is: one law that the nominal model lacks, with its parameters, and the place where it acts.

A law sees the arm per unit of bending, not per joint: ``angle`` is N q_i, the bending angle that the whole arm would have if it
were curved everywhere as it is at joint i. Its moment is the one carried there. So a law and its parameters mean the same for
every number of links.

The laws of joints, of what stands beside the arm and of the command (``moment``, ``update``, ``touch``, ``respond``) are static
methods, written once, for one joint or one command: the compiled loop calls them with numbers, the loop over Pinocchio with
arrays, (B, N) or (B,) for B arms side by side. So they are made of arithmetic, NumPy's elementwise functions (``np.minimum`` and
:func:`hsr_pin.effects.vector.chosen`, not ``min`` and ``if``, on angles, torques and parameters), constants of their module and
plain functions of the same kind; an ``if`` may ask for an option, or ``k``. They take their parameters as ``p``, a tuple with
the names of the effect's fields; an option is its index in the list of choices. Nothing is registered with the compiler: a law
is compiled when it is first called, and again when its text changes.

Angles are treated as vectors of one component: a law uses ``abs`` for their length and
:func:`hsr_pin.effects.vector.limited` for their limits, never a sign, so that it holds for bending about two axes too.
"""

from __future__ import annotations

import dataclasses
import itertools
from abc import ABC
from collections import namedtuple
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from hsr_pin.errors import EffectError, quoted
from hsr_pin.parameters import Parameter, parameters_of
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

#: Share of a law's steepest slope that must be implicit for steps of any length to be stable (by the extrapolation of order 4
#: 0.77, if there were no spring beside it).
IMPLICIT = 0.75

#: Kinds of physics that laws belong to.
KINDS = {
    "elastic": "how the moment depends on bending, or along the arm",
    "damping": "a moment that depends on the rate of bending",
    "friction": "a moment that depends on the path of bending, not on its rate",
    "creep": "bending that goes on under a constant load",
    "actuation_time": "the torque comes late or slowly",
    "actuation_map": "the map from command to torque",
    "mass_gravity": "mass and gravity",
    "contact": "contact with something beside the arm",
    "measurement": "where the markers are and how the cameras see them",
}


class Bending(NamedTuple):
    """How the arm is bent at a joint, as a law sees it; numbers, or arrays that broadcast to (B, N).

    Attributes:
        angle: [rad] bending angle of a whole arm with this curvature.
        rate: [rad/s] its rate.
        keq: [Nm/rad] bending stiffness of the whole arm.
        stiffness: stiffness there, relative to keq.
        place: arc length of the middle of the stretch that the joint stands for, over that of the arm: 0 to 1.
        memory: the law's internal state, one entry for each of its ``states``.
    """

    angle: Any
    rate: Any
    keq: Any
    stiffness: Any
    place: Any
    memory: tuple[Any, ...]


def middles(links: int) -> Array:
    """(N,) places of N joints, as laws see them."""
    return (np.arange(links) + 0.5) / links


class Places(Protocol):
    """Markers on an arm, as :class:`~hsr_pin.robot.kinematics.MarkerMap` knows them."""

    @property
    def axis(self) -> Array: ...
    def normals(self, joint_angles: Array, /) -> Array: ...
    def tangents(self, joint_angles: Array, /) -> Array: ...
    def turned(self, joint_angles: Array, /) -> Array: ...


@dataclass(frozen=True, eq=False)
class View:
    """What the cameras see.

    Attributes:
        positions: (T, B, M, 3) [m] of the markers, in the world frame.
        arc_lengths: (M,) or (B, M) [m].
        places: where the markers are on the arm.
        angles: (T, B, N) [rad] of the joints, in space (T, B, 3 N).
    """

    positions: Array
    arc_lengths: Array
    places: Places
    angles: Array

    @cached_property
    def normals(self) -> Array:
        """(T, B, M, 3) unit vectors across the backbone at the markers, towards positive bending."""
        return self.places.normals(self.angles)

    @cached_property
    def tangents(self) -> Array:
        """(T, B, M, 3) unit vectors along the backbone at the markers, towards the tip."""
        return self.places.tangents(self.angles)

    @cached_property
    def turned(self) -> Array:
        """(T, B, M) [rad] angle from the base to the backbone at the markers."""
        return self.places.turned(self.angles)

    @property
    def axis(self) -> Array:
        """(3,) the joint axis, in the world frame."""
        return self.places.axis


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
    #: One of :data:`KINDS`.
    kind: ClassVar[str]
    #: Numbers that a law of the joints remembers, of each joint.
    states: ClassVar[int] = 0
    #: Numbers that a law of the command remembers; an arm that has settled remembers the torque in each of them.
    memories: ClassVar[int] = 0
    passive: ClassVar[bool] = False
    #: Whether it stands for its kind of physics only, and is never named as a cause.
    flexible: ClassVar[bool] = False
    #: Names of simpler effects that are special cases of this one.
    contains: ClassVar[tuple[str, ...]] = ()
    #: Numbers that must differ for this to be more than the simpler effects that it contains.
    unlike: ClassVar[tuple[str, ...]] = ()
    #: Amplitudes that a search opens one at a time, each a reading of its own: together they could hardly be told apart.
    apart: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        for fact in self.parameters():
            value = np.asarray(getattr(self, fact.name))
            if value.dtype.kind not in "fiu" or not np.all((value >= fact.lower) & (value <= fact.upper)):
                received = quoted(getattr(self, fact.name))
                raise EffectError(
                    f"{self.name}.{fact.name}", expected=f"{fact.lower:g} to {fact.upper:g} [{fact.unit}]", received=received
                )
        for name, choices in self.choices().items():
            word = getattr(self, name)
            if not isinstance(word, str) or word not in choices:
                raise EffectError(f"{self.name}.{name}", expected=" or ".join(choices), received=quoted(word))

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

    @property
    def p(self) -> Any:
        """The parameters as its laws take them: a tuple with the names of the fields, options as indices."""
        choices = self.choices()
        values = ((choices[f].index(getattr(self, f)) if f in choices else getattr(self, f)) for f in fields_of(type(self)))
        return parameter_tuple(type(self))(*values)

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

    def late(self) -> Any:
        """[s] by which the torque comes late."""
        return 0.0

    @staticmethod
    def respond(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        """What the muscles make of a command held over one step.

        Args:
            p: the parameters.
            torque: [N m] commanded.
            memory: what they remember of the steps before.
            step: [s].
            keq: [Nm/rad].

        Returns:
            [N m] the mean over the step, and what they remember then.
        """
        return torque, memory

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        """[N m] further moment with which the arm resists bending."""
        return 0.0 * bending.angle

    @staticmethod
    def touch(p: Any, aside: Any) -> Any:
        """[N] force on the arm at one place, across the straight arm towards positive bending; in a plane alone.

        Args:
            p: the parameters.
            aside: [m] from the line of the straight arm to that place, towards positive bending.
        """
        return 0.0 * aside

    @staticmethod
    def place(p: Any) -> Any:
        """Arc length over that of the arm at which the force of :meth:`touch` acts: the tip, unless the law says otherwise."""
        return 1.0

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        """The k-th internal state after the angle went evenly from ``start`` to ``end`` [rad] in ``elapsed`` [s].

        ``elapsed`` is infinite when the arm was settled at ``end`` before the simulation began.
        """
        return memory

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        """Of d moment / d angle [Nm/rad] and d moment / d rate [Nm s/rad], what the integrator treats implicitly.

        For arms of a stiffness keq (B,) [Nm/rad] and a length (B,) [m].

        The bound times :data:`IMPLICIT` for a law at whose steepest an arm may stay: less, and it trembles there, in ever shorter
        steps, or is driven away. Half of the bound for one that is seldom near it: more, and it loses accuracy.
        """
        return 0.0, 0.0

    @property
    def in_plane(self) -> bool:
        """Whether this law has a form for an arm in a plane."""
        return True

    @property
    def in_space(self) -> bool:
        """Whether this law has a form for bending about two axes."""
        return True

    def observe(self, view: View) -> Array:
        """(T, B, M, 3) [m] marker positions as they are seen."""
        return view.positions

    @property
    def placeless(self) -> bool:
        """Whether it acts on the joints or the torque alone, and alike at every place of the arm."""
        return not any(self.acts_through(hook) for hook in ("arm", "stiffness", "damping", "actuation", "touch", "observe"))

    def acts_through(self, hook: str) -> bool:
        """Whether this effect overrides a method."""
        return getattr(type(self), hook) is not getattr(Effect, hook)


def formless(effects: Sequence[Effect], *, space: bool) -> str:
    """Names of the laws that have no form for an arm in space, or for one in a plane; empty: none."""
    return ", ".join(effect.name for effect in effects if not (effect.in_space if space else effect.in_plane))


def fields_of(kind: type[Effect]) -> tuple[str, ...]:
    """Names of the parameters and options of an effect."""
    return (*(fact.name for fact in kind.parameters()), *kind.choices())


@cache
def parameter_tuple(kind: type[Effect]) -> Any:
    """The tuple in which the laws of an effect take its parameters."""
    return namedtuple(kind.__name__ + "Parameters", fields_of(kind))


def stack(effects: list[Effect]) -> Effect:
    """One effect whose parameters are (B,) arrays, from B effects of the same type and options."""
    return dataclasses.replace(
        effects[0], **{fact.name: np.array([getattr(e, fact.name) for e in effects]) for fact in effects[0].parameters()}
    )


def columns_of(effect: Effect, members: Any) -> Effect:
    """Some columns (indices or a slice) of a stacked effect."""
    return dataclasses.replace(effect, **{fact.name: getattr(effect, fact.name)[members] for fact in effect.parameters()})


def neutral(effect: type[Effect], **options: str) -> Effect:
    """The effect with every parameter at its neutral value."""
    return effect(**{fact.name: fact.neutral for fact in effect.parameters()}, **options)


def with_values(effect: Effect, **values: float) -> Effect:
    """A copy with some parameters changed."""
    return dataclasses.replace(effect, **values)
