"""Summaries of a fitted model and of its data, from which the evidence is computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

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

    A group contains the channels that share one variance of the model discrepancy: all markers of an arm, each joint of a robot.

    Attributes:
        groups: for each of G groups the indices of its channels.
        noise: (G,) variance of one coordinate from measurement noise alone.
        count: (G,) number of measured coordinates.
        discrepancy: (G,) variance of one coordinate from known inaccuracies of every model, such as those of declared numbers.
    """

    groups: tuple[tuple[int, ...], ...]
    noise: Array
    count: Array
    discrepancy: Array

    @classmethod
    def of_one_group(cls, noise: float, count: int, channels: int = 1) -> Data:
        """Return the summary of recordings whose channels share one variance of the model discrepancy."""
        return cls((tuple(range(channels)),), np.array([noise]), np.array([count]), np.zeros(1))


@dataclass(frozen=True, eq=False)
class Model:
    """Summary of a fitted model for the evidence.

    Attributes:
        causes: causes that the model adds to the nominal model; empty for the nominal model with its own parameters fitted.
        misfits: (G,) mean square residual of one coordinate beyond noise, for each group of channels.
        information: (G, P + K, P + K) matrices L^-1/2 (J'J) L^-1/2, where J are the derivatives of the residuals of a group and L
            is the diagonal precision of the prior.
        departures: (P,) distance of each parameter from the centre of its prior, in standard deviations.
        errors: (K,) errors of declared numbers within their tolerances, in standard deviations; their information follows that of
            the P parameters.
    """

    causes: tuple[Cause, ...]
    misfits: Array
    information: Array
    departures: Array
    errors: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def misfit(self) -> float:
        """Mean square residual of one coordinate beyond noise: the mean over the groups."""
        return float(np.mean(self.misfits))

    @property
    def names(self) -> tuple[str, ...]:
        """Sorted names of the causes."""
        return tuple(sorted(cause.name for cause in self.causes))

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of physics of the causes."""
        return frozenset(cause.kind for cause in self.causes)


def information(slopes: Sequence[Array], widths: Array) -> Array:
    """Return the information matrix (P, P) of the residuals about the parameters, in units of the prior.

    Args:
        slopes: (n, P) derivatives of the residuals, in blocks.
        widths: (P,) standard deviations of the prior.
    """
    scaled = [block * widths for block in slopes]
    return np.asarray(sum((block.T @ block for block in scaled), start=np.zeros((len(widths), len(widths)))))
