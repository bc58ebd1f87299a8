"""Identify the arm from its recordings: fitted values, how sure they are, and the error on trials that were not fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.choice import choose, without_effects
from hsr_pin.identification.evaluation import predict_all
from hsr_pin.identification.experiment import Experiment, prepare, restricted
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.input_form import as_it_fits, form_of, taken
from hsr_pin.identification.plane import in_its_plane
from hsr_pin.identification.starts import starts
from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.heldout import leave_one_out
from hsr_pin.inference.residuals import residuals, rms
from hsr_pin.inference.uncertainty import Uncertainty, uncertainty
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import Placement
from hsr_pin.trajectory import Array, Dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Identification:
    """What the recordings say about the open parameters.

    Attributes:
        experiment: the trials that were fitted.
        heldout_experiment: the trials that were predicted: those set aside, or else each fitted trial, left out of its own fit.
        set_aside: whether they were set aside.
        fit: of the open parameters.
        uncertainty: of its values.
        before: for each fitted trial (T, M, A) [m] predicted minus measured by the arm as declared, finely discretised.
        heldout_before: likewise for each predicted trial.
        heldout: for each predicted trial, by the fitted model. Empty for a single trial: nothing was held out.
    """

    experiment: Experiment
    heldout_experiment: Experiment
    set_aside: bool
    fit: Fit
    uncertainty: Uncertainty
    before: tuple[Array, ...]
    heldout_before: tuple[Array, ...]
    heldout: tuple[Array, ...]

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} {value:.4g} [{low:.4g}, {high:.4g}]"
            for (name, value), (low, high) in zip(self.fit.named.items(), self.uncertainty.interval, strict=True)
        )
        return f"<Identification of {self.experiment.dataset.name}: {values}; RMS {1e3 * self.fit.rms:.3g} mm>"

    def plot(self) -> Figure:
        """Measured, declared and fitted motion of the farthest marker, for up to six trials."""
        from hsr_pin.identification.figure import fit_figure

        return fit_figure(self)

    @property
    def after(self) -> tuple[Array, ...]:
        """For each fitted trial (T, M, A) [m] predicted minus measured by the fitted model."""
        return self.fit.residuals

    @property
    def tip(self) -> int:
        """Index of the marker farthest along the arm."""
        return int(np.argmax([marker.arc_length for marker in self.experiment.markers]))

    def tip_rms(self, missed: Sequence[Array]) -> float:
        """RMS distance [m] of the farthest marker over some trials; NaN for none."""
        return rms([residual[:, [self.tip]] for residual in missed]) if missed else float("nan")


def identify(
    dataset: Dataset | str | Path,
    *,
    free: Sequence[str] = ("keq_scale", "damping_scale"),
    effects: Sequence[Effect] = (),
    links: int | None = None,
    placement: Placement | None = None,
    by_level: bool = False,
    train: Sequence[str] = (),
    test: Sequence[str] = (),
    delay: float = 0.0,
    tell: Callable[[str], None] = lambda stage: None,
) -> Identification:
    """Fit named parameters to a dataset.

    Args:
        dataset: the recordings; or the folder that holds them, or the name of a sample.
        free: names of the parameters, as :func:`hsr_pin.identification.choice.choose` takes them.
        effects: act beside the nominal model, all their parameters open.
        links: of the chain that is fitted; default: 16, or as many as simulated the dataset.
        placement: of its joints; default: in the middle of each element, or as in the simulation.
        by_level: a stiffness and a damping for each declared Keq instead of one factor for all.
        train: names or patterns ("trial_0[12]") of the trials to fit; default: all that are not set aside.
        test: of the trials set aside to be predicted; default: those not fitted; if there are none, each trial is predicted by a
            fit to the others.
        delay: trials that start from a pose are followed only from so long after their declared start [s].
        tell: called with the name of each stage.

    Raises:
        IdentificationError: an unknown parameter, or nothing in the dataset can be compared.
    """
    tell("reading the recordings")
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    whole = in_its_plane(prepare(dataset, delay=delay))[0]
    fitted, predicted = split(whole, train, test)
    hypothesis = choose(free, effects, fitted.runs, **chain_of(dataset, links, placement), by_level=by_level)
    tell("looking where to start")
    points = starts(fitted, hypothesis)
    tell("fitting")
    answer = fit_from(fitted, hypothesis, points)
    fitted, answer = as_it_fits(fitted, answer)
    if predicted is not None:
        predicted = taken(predicted, form_of(fitted))
    tell("predicting held-out trials")
    plain = without_effects(hypothesis)
    before = simulated(fitted, plain, np.empty(0))
    if predicted is not None:
        heldout = simulated(predicted, hypothesis, answer.values)
        heldout_before = simulated(predicted, plain, np.empty(0))
    elif len(fitted.runs) > 1:
        heldout, heldout_before = leave_one_out(fitted, answer), before
    else:
        heldout, heldout_before = [], []
    return Identification(
        experiment=fitted,
        heldout_experiment=fitted if predicted is None else predicted,
        set_aside=predicted is not None,
        fit=answer,
        uncertainty=uncertainty(answer),
        before=tuple(before),
        heldout_before=tuple(heldout_before),
        heldout=tuple(heldout),
    )


def split(experiment: Experiment, train: Sequence[str], test: Sequence[str]) -> tuple[Experiment, Experiment | None]:
    """The trials to fit, and those set aside; None if none are."""
    names = [run.trial.name for run in experiment.runs]
    fitted, aside = _matching(names, train), _matching(names, test)
    if not train:
        fitted = set(names) - aside
    if train and not test:
        aside = set(names) - fitted
    if not fitted:
        raise IdentificationError("trials to fit", expected="at least one", received="all of them set aside")
    if fitted & aside:
        both = ", ".join(sorted(fitted & aside))
        raise IdentificationError("trials", expected="each fitted or set aside", received=f"{both} in both")
    return restricted(experiment, fitted), restricted(experiment, aside) if aside else None


def _matching(names: Sequence[str], patterns: Sequence[str]) -> set[str]:
    found: set[str] = set()
    for pattern in patterns:
        matches = {name for name in names if fnmatchcase(name, pattern)}
        if not matches:
            raise IdentificationError("trials", expected=f"a name or pattern among {', '.join(names)}", received=repr(pattern))
        found |= matches
    return found


def fit_from(experiment: Experiment, hypothesis: Hypothesis, points: Sequence[Array]) -> Fit:
    """A quick fit from each of several points if there are several, and a full one from where the best of them ended."""
    if len(points) == 1:
        return fit(experiment, hypothesis, start=points[0])
    quick = [fit(experiment, hypothesis, start=point, quick=True) for point in points]
    best = min(quick, key=lambda answer: answer.rms)
    return fit(experiment, hypothesis, start=best.values)


def simulated(experiment: Experiment, hypothesis: Hypothesis, values: Array) -> list[Array]:
    """For each run (T, M, A) [m] predicted minus measured, with the open parameters at ``values`` (P,)."""
    return residuals(experiment, predict_all(experiment, hypothesis, values))
