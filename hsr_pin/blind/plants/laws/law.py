"""Base class of a law, with all places of a simulation that a law can change.

A law is a frozen dataclass. Each method below is one place where it may act, and does nothing unless it is overridden. Moments
are per joint, but scaled to the whole arm: the bending `bend` of a joint is the curvature times the arm's length [rad]. So the
nominal moment is Keq * bend + C * rate for any number of joints.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Sequence
from dataclasses import Field, asdict, dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from hsr_pin.errors import EffectError

from ..arm import Arm, Array
from ..program import Trial

AnyLaw = TypeVar("AnyLaw", bound="Law")


@dataclass(frozen=True)
class Joints:
    """Joints of one simulation.

    Attributes:
        s: (n,) arc length relative to the length.
        keq: declared stiffness [Nm/rad].
        stiffness: (n,) true stiffness of the whole arm [Nm/rad].
        damping: declared damping of the whole arm [Nm s/rad].
    """

    s: Array
    keq: float
    stiffness: Array
    damping: float = 0.05


class State(NamedTuple):
    """State at one instant of a simulation.

    Attributes:
        bend: (n,) bending [rad].
        rate: (n,) rate of bending [rad/s].
        t: time since the first sample [s].
        dt: length of the step [s].
        clock: session time at the first sample [s].
        tau: torque after all laws on the command [N m].
        rest: whether the arm is settling.
    """

    bend: Array
    rate: Array
    t: float
    dt: float
    clock: float
    tau: float
    rest: bool


class Nodes(NamedTuple):
    """Points along the backbone: position and velocity (2, N) in x, z [m, m/s]; angle (N,) [rad]."""

    position: Array
    velocity: Array
    angle: Array


def slider(memory: Array, state: State, reach: float) -> Array:
    """Return the deflection of a spring in series with a slider after a step: it follows the bending up to `reach` [rad]."""
    return np.clip(memory + state.rate * state.dt, -reach, reach)


def bristle(memory: Array, state: State, top: Array | float) -> Array:
    """Return LuGre's bristle deflection after a step, which tends to `top` [rad]: exact for a constant rate."""
    end = np.sign(state.rate) * top
    return np.asarray(end + (memory - end) * np.exp(-np.abs(state.rate) * state.dt / top))


def random_of_trial(seed: int, clock: float) -> np.random.Generator:
    """Return random numbers that belong to the trial at this session time [s]."""
    return np.random.default_rng([seed, round(100 * clock)])


def drawn(draw: Callable[[np.random.Generator], Any], *, default: Any, kw_only: bool = False, **metadata: Any) -> Any:
    """Return a field of a law whose random value is ``draw(rng)``."""
    return field(default=default, kw_only=kw_only, metadata={"draw": draw, **metadata})


def strength(moderate: float, *, limit: float, signed: bool = False) -> Any:
    """Return the field that makes a law stronger, from 0 (no effect) to its largest plausible size `limit`.

    The random value is `moderate`, with a random sign if the law is `signed`.
    """
    return drawn(lambda rng: moderate * sign(rng) if signed else moderate, default=0.0, limit=limit)


def uniform(low: float, high: float, *, default: float, kw_only: bool = False) -> Any:
    """Return a field whose random value is distributed uniformly."""
    return drawn(lambda rng: float(rng.uniform(low, high)), default=default, kw_only=kw_only)


def random_seed() -> Any:
    """Return a field for the seed of a law's own random numbers."""
    return drawn(lambda rng: int(rng.integers(1 << 31)), default=0)


def one_of(*choices: str, among: Sequence[str] = (), default: str = "") -> Any:
    """Return a field with one of these values, of which those of `among` (or all) may be drawn; the default is the first."""
    return drawn(lambda rng: str(rng.choice(among or choices)), default=default or choices[0], choices=choices)


@dataclass(frozen=True)
class Law(ABC):
    """One piece of physics that the nominal model lacks.

    A subclass gives its `name` as in the catalogue, and the name `variant` of a form that the catalogue does not have. One of its
    fields is the :func:`strength`.
    """

    name: ClassVar[str]
    variant: ClassVar[str] = ""
    #: Name of the field that makes the law stronger, and the largest plausible size of that field.
    strength: ClassVar[str]
    limit: ClassVar[float]

    def __init_subclass__(cls, *, name: str = "", variant: str = "") -> None:
        if name:
            cls.name, cls.variant = name, variant
        for key, value in vars(cls).copy().items():
            if isinstance(value, Field) and "limit" in value.metadata:
                cls.strength, cls.limit = key, value.metadata["limit"]

    def __post_init__(self) -> None:
        for each in fields(self):
            choices, given = each.metadata.get("choices"), getattr(self, each.name)
            if choices and given not in choices:
                raise EffectError(f"{self.name} {each.name}", expected=" or ".join(choices), received=given)

    @classmethod
    def draw(cls: type[AnyLaw], rng: np.random.Generator) -> AnyLaw:
        """Return a law with random secondary parameters and a moderate strength of random sign."""
        return cls(**{each.name: each.metadata["draw"](rng) for each in fields(cls) if "draw" in each.metadata})

    def scaled(self: AnyLaw, factor: float) -> AnyLaw:
        """Return the same law with `factor` times the strength, at most up to its limit."""
        value = getattr(self, self.strength) * factor
        return replace(self, **{self.strength: float(np.clip(value, -self.limit, self.limit))})

    def describe(self) -> dict[str, Any]:
        """Return name and parameters for an answer file."""
        form = {"variant": self.variant} if self.variant else {}
        return {"name": self.name, **form, **asdict(self)}

    def acts(self, place: str) -> bool:
        """Return whether the law overrides the method of this name."""
        return getattr(type(self), place) is not getattr(Law, place)

    # Places where a law may act.

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        """Return the true arm in a trial."""
        return arm

    def stiffness(self, s: Array) -> Array:
        """Return the factor on the bending stiffness at s, (n,)."""
        return np.ones_like(s)

    def damping(self, s: Array) -> Array:
        """Return the factor on the damping at s, (n,)."""
        return np.ones_like(s)

    def torque(self, s: Array) -> Array:
        """Return the factor on the actuation at s, (n,)."""
        return np.ones_like(s)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        """Return the torque after the law, (K,) [N m], for the commanded one, on the fine grid t [s]."""
        return tau

    def memory(self, joints: Joints) -> Array:
        """Return the internal state at the start."""
        return np.zeros_like(joints.s)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        """Return the resisting moment (n,) [N m] in addition to the linear one, and the internal state after the step."""
        return np.zeros_like(joints.s), memory

    def viscous(self, joints: Joints, state: State) -> Array:
        """Return the damping (n,) [Nm s/rad] in addition to the linear one, held over the step."""
        return np.zeros_like(joints.s)

    def force(self, state: State, nodes: Nodes) -> Array:
        """Return the forces on the nodes, (2, N) [N]."""
        return np.zeros_like(nodes.position)

    def base(self, t: Array) -> Array:
        """Return the displacement of the base along x of the arm frame, (K,) [m]."""
        return np.zeros_like(t)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        """Return the displacement of a marker at s, along the arm and off it (towards +x when straight), each (T,) [m].

        angle (T,): direction of the arm there [rad].
        """
        return np.zeros_like(angle), np.zeros_like(angle)

    def seen(self, points: Array) -> Array:
        """Return marker points (T, M, 3) in the world [m] as the cameras see them."""
        return points


def acting(laws: Sequence[Law], place: str) -> list[Law]:
    """Return the laws that act in the method named `place`."""
    return [law for law in laws if law.acts(place)]


def sign(rng: np.random.Generator) -> float:
    """Return plus or minus one at random."""
    return float(rng.choice([-1.0, 1.0]))
