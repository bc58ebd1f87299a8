"""What an integrator is, and what it may ask of the arm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Protocol

from hsr_pin.trajectory import Array


class Chain(Protocol):
    """The equations of motion M(q) a = f(q, v), M by Pinocchio, f = tau - springs - dampers - effects - C v - G.

    Attributes:
        stiffness, damping: (N, 1) [Nm/rad], [Nm s/rad] the diagonal matrices K and D that are treated implicitly; upper bounds of
            the true ones, so that no law makes a step unstable.
    """

    stiffness: Array
    damping: Array

    def solve(self, slot: int, q: Array, v: Array, elapsed: float, push: Array | None = None) -> Array:
        """The linearly implicit Euler step of the slot's length d: (M + d D + d^2 K) a = f(q, v) - d K v + push.

        Args:
            slot: index into the method's lengths.
            q: (N, B) [rad].
            v: (N, B) [rad/s].
            elapsed: [s] since the step began.
            push: (N, B) [N m] further torque; None: none.

        Returns:
            (N, B) [rad/s^2], a new array.
        """


class Integrator(ABC):
    """A one-step method for a stiff chain, linearly implicit in springs and dampers.

    One call of ABA with ``armature`` = d D + d^2 K solves the linearly implicit Euler step of length d exactly: that is the only
    linear algebra there is. The loop knows nothing of the method.

    Attributes:
        order: of convergence.
    """

    order: int

    @abstractmethod
    def lengths(self, step: float) -> tuple[float, ...]:
        """The lengths d [s] whose armatures d D + d^2 K the method needs, one a slot."""

    @abstractmethod
    def advance(self, chain: Chain, q: Array, v: Array, step: float) -> tuple[Array, Array]:
        """Angles and rates (N, B) one step later."""
