"""The base class of effects: one law that the nominal model lacks, with its parameters and the place where it acts.

A law describes the arm per unit of bending, not per joint: ``angle`` is N q_i, the bending angle that the whole arm would have if
it were curved everywhere as at joint i. Its moment is the moment carried there. A law and its parameters therefore mean the same
for every number of links.

The laws of joints, of contacts and of the command (``moment``, ``update``, ``contact_force``, ``actuator_response``) are static
methods, written once, for one joint or one command: the compiled loop calls them with numbers, the loop with Pinocchio with
arrays, (B, N) or (B,) for B arms in a batch. They therefore consist of arithmetic, NumPy's elementwise functions (``np.minimum``
and :func:`hsr_pin.effects.vector.chosen` instead of ``min`` and ``if`` on angles, torques and parameters), constants of their
module and plain functions of the same kind; an ``if`` may test an option, or ``k``. They get their parameters as ``p``, a tuple
with the names of the effect's fields; an option is its index in the list of choices. Nothing is registered with the compiler: a
law is compiled when it is first called, and again when its source code changes.

Angles are treated as vectors of one component: a law uses ``abs`` for their length and :func:`hsr_pin.effects.vector.limited` for
their limits, never a sign, so that it also holds for bending about two axes.
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

#: Share of a law's steepest slope that must be implicit so that steps of any length are stable (0.77 for the extrapolation of
#: order 4 without an additional spring).
IMPLICIT = 0.75

#: Kinds of physics, with their descriptions.
KINDS = {
    "elastic": "how the moment depends on bending, or along the arm",
    "damping": "a moment that depends on the rate of bending",
    "friction": "a moment that depends on the path of bending, not on its rate",
    "creep": "bending that continues under a constant load",
    "actuation_time": "the torque arrives late or slowly",
    "actuation_map": "the map from command to torque",
    "mass_gravity": "mass and gravity",
    "contact": "contact with an object next to the arm",
    "measurement": "the positions of the markers and their measurement by the cameras",
}


class Bending(NamedTuple):
    """The bending of the arm at a joint, as a law gets it; numbers, or arrays that broadcast to (B, N).

    Attributes:
        angle: bending angle of a whole arm with this curvature [rad].
        rate: rate of this angle [rad/s].
        keq: bending stiffness of the whole arm [Nm/rad].
        stiffness: local stiffness, relative to keq.
        place: arc length of the middle of the element that the joint represents, relative to the length of the arm (0 to 1).
        memory: internal state of the law, one entry for each of its ``states``.
    """

    angle: Any
    rate: Any
    keq: Any
    stiffness: Any
    place: Any
    memory: tuple[Any, ...]


def middles(links: int) -> Array:
    """Return the positions (N,) of the elements of N joints along the arm, from 0 to 1."""
    return (np.arange(links) + 0.5) / links


class Places(Protocol):
    """Interface of a marker map, such as :class:`~hsr_pin.robot.kinematics.MarkerMap`, for effects on the measurement."""

    @property
    def axis(self) -> Array: ...
    def normals(self, joint_angles: Array, /) -> Array: ...
    def tangents(self, joint_angles: Array, /) -> Array: ...
    def turned(self, joint_angles: Array, /) -> Array: ...


@dataclass(frozen=True, eq=False)
class View:
    """The marker positions with the geometry that effects on the measurement need.

    Attributes:
        positions: (T, B, M, 3) marker positions in the world frame [m].
        arc_lengths: (M,) or (B, M) arc lengths of the markers [m].
        places: the marker map of the arms.
        angles: (T, B, N) joint angles [rad], of arms in space (T, B, 3 N).
    """

    positions: Array
    arc_lengths: Array
    places: Places
    angles: Array

    @cached_property
    def normals(self) -> Array:
        """Unit vectors (T, B, M, 3) normal to the backbone at the markers, towards positive bending."""
        return self.places.normals(self.angles)

    @cached_property
    def tangents(self) -> Array:
        """Unit vectors (T, B, M, 3) along the backbone at the markers, towards the tip."""
        return self.places.tangents(self.angles)

    @cached_property
    def turned(self) -> Array:
        """Angles (T, B, M) [rad] from the base to the backbone at the markers."""
        return self.places.turned(self.angles)

    @property
    def axis(self) -> Array:
        """Joint axis (3,) in the world frame."""
        return self.places.axis


def option(*choices: str, description: str) -> Any:
    """Return a dataclass field that selects a variant of a law: one of ``choices``, never fitted; the default is the first."""
    return dataclasses.field(default=choices[0], metadata={"option": choices, "description": description})


@dataclass(frozen=True)
class Effect(ABC):
    """Base class of unmodelled effects.

    A subclass is a frozen dataclass whose fields are :func:`hsr_pin.parameters.amplitude`, :func:`hsr_pin.parameters.shape` or
    :func:`option`. It overrides the one or two methods through which it acts; the others leave the nominal model unchanged. With
    its amplitudes at their neutral values it must reproduce the nominal model exactly.
    """

    name: ClassVar[str]
    lacks: ClassVar[str]
    cause: ClassVar[str]
    citation: ClassVar[str]
    #: One of :data:`KINDS`.
    kind: ClassVar[str]
    #: Number of internal states of a joint law, per joint.
    states: ClassVar[int] = 0
    #: Number of internal states of a law of the command; in equilibrium each of them equals the torque.
    memories: ClassVar[int] = 0
    passive: ClassVar[bool] = False
    #: Whether the law represents a kind of physics only and is never named as a cause.
    flexible: ClassVar[bool] = False
    #: Names of simpler effects that are special cases of this one.
    contains: ClassVar[tuple[str, ...]] = ()
    #: Parameters that must differ from each other, otherwise a simpler effect describes the same law.
    distinguished_by: ClassVar[tuple[str, ...]] = ()
    #: Amplitudes that a search opens one at a time, each as a separate variant, because recordings could hardly distinguish them.
    alternative_amplitudes: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        for fact in self.parameters():
            value = np.asarray(getattr(self, fact.name))
            if value.dtype.kind not in "fiu" or not np.all((value >= fact.lower) & (value <= fact.upper)):
                received = quoted(getattr(self, fact.name))
                raise EffectError(
                    f"{self.name}.{fact.name}", expected=f"{fact.lower:g} to {fact.upper:g} [{fact.unit}]", received=received
                )
        for name, choices in self.choices().items():
            choice = getattr(self, name)
            if not isinstance(choice, str) or choice not in choices:
                raise EffectError(f"{self.name}.{name}", expected=" or ".join(choices), received=quoted(choice))

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """Return the parameters in the order of the fields, with names, units, bounds and neutral values."""
        return parameters_of(cls)

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """Return the options with their possible values, the default first."""
        return {field.name: field.metadata["option"] for field in dataclasses.fields(cls) if "option" in field.metadata}

    @classmethod
    def variants(cls) -> tuple[dict[str, str], ...]:
        """Return all variants of this law as keyword arguments, the default first; one empty dict for a law without options."""
        choices = cls.choices()
        return tuple(dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values()))

    @property
    def options(self) -> tuple[tuple[str, str], ...]:
        """The options with their current values."""
        return tuple((name, getattr(self, name)) for name in self.choices())

    @property
    def p(self) -> Any:
        """The parameters as the laws get them: a named tuple of the fields, with options as indices."""
        choices = self.choices()
        values = ((choices[f].index(getattr(self, f)) if f in choices else getattr(self, f)) for f in fields_of(type(self)))
        return parameter_tuple(type(self))(*values)

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        """Return the arm with this effect, if it changes the rigid bodies or the mount."""
        return specification

    def stiffness(self, s: Array) -> Array | None:
        """Return the stiffness at arc lengths s (..., 1) in [0, 1] relative to the uniform arm; None if it is unchanged."""
        return None

    def damping(self, s: Array) -> Array | None:
        """Return the damping at arc lengths s (..., 1) in [0, 1] relative to the uniform arm; None if it is unchanged."""
        return None

    def actuation(self, s: Array) -> Array | None:
        """Return the share of the torque that arrives at arc lengths s (..., 1) in [0, 1]; None if it is unchanged."""
        return None

    def command_delay(self) -> Any:
        """Return the delay of the torque [s]."""
        return 0.0

    @staticmethod
    def actuator_response(p: Any, torque: Any, memory: tuple[Any, ...], step: float, keq: Any) -> tuple[Any, tuple[Any, ...]]:
        """Compute the torque that the actuators deliver for a command held over one step.

        Args:
            p: the parameters.
            torque: commanded torque [N m].
            memory: internal states at the beginning of the step.
            step: length of the step [s].
            keq: bending stiffness of the arm [Nm/rad].

        Returns:
            The mean torque over the step [N m] and the internal states at its end.
        """
        return torque, memory

    @staticmethod
    def moment(p: Any, bending: Bending) -> Any:
        """Return an additional moment [N m] that opposes bending."""
        return 0.0 * bending.angle

    @staticmethod
    def contact_force(p: Any, aside: Any) -> Any:
        """Return a force [N] on the arm at one place, normal to the straight arm, towards positive bending; planar arms only.

        Args:
            p: the parameters.
            aside: displacement of that place from the line of the straight arm, towards positive bending [m].
        """
        return 0.0 * aside

    def obstacle(self, length: Array, diameter: Array) -> Array | None:
        """Return an obstacle that planar arms touch, as :func:`hsr_pin.obstacles.row`, (B, ENTRIES); None if there is none.

        Its axes are those of the base: along the straight arm, towards positive bending, and sideways. The ``length`` and the
        ``diameter`` of the arms (B,) are in [m].
        """
        return None

    @staticmethod
    def place(p: Any) -> Any:
        """Return the relative arc length at which the force of :meth:`contact_force` acts; the default is the tip."""
        return 1.0

    @staticmethod
    def update(p: Any, k: int, memory: Any, start: Any, end: Any, elapsed: float) -> Any:
        """Return the k-th internal state after the angle changed uniformly from ``start`` to ``end`` [rad] in ``elapsed`` [s].

        ``elapsed`` is infinite if the arm was in equilibrium at ``end`` before the simulation began.
        """
        return memory

    def tangent(self, keq: Array, length: Array) -> tuple[Any, Any]:
        """Return the parts of d moment / d angle [Nm/rad] and d moment / d rate [Nm s/rad] that the integrator treats implicitly.

        keq (B,) [Nm/rad] and length (B,) [m] are those of the arms.

        Use the upper bound of the slope times :data:`IMPLICIT` for a law at whose steepest point an arm may rest: with less, the
        integration oscillates there with ever shorter steps, or diverges. Use half of the bound for a law whose steepest slope is
        seldom reached: more would reduce the accuracy.
        """
        return 0.0, 0.0

    @property
    def in_plane(self) -> bool:
        """Whether this law is defined for planar arms."""
        return True

    @property
    def in_space(self) -> bool:
        """Whether this law is defined for bending about two axes."""
        return True

    def observe(self, view: View) -> Array:
        """Return the measured marker positions (T, B, M, 3) [m]."""
        return view.positions

    def acts_through(self, hook: str) -> bool:
        """Return whether this effect overrides a method."""
        return getattr(type(self), hook) is not getattr(Effect, hook)


def unsupported_laws(effects: Sequence[Effect], *, space: bool) -> str:
    """Return the names of the laws that are not defined for arms in space, or for planar arms; an empty text if all are."""
    return ", ".join(effect.name for effect in effects if not (effect.in_space if space else effect.in_plane))


def fields_of(kind: type[Effect]) -> tuple[str, ...]:
    """Return the names of the parameters and options of an effect."""
    return (*(fact.name for fact in kind.parameters()), *kind.choices())


@cache
def parameter_tuple(kind: type[Effect]) -> Any:
    """Return the named tuple type in which the laws of an effect get its parameters."""
    return namedtuple(kind.__name__ + "Parameters", fields_of(kind))


def stack(effects: list[Effect]) -> Effect:
    """Combine B effects of the same type and options into one effect with (B,) parameters."""
    return dataclasses.replace(
        effects[0], **{fact.name: np.array([getattr(e, fact.name) for e in effects]) for fact in effects[0].parameters()}
    )


def effect_subset(effect: Effect, members: Any) -> Effect:
    """Return a stacked effect for some of the arms (indices or a slice)."""
    return dataclasses.replace(effect, **{fact.name: getattr(effect, fact.name)[members] for fact in effect.parameters()})


def neutral(effect: type[Effect], **options: str) -> Effect:
    """Return an effect with all parameters at their neutral values."""
    return effect(**{fact.name: fact.neutral for fact in effect.parameters()}, **options)


def with_values(effect: Effect, **values: float) -> Effect:
    """Return a copy of an effect with some parameters changed."""
    return dataclasses.replace(effect, **values)
