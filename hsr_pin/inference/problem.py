"""What a model and its recordings have to offer to be fitted, searched and judged: an arm is one of them."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Group of starts of which the best is tried however much worse than others it looks.
ALWAYS = -1


class Part(Protocol):
    """A cause that a model may lack, in one variant."""

    @property
    def name(self) -> str:
        """Of the cause."""

    @property
    def kind(self) -> str:
        """Of physics."""

    @property
    def flexible(self) -> bool:
        """Whether it stands for its kind only, and is never named."""

    @property
    def reading(self) -> tuple[object, ...]:
        """What tells this variant from others of the same cause."""

    @property
    def plain(self) -> Part:
        """The variant whose probes serve this one too."""

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler causes that its own numbers can make of it."""

    def contains(self, other: Any) -> bool:
        """Whether the other is a special case of this one."""


class Hypothesis(Protocol):
    """A model with open parameters."""

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the open parameters; those of a part begin with its name and a dot."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is known of each beforehand."""

    @property
    def start(self) -> Array:
        """(P,) values to start from."""

    @property
    def parts(self) -> tuple[Any, ...]:
        """The causes that it has, in the order in which they were added."""

    @property
    def key(self) -> tuple[object, ...]:
        """What tells it from other models of the same recordings."""

    @property
    def labour(self) -> tuple[Any, ...]:
        """Larger for a model that takes longer to fit."""

    @property
    def rough(self) -> Hypothesis:
        """The same, simulated more roughly: enough to see which of many models are worth a full fit."""

    def with_part(self, part: Any) -> Hypothesis:
        """The same with one cause more."""

    def without_part(self, name: str) -> tuple[Hypothesis, list[int]]:
        """The same with one cause less, and which of the open parameters are left."""

    def tried_from(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """Values (P,) from which a fit might start, beside those proposed: each with its group, of which the best is kept.

        The proposed ones are among them; the group of what stems from the first is 0, of what stems from the second 1. The best
        of the group :data:`ALWAYS` is tried in any case.
        """


class Run(Protocol):
    """One trial."""

    @property
    def name(self) -> str:
        """Of the trial."""

    @property
    def time(self) -> Array:
        """(N,) [s] of its samples."""

    @property
    def compared(self) -> Array:
        """(T, M, A) what was measured, of the samples that are looked at; NaN in gaps."""

    @property
    def moved(self) -> float:
        """How far it goes from its mean: trials are chosen by it where not all are looked at."""

    @property
    def every(self) -> int:
        """One in so many samples is looked at."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a model predicts for one run.

    Attributes:
        positions: (T, M, A) predicted; NaN where the simulation failed.
        slopes: (T, M, A, P) derivatives to the open parameters; None if not asked for.
        nuisance: (T, M, A, K) what one standard deviation of each number that belongs to the trial makes of them; None if not
            asked for.
    """

    positions: Array
    slopes: Array | None = None
    nuisance: Array | None = None

    @property
    def failed(self) -> bool:
        """Whether the simulation ended early."""
        return not bool(np.isfinite(self.positions).all())


class Problem(Hashable, Protocol):
    """Recordings, and who simulates them.

    A channel (an axis M of what is measured) is a marker, a joint, a force. It may have several coordinates (A).
    """

    @property
    def runs(self) -> tuple[Any, ...]:
        """The trials (:class:`Run`)."""

    @property
    def noise(self) -> Array:
        """(M,) standard deviation of the noise of each channel."""

    @property
    def floor(self) -> Array:
        """(M,) what noise and the truest of models leave of a coordinate of each channel."""

    @property
    def worst(self) -> float:
        """What a failed simulation counts as."""

    @property
    def lasting(self) -> int:
        """How many of the numbers that belong to a trial, from the first, say something of the model where all share them."""

    @property
    def seen(self) -> int:
        """How many of them there are in any case; the rest count only where a trial shows them."""

    @property
    def doubted(self) -> NDArray[Any]:
        """(K,) those that could stand in for what a model lacks."""

    def own(self, run: Any) -> int:
        """How many numbers may belong to a run."""

    def shown(self, run: Any) -> bool:
        """Whether a run may have numbers that count only where it shows them."""

    def some(self, kept: Sequence[int], samples: int) -> Problem:
        """These runs alone, with hardly more than so many samples of each, and without numbers that trials have to show."""

    def of_runs(self, runs: Sequence[Any]) -> Problem:
        """These runs alone."""

    def predict(self, hypothesis: Any, cases: Sequence[tuple[Any, Array]]) -> list[Prediction]:
        """For each run with its own values (P,)."""

    def predict_with_slopes(
        self,
        hypothesis: Any,
        values: Array,
        *,
        central: bool = False,
        shown: Sequence[bool] | None = None,
        own: bool = True,
    ) -> list[Prediction]:
        """For every run at values (P,), with derivatives and what belongs to the trials.

        Args:
            hypothesis: the model.
            values: (P,) of its open parameters.
            central: derivatives by central differences in place of one-sided ones.
            shown: for each run whether the numbers that count only where it shows them are among those that belong to it;
                default: where they may be.
            own: whether what belongs to the trials is asked for.
        """

    def probe(self, hypothesis: Any, points: Array) -> list[Array]:
        """For each run (T, C, M, A) about what is predicted at each of the points (C, P)."""

    def as_read(self, hypothesis: Any, new: Sequence[Parameter], run: Any, changes: Array) -> Array:
        """(n, A') what the amplitudes of the last part make of a run's residuals, of (n, A) for its plain variant."""
