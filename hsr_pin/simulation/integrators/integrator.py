"""What an integrator is, and what it may ask of the arm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol

import numpy as np

from hsr_pin.trajectory import Array


class Work(NamedTuple):
    """Where a method writes the states for which it wants accelerations: one for each of S lengths d, side by side.

    Attributes:
        q, v: (S, N, B) [rad], [rad/s]; in memory column after column.
        d: (S, N, B) [s].
    """

    q: Array
    v: Array
    d: Array


class Chain(Protocol):
    """The equations of motion M(q) a = f(q, v), M by Pinocchio, f = tau - springs - dampers - effects - C v - G.

    Attributes:
        stiffness, damping: (N, 1) [Nm/rad], [Nm s/rad] the diagonal matrices K and D that are treated implicitly; upper bounds of
            the true ones, so that no law makes a step unstable.
        work: for each of the method's lengths, the work arrays of that length and of all after it (one workspace, many views).
    """

    stiffness: Array
    damping: Array
    work: tuple[Work, ...]

    def solve(self, first: int, after: float, push: Array | None = None) -> Array:
        """Linearly implicit Euler steps from the states in ``work[first]``: (M + d D + d^2 K) a = f(q, v) - d K v + push.

        Args:
            first: index of the first of S lengths; all after it are solved too.
            after: how many lengths d ago the step began.
            push: (S, N, B) [N m] further torque; None: none.

        Returns:
            (S, N, B) [rad/s^2], in a work array that the next call writes to.
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
        """The lengths d [s] whose armatures d D + d^2 K the method needs."""

    @abstractmethod
    def advance(self, chain: Chain, q: Array, v: Array, step: float) -> tuple[Array, Array]:
        """Angles and rates (N, B) one step later, in new arrays."""


def workspace(lengths: tuple[float, ...], links: int, columns: int) -> tuple[Work, ...]:
    """Work arrays for a chain of N joints and B columns."""
    q, v, d = (side_by_side(0.0, len(lengths), links, columns) for _ in range(3))
    d[:] = np.array(lengths)[:, None, None]
    return tuple(Work(q[first:], v[first:], d[first:]) for first in range(len(lengths)))


def side_by_side(values: Array | float, count: int, links: int, columns: int) -> Array:
    """A new array (S, N, B), column after column in memory, filled with what broadcasts to it."""
    array = np.empty((count, columns, links)).transpose(0, 2, 1)
    array[:] = values
    return array
