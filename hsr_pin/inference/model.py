"""Summaries of a fitted model and of its data, from which the evidence is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Cause:
    """A physical cause that the nominal model may lack.

    Attributes:
        name: name of the law.
        kind: kind of physics.
        flexible: whether the law only stands for its kind of physics, and is never named as a cause.
        variants: number of variants of the law in the catalogue.
    """

    name: str
    kind: str
    flexible: bool = False
    variants: int = 1


@dataclass(frozen=True)
class Data:
    """Summary of the recordings.

    Attributes:
        noise: variance of one coordinate from measurement noise alone.
        count: number of measured coordinates.
    """

    noise: float
    count: int


@dataclass(frozen=True, eq=False)
class Model:
    """Summary of a fitted model for the evidence.

    Attributes:
        causes: causes that the model adds to the nominal model; empty for the nominal model with its own parameters fitted.
        misfit: mean square residual of one coordinate beyond noise.
        information: (P,) eigenvalues of L^-1/2 (J'J) L^-1/2, where J are the derivatives of the residuals and L is the precision
            of the prior.
        departures: (P,) distance of each parameter from the centre of its prior, in standard deviations.
    """

    causes: tuple[Cause, ...]
    misfit: float
    information: Array
    departures: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Sorted names of the causes."""
        return tuple(sorted(cause.name for cause in self.causes))

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of physics of the causes."""
        return frozenset(cause.kind for cause in self.causes)


def information(slopes: Sequence[Array], widths: Array) -> Array:
    """Return the eigenvalues (P,) of the information matrix of the residuals, in units of the prior.

    Args:
        slopes: (n, P) derivatives of the residuals, in blocks.
        widths: (P,) standard deviations of the prior.
    """
    scaled = [block * widths for block in slopes]
    normal = np.sum([block.T @ block for block in scaled], axis=0) if scaled else np.zeros((len(widths), len(widths)))
    return np.maximum(np.linalg.eigvalsh(normal), 0.0) if len(widths) else np.zeros(0)
