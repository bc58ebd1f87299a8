"""What a law of the plants can change.

A law is a frozen dataclass; each method below is one place where it may act, and does nothing unless it
is overridden. Moments are per joint but written for the whole arm: a joint's bending is `bend`, the
curvature times the arm's length [rad], so that the nominal moment is Keq * bend + C * rate whatever
the number of joints.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from ..arm import Arm, Array
from ..program import Trial

AnyLaw = TypeVar("AnyLaw", bound="Law")


@dataclass(frozen=True)
class Joints:
    """The joints of one simulation.

    s (n,): arc length over L; keq: declared stiffness [Nm/rad]; stiffness (n,): the true one, for the
    whole arm [Nm/rad]; damping: declared, of the whole arm [Nm s/rad].
    """

    s: Array
    keq: float
    stiffness: Array
    damping: float = 0.05


class State(NamedTuple):
    """One instant of a simulation.

    bend (n,) [rad], rate (n,) [rad/s], t [s] since the first sample, dt [s] of the step, clock [s] at
    the first sample, tau [N m] that arrives, rest: whether the arm is settling.
    """

    bend: Array
    rate: Array
    t: float
    dt: float
    clock: float
    tau: float
    rest: bool


class Nodes(NamedTuple):
    """Points along the backbone: position, velocity (2, N) in x, z [m, m/s]; angle (N,) [rad]."""

    position: Array
    velocity: Array
    angle: Array


class Law(ABC):
    """One piece of physics that the nominal model lacks.

    `strength` names the field that makes it stronger, `limit` the largest size of that field that is
    still believable; `variant` is the name of a form that the catalogue does not have.
    """

    name: ClassVar[str]
    variant: ClassVar[str] = ""
    strength: ClassVar[str]
    limit: ClassVar[float]

    @classmethod
    def draw(cls: type[AnyLaw], rng: np.random.Generator) -> AnyLaw:
        """A law with random secondary parameters and a moderate strength of random sign."""
        raise NotImplementedError

    def scaled(self: AnyLaw, factor: float) -> AnyLaw:
        """The same law, `factor` times as strong, at most up to its limit."""
        value = getattr(self, self.strength) * factor
        return replace(self, **{self.strength: float(np.clip(value, -self.limit, self.limit))})  # type: ignore[type-var]

    def describe(self) -> dict[str, Any]:
        """Name and parameters, for an answer file."""
        form = {"variant": self.variant} if self.variant else {}
        return {"name": self.name, **form, **asdict(self)}  # type: ignore[call-overload]

    def acts(self, place: str) -> bool:
        """Whether the law does anything in the method of this name."""
        return getattr(type(self), place) is not getattr(Law, place)

    # Where a law may act.

    def arm(self, arm: Arm, trial: Trial) -> Arm:
        """The arm as it truly is in a trial."""
        return arm

    def stiffness(self, s: Array) -> Array:
        """Factor on the bending stiffness at s, (n,)."""
        return np.ones_like(s)

    def damping(self, s: Array) -> Array:
        """Factor on the damping at s, (n,)."""
        return np.ones_like(s)

    def torque(self, s: Array) -> Array:
        """Factor on the actuation at s, (n,)."""
        return np.ones_like(s)

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        """Torque that arrives (K,) [N m] for the one that is commanded, on the fine grid t [s]."""
        return tau

    def memory(self, joints: Joints) -> Array:
        """Internal state at the start."""
        return np.zeros_like(joints.s)

    def moment(self, joints: Joints, state: State, memory: Array) -> tuple[Array, Array]:
        """Resisting moment (n,) [N m] beyond the linear one, and the state after the step."""
        return np.zeros_like(joints.s), memory

    def viscous(self, joints: Joints, state: State) -> Array:
        """Damping (n,) [Nm s/rad] beyond the linear one, held over the step."""
        return np.zeros_like(joints.s)

    def force(self, state: State, nodes: Nodes) -> Array:
        """Forces on the nodes, (2, N) [N]."""
        return np.zeros_like(nodes.position)

    def base(self, t: Array) -> Array:
        """Displacement of the base along x of the arm frame, (K,) [m]."""
        return np.zeros_like(t)

    def shift(self, s: float, angle: Array) -> tuple[Array, Array]:
        """How far a marker at s of L sits from its place, along the arm and off it (towards +x when straight), (T,) [m].

        angle (T,): direction of the arm there [rad].
        """
        return np.zeros_like(angle), np.zeros_like(angle)

    def seen(self, points: Array) -> Array:
        """Marker points (T, M, 3) in the world [m] as the cameras see them."""
        return points


def acting(laws: Sequence[Law], place: str) -> list[Law]:
    """Those of `laws` that act in the method named `place`."""
    return [law for law in laws if law.acts(place)]


def sign(rng: np.random.Generator) -> float:
    """Plus or minus one."""
    return float(rng.choice([-1.0, 1.0]))
