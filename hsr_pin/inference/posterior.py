"""Probabilities of models, of sets of causes, of names and of kinds of physics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.evidence import log_evidence
from hsr_pin.inference.model import Data, Model
from hsr_pin.trajectory import Array

#: Names of causes, sorted; empty: none of those that were offered.
Names = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Posterior:
    """Probabilities of fitted models.

    Attributes:
        models: all that were fitted.
        evidence: (M,) log evidence of each [nats].
        probabilities: (M,) of each, after each has given way to a special case that does as much.
    """

    models: tuple[Model, ...]
    evidence: Array
    probabilities: Array

    @property
    def best(self) -> int:
        """Index of the most probable model."""
        return int(np.argmax(self.probabilities))

    @property
    def sets(self) -> dict[Names, float]:
        """Probability of each set of causes, the most probable first."""
        found: dict[Names, float] = {}
        for model, probability in zip(self.models, self.probabilities, strict=True):
            found[model.names] = found.get(model.names, 0.0) + float(probability)
        return dict(sorted(found.items(), key=lambda each: (-each[1], each[0])))

    def of_name(self, name: str) -> float:
        """Probability that a cause is there."""
        return self._sum(lambda model: name in model.names)

    def of_kind(self, kind: str) -> float:
        """Probability that a cause of a kind is there."""
        return self._sum(lambda model: kind in model.kinds)

    def credible(self, level: float) -> tuple[Names, ...]:
        """The smallest collection of sets of causes that has a probability of ``level`` together."""
        chosen: list[Names] = []
        total = 0.0
        for names, probability in self.sets.items():
            if total >= level:
                break
            chosen.append(names)
            total += probability
        return tuple(chosen)

    def leader(self, names: Names) -> Model:
        """The most probable model with exactly these causes; where none has a probability, that with the largest evidence."""
        own = [k for k, model in enumerate(self.models) if model.names == names]
        return self.models[max(own, key=lambda k: (self.probabilities[k], self.evidence[k]))]

    def _sum(self, holds: Callable[[Model], bool]) -> float:
        return float(sum(p for model, p in zip(self.models, self.probabilities, strict=True) if holds(model)))


def posterior(
    models: Sequence[Model], data: Data, calibration: Calibration, special_case: Callable[[Model, Model], bool] | None = None
) -> Posterior:
    """The posterior over fitted models, each equally likely beforehand but for what its causes cost.

    A model hands its probability to the smallest special case of it that does all but a small share of what it does: no law is
    told from a simpler one by that.

    Args:
        models: fitted; at least one without causes, the nominal model.
        data: what they were fitted to.
        calibration: the numbers of the judgement.
        special_case: whether the first model is a special case of the second; default: it has fewer of the same causes.
    """
    inside = special_case or fewer_causes
    evidence = np.array([log_evidence(model, data, calibration) for model in models])
    weights = np.exp(evidence - evidence.max())
    nominal = max((model.misfit for model in models if not model.causes), default=max(model.misfit for model in models))
    handed = np.zeros(len(models))
    for model, weight in zip(models, weights, strict=True):
        enough = (1 - calibration.share) * (nominal - model.misfit)
        simpler = [k for k, other in enumerate(models) if nominal - other.misfit >= enough and inside(other, model)]
        chosen = min(simpler, key=lambda k: (len(models[k].causes), -evidence[k]), default=models.index(model))
        handed[chosen] += weight
    return Posterior(tuple(models), evidence, handed / handed.sum())


def fewer_causes(one: Model, other: Model) -> bool:
    """Whether a model has some, and not all, of the causes of another."""
    return bool(one.causes) and set(one.names) < set(other.names)
