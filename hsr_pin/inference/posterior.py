"""Posterior probabilities of models, sets of causes, names and kinds of physics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.evidence import explained, log_evidence
from hsr_pin.inference.model import Data, Model
from hsr_pin.trajectory import Array

#: Sorted names of causes; empty if no cause of the catalogue is missing.
Names = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior probabilities of fitted models.

    Attributes:
        models: all fitted models.
        evidence: (M,) log evidence of each model [nats].
        probabilities: (M,) probability of each model, after each model has been replaced by a special case that explains as much.
        explained: (M,) share of the gap of the nominal model that each model explains.
    """

    models: tuple[Model, ...]
    evidence: Array
    probabilities: Array
    explained: Array

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

    @property
    def kinds(self) -> dict[str, str]:
        """Kind of physics of every cause that was fitted, by its name."""
        return {cause.name: cause.kind for model in self.models for cause in model.causes}

    def of_name(self, name: str) -> float:
        """Return the probability that a cause is missing from the nominal model."""
        return self._sum(lambda model: name in model.names)

    def of_kind(self, kind: str) -> float:
        """Return the probability that a cause of a kind is missing from the nominal model."""
        return self._sum(lambda model: kind in model.kinds)

    def credible(self, level: float) -> tuple[Names, ...]:
        """Return the smallest collection of sets of causes whose total probability reaches ``level``."""
        chosen: list[Names] = []
        total = 0.0
        for names, probability in self.sets.items():
            if total >= level:
                break
            chosen.append(names)
            total += probability
        return tuple(chosen)

    def leader(self, names: Names) -> Model:
        """Return the most probable model with exactly these causes, or that with the largest evidence if all are improbable."""
        own = [k for k, model in enumerate(self.models) if model.names == names]
        return self.models[max(own, key=lambda k: (self.probabilities[k], self.evidence[k]))]

    def _sum(self, holds: Callable[[Model], bool]) -> float:
        return float(sum(p for model, p in zip(self.models, self.probabilities, strict=True) if holds(model)))


def posterior(
    models: Sequence[Model], data: Data, calibration: Calibration, special_case: Callable[[Model, Model], bool] | None = None
) -> Posterior:
    """Return the posterior over fitted models, with a prior that depends only on the penalties of their causes.

    The probability of a model is transferred to its smallest special case that explains all of what the model explains except for
    a small share, because such data do not support the general law.

    Args:
        models: fitted models, at least one of them without causes (the nominal model).
        data: noise variance and number of coordinates of the recordings.
        calibration: constants of the model evidence.
        special_case: function that returns whether the first model is a special case of the second; default: it has a proper
            subset of its causes.
    """
    inside = special_case or fewer_causes
    evidence = np.array([log_evidence(model, data, calibration) for model in models])
    weights = np.exp(evidence - evidence.max())
    nominal = max([model for model in models if not model.causes] or models, key=lambda model: model.misfit)
    shares = np.array([explained(model, nominal, data, calibration) for model in models])
    handed = np.zeros(len(models))
    for model, share, weight in zip(models, shares, weights, strict=True):
        enough = (1 - calibration.share) * share
        simpler = [k for k, other in enumerate(models) if shares[k] >= enough and inside(other, model)]
        chosen = min(simpler, key=lambda k: (len(models[k].causes), -evidence[k]), default=models.index(model))
        handed[chosen] += weight
    return Posterior(tuple(models), evidence, handed / handed.sum(), shares)


def fewer_causes(one: Model, other: Model) -> bool:
    """Return whether a model has some, but not all, of the causes of another model."""
    return bool(one.causes) and set(one.names) < set(other.names)
