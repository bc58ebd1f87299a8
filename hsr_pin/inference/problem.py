"""Interfaces between a model with its recordings and the identification: fits, search and evidence."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Group of start points whose best member is always tried, even if its misfit is much larger than that of others.
ALWAYS = -1


class Part(Protocol):
    """A cause that a model may lack, in one variant."""

    @property
    def name(self) -> str:
        """Name of the cause."""

    @property
    def kind(self) -> str:
        """Kind of physics."""

    @property
    def flexible(self) -> bool:
        """Whether the law only stands for its kind of physics, and is never named as a cause."""

    @property
    def variant(self) -> tuple[object, ...]:
        """Key that distinguishes this variant from other variants of the same cause."""

    @property
    def base_variant(self) -> Part:
        """The variant whose probe simulations are valid for this variant too."""

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler causes that this law becomes for certain values of its parameters."""

    def contains(self, other: Any) -> bool:
        """Return whether another part is a special case of this one."""


class Hypothesis(Protocol):
    """A model with free parameters."""

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free parameters; those of a part begin with its name and a dot."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Prior knowledge about each free parameter."""

    @property
    def start(self) -> Array:
        """Initial values (P,) of the free parameters."""

    @property
    def parts(self) -> tuple[Any, ...]:
        """The causes in the model, in the order in which they were added."""

    @property
    def key(self) -> tuple[object, ...]:
        """Key that distinguishes the model from other models of the same recordings."""

    @property
    def cost(self) -> tuple[Any, ...]:
        """Sort key of the time that a fit takes: larger for a slower model."""

    @property
    def rough(self) -> Hypothesis:
        """The model with a coarser simulation, which is accurate enough to select the models that get a full fit."""

    def with_part(self, part: Any) -> Hypothesis:
        """Return the model with one more cause."""

    def without_part(self, name: str) -> tuple[Hypothesis, list[int]]:
        """Return the model without one cause, and the indices of the free parameters that remain."""

    def start_points(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """Return the start points (P,) of a fit, each with its group; of each group only the best one is kept.

        The proposed start points are included; the group of all points derived from the first is 0, from the second 1, and so on.
        The best point of the group :data:`ALWAYS` is tried in any case.
        """


class Run(Protocol):
    """One trial."""

    @property
    def name(self) -> str:
        """Name of the trial."""

    @property
    def time(self) -> Array:
        """Sampling times (N,) [s]."""

    @property
    def compared(self) -> Array:
        """Measured values (T, M, A) of the samples that the fit uses; NaN in gaps."""

    @property
    def moved(self) -> float:
        """Typical distance from the mean, by which trials are selected if not all are used."""

    @property
    def every(self) -> int:
        """Sampling ratio: the fit uses one in this many samples."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Prediction of a model for one run.

    Attributes:
        positions: (T, M, A) predicted values; NaN where the simulation failed.
        slopes: (T, M, A, P) derivatives with respect to the free parameters; None if not requested.
        nuisance: (T, M, A, K) change of the prediction for one prior standard deviation of each trial parameter; None if not
            requested.
    """

    positions: Array
    slopes: Array | None = None
    nuisance: Array | None = None

    @property
    def failed(self) -> bool:
        """Whether the simulation ended early."""
        return not bool(np.isfinite(self.positions).all())


class Problem(Hashable, Protocol):
    """Recordings together with their simulation.

    A channel (axis M of the measured values) is a marker, a joint or a force. It may have several coordinates (axis A). A trial
    parameter is a small parameter of one trial, such as an offset of its equilibrium. It is systematic if its mean over the
    trials is an error of the model, and conditional if it is used only in trials whose recordings support it.
    """

    @property
    def runs(self) -> tuple[Any, ...]:
        """The trials (:class:`Run`)."""

    @property
    def noise(self) -> Array:
        """Standard deviation (M,) of the noise of each channel."""

    @property
    def floor(self) -> Array:
        """Standard deviation (M,) that noise and the best model leave in one coordinate of each channel."""

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the channels that share one variance of the model discrepancy."""

    def tolerances(self, run: Any) -> Array:
        """Return the change of a run's prediction for one standard deviation of each error of a declared number, (T, M, A, K)."""

    @property
    def discrepancy(self) -> Array:
        """Standard deviation (M,) that known inaccuracies of every model leave in one coordinate of each channel."""

    @property
    def worst(self) -> float:
        """Residual that stands for a failed simulation."""

    @property
    def systematic(self) -> int:
        """Number of trial parameters, counted from the first, whose mean over the trials is an error of the model."""

    @property
    def unconditional(self) -> int:
        """Number of trial parameters that are always used; the remaining ones are conditional."""

    @property
    def confounded(self) -> NDArray[Any]:
        """For each trial parameter (K,), whether it is confounded with a discrepancy of the model."""

    def own(self, run: Any) -> int:
        """Return the largest number of trial parameters of a run."""

    def has_conditional(self, run: Any) -> bool:
        """Return whether a run may have conditional trial parameters."""

    def some(self, kept: Sequence[int], samples: int) -> Problem:
        """Return the problem with some runs, about ``samples`` samples of each, and no conditional trial parameters."""

    def of_runs(self, runs: Sequence[Any]) -> Problem:
        """Return the problem with some of its runs."""

    def predict(self, hypothesis: Any, cases: Sequence[tuple[Any, Array]]) -> list[Prediction]:
        """Return the prediction for each pair of a run and parameter values (P,)."""

    def predict_with_slopes(
        self,
        hypothesis: Any,
        values: Array,
        *,
        central: bool = False,
        conditional: Sequence[bool] | None = None,
        own: bool = True,
    ) -> list[Prediction]:
        """Return the prediction of every run with derivatives and the effect of trial parameters.

        Args:
            hypothesis: the model.
            values: (P,) values of its free parameters.
            central: whether derivatives are central differences instead of one-sided ones.
            conditional: for each run, whether its conditional trial parameters are included; default: wherever there are any.
            own: whether the effect of trial parameters is requested.
        """

    def probe(self, hypothesis: Any, points: Array) -> list[Array]:
        """Return for each run the approximate prediction (T, C, M, A) at each of the points (C, P)."""

    def changes_of_variant(self, hypothesis: Any, new: Sequence[Parameter], run: Any, changes: Array) -> Array:
        """Return the changes of a run's residuals (n, A') for a variant, from those (n, A) of its base variant."""
