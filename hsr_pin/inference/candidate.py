"""A fitted model, and what the judgement needs to know of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.heldout import leave_one_out
from hsr_pin.inference.model import Cause, Data, Model, information
from hsr_pin.inference.problem import Problem
from hsr_pin.inference.resampling import squares
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.trajectory import Array

#: What tells a model from others.
Key = tuple[object, ...]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fitted model and its error on held-out trials.

    Attributes:
        fit: of the nominal model with its causes.
        heldout: for each run (T, M, A) predicted minus measured by a model fitted to the other runs.
        model: the same as the judgement sees it.
    """

    fit: Fit
    heldout: tuple[Array, ...]
    model: Model

    @property
    def names(self) -> tuple[str, ...]:
        """Of its causes; sorted."""
        return self.model.names

    @property
    def key(self) -> Key:
        """What tells it from other models."""
        key: Key = self.fit.hypothesis.key
        return key

    @property
    def heldout_square(self) -> float:
        """Mean squared distance on held-out trials."""
        return squares(self.heldout).mean

    def special_case_of(self, other: Candidate) -> bool:
        """Whether it is another model with a part left out, or with a law that the other's law contains in its place.

        Of the same laws that is one which has one size for all levels where the other has a size for each.
        """
        own, others = ({part.name: part for part in each.fit.hypothesis.parts} for each in (self, other))
        if not own:
            return False
        if own.keys() == others.keys():
            unlike = [(others[name], part) for name, part in own.items() if others[name].reading != part.reading]
            return bool(unlike) and all(general.contains(part) for general, part in unlike)
        if own.keys() < others.keys():
            return True
        general = [part for name, part in others.items() if name not in own]
        return all(name in others or any(each.contains(part) for each in general) for name, part in own.items())


def data_of(problem: Problem) -> Data:
    """The scale on which residuals of these recordings count, for one coordinate."""
    seen = sum(int(np.isfinite(run.compared).sum()) for run in problem.runs)
    return Data(float(np.mean(problem.noise**2)), seen)


def full_fit(problem: Problem, start: Fit, variants: Mapping[str, int]) -> Candidate:
    """The full fit from where a quick one ended, and every run predicted from the others.

    Args:
        problem: what to fit to, and who simulates it.
        start: model and values to begin with.
        variants: how many variants of each law are offered.
    """
    answer = fit(problem, start.hypothesis, start=start.values)
    return candidate(problem, answer, variants)


def candidate(problem: Problem, fit: Fit, variants: Mapping[str, int]) -> Candidate:
    """A fit with its held-out error and what the judgement needs; arguments as of :func:`full_fit`."""
    return Candidate(fit, tuple(leave_one_out(problem, fit)), model_of(problem, fit, variants))


def model_of(problem: Problem, fit: Fit, variants: Mapping[str, int]) -> Model:
    """What the judgement needs to know of a fit; what belongs to single trials is marginalised."""
    facts, axes = fit.hypothesis.parameters, fit.residuals[0].shape[-1]
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fit.values, strict=True)])
    departures = np.array([fact.departure(value) for fact, value in zip(facts, fit.values, strict=True)])
    told = information([slopes for _, slopes in fit.whitened()], widths)
    square = 1 / float(np.mean(1 / problem.floor**2))  # residuals are whitened by it
    at_bound = {name.partition(".")[0] for name in fit.on_bound()}
    causes = tuple(
        Cause(part.name, part.kind, part.flexible or part.name in at_bound, variants.get(part.name, 1))
        for part in fit.hypothesis.parts
    )
    return Model(causes, lasting_square(fit.residuals) / axes, told * square, departures)
