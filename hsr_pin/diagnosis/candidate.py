"""A fitted model of the arm, and what the judgement needs to know of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.resampling import squares
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit, fit
from hsr_pin.identification.heldout import leave_one_out
from hsr_pin.identification.hypothesis import ARM, Hypothesis
from hsr_pin.identification.misfit import floor
from hsr_pin.inference import Cause, Data, Model
from hsr_pin.inference.model import information
from hsr_pin.inference.residuals import lasting_square
from hsr_pin.trajectory import Array

#: What a model has beside stiffness and damping: name, options, size and open amplitudes of each part.
Key = tuple[tuple[object, ...], ...]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fitted model and its error on held-out trials.

    Attributes:
        fit: of the nominal model with these effects, K and C.
        heldout: for each run (T, M, A) [m] predicted minus measured by a model fitted to the other runs.
        model: the same as the judgement sees it.
    """

    fit: Fit
    heldout: tuple[Array, ...]
    model: Model

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects, and of the arm's numbers that are open beside stiffness and damping; sorted."""
        return self.model.names

    @property
    def key(self) -> Key:
        """What it has beside stiffness and damping, in which variant."""
        return key_of(self.fit.hypothesis)

    @property
    def heldout_square(self) -> float:
        """[m^2] mean squared distance of the markers on held-out trials."""
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


def key_of(hypothesis: Hypothesis) -> Key:
    """What a hypothesis has beside stiffness and damping, in which variant."""
    readings = tuple(sorted((part.reading for part in hypothesis.parts), key=repr))
    of_arm = tuple((name,) for name in hypothesis.free if name.partition("@")[0] in ARM and "@" in name)
    return readings + of_arm


def data_of(experiment: Experiment) -> Data:
    """The scale on which residuals of these recordings count, for one coordinate."""
    axes = len(experiment.axes)
    seen = sum(int(np.isfinite(run.compared).sum()) for run in experiment.runs)
    return Data(experiment.noise_rms**2 / axes, seen)


def full_fit(experiment: Experiment, start: Fit, variants: Mapping[str, int]) -> Candidate:
    """The full fit from where a quick one ended, and every run predicted from the others.

    Args:
        experiment: what to fit to.
        start: model and values to begin with.
        variants: how many variants of each law are offered.
    """
    answer = fit(experiment, start.hypothesis, start=start.values)
    return candidate(experiment, answer, variants)


def candidate(experiment: Experiment, fit: Fit, variants: Mapping[str, int]) -> Candidate:
    """A fit with its held-out error and what the judgement needs; arguments as of :func:`full_fit`."""
    return Candidate(fit, tuple(leave_one_out(experiment, fit)), model_of(experiment, fit, variants))


def model_of(experiment: Experiment, fit: Fit, variants: Mapping[str, int]) -> Model:
    """What the judgement needs to know of a fit; what belongs to single trials is marginalised."""
    facts, axes = fit.hypothesis.parameters, len(experiment.axes)
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fit.values, strict=True)])
    departures = np.array([fact.departure(value) for fact, value in zip(facts, fit.values, strict=True)])
    told = information([slopes for _, slopes in fit.whitened()], widths)
    square = 1 / float(np.mean(1 / floor(experiment) ** 2))  # [m^2] residuals are whitened by it
    at_bound = {name.partition(".")[0] for name in fit.on_bound()}
    causes = tuple(
        Cause(part.name, part.kind, part.flexible or part.name in at_bound, variants.get(part.name, 1))
        for part in fit.hypothesis.parts
    )
    return Model(causes, lasting_square(fit.residuals) / axes, told * square, departures)
