"""What the judgement needs to know of a fitted model and of the data that it was fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Cause:
    """One thing that a nominal model may lack.

    Attributes:
        name: of the law.
        kind: of physics.
        flexible: whether the law stands for its kind only, and is never named as a cause.
        variants: how many variants of the law were offered.
    """

    name: str
    kind: str
    flexible: bool = False
    variants: int = 1


@dataclass(frozen=True)
class Data:
    """The scale on which residuals count.

    Attributes:
        noise: variance of one coordinate by measurement noise alone.
        count: number of coordinates.
    """

    noise: float
    count: int


@dataclass(frozen=True, eq=False)
class Model:
    """A fitted model, reduced to what the judgement needs.

    Attributes:
        causes: what it adds to the nominal model; empty: the nominal model with its own parameters fitted.
        misfit: mean square of one coordinate of its residuals, beyond noise.
        information: (P,) eigenvalues of L^-1/2 (J'J) L^-1/2, J the derivatives of the residuals and L the precision of the prior.
        departures: (P,) distance of each parameter from the centre of its prior, in standard deviations of it.
    """

    causes: tuple[Cause, ...]
    misfit: float
    information: Array
    departures: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the causes, sorted."""
        return tuple(sorted(cause.name for cause in self.causes))

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of physics of the causes."""
        return frozenset(cause.kind for cause in self.causes)


def information(slopes: Sequence[Array], widths: Array) -> Array:
    """(P,) eigenvalues of the information that residuals carry, in units of the prior.

    Args:
        slopes: (n, P) derivatives of the residuals, block by block.
        widths: (P,) standard deviations of the prior.
    """
    scaled = [block * widths for block in slopes]
    normal = np.sum([block.T @ block for block in scaled], axis=0) if scaled else np.zeros((len(widths), len(widths)))
    return np.maximum(np.linalg.eigvalsh(normal), 0.0) if len(widths) else np.zeros(0)
