"""Identification of the arm from its recordings: fitted values, their uncertainty, and the error on held-out trials."""

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
from hsr_pin.identification.input_form import best_form, form_of, with_form
from hsr_pin.identification.plane import with_plane_corrected
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
    """The fitted values of the open parameters, with uncertainty and prediction errors.

    Attributes:
        experiment: the trials that were fitted.
        heldout_experiment: the trials that were predicted: those set aside, or else each fitted trial, left out of its own fit.
        set_aside: whether trials were set aside.
        fit: the fit of the open parameters.
        uncertainty: the uncertainty of the fitted values.
        before: (T, M, A) for each fitted trial, prediction of the declared arm minus measurement, with a fine chain [m].
        heldout_before: (T, M, A) the same for each predicted trial [m].
        heldout: (T, M, A) for each predicted trial, prediction of the fitted model minus measurement [m]; empty for a single
            trial, of which nothing is held out.
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
        """Plot the measured, declared and fitted motion of the farthest marker, for up to six trials."""
        from hsr_pin.identification.figure import fit_figure

        return fit_figure(self)

    @property
    def after(self) -> tuple[Array, ...]:
        """For each fitted trial, prediction of the fitted model minus measurement (T, M, A) [m]."""
        return self.fit.residuals

    @property
    def tip(self) -> int:
        """Index of the marker farthest along the arm."""
        return int(np.argmax([marker.arc_length for marker in self.experiment.markers]))

    def tip_rms(self, missed: Sequence[Array]) -> float:
        """Return the RMS distance [m] of the farthest marker over several trials; NaN for none."""
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
        dataset: the recordings, the folder that contains them, or the name of a sample.
        free: names of the parameters, as for :func:`hsr_pin.identification.choice.choose`.
        effects: effects in addition to the nominal model, all their parameters open.
        links: number of links of the fitted chain; default: 16, or that of the model which simulated the dataset.
        placement: placement of its joints; default: in the middle of each element, or as in the simulation.
        by_level: whether each declared Keq has its own stiffness and damping instead of one factor for all.
        train: names or patterns ("trial_0[12]") of the trials to fit; default: all that are not set aside.
        test: names or patterns of the trials that are set aside for prediction; default: those not fitted; if all are fitted,
            each trial is predicted by a fit to the others.
        delay: time after the declared start from which trials that start from a pose are used [s].
        tell: function that is called with the name of each stage.

    Raises:
        IdentificationError: a parameter is unknown, or no trial of the dataset can be compared.
    """
    tell("reading the recordings")
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    whole = with_plane_corrected(prepare(dataset, delay=delay))[0]
    fitted, predicted = split(whole, train, test)
    hypothesis = choose(free, effects, fitted.runs, **chain_of(dataset, links, placement), by_level=by_level)
    tell("searching for initial values")
    points = starts(fitted, hypothesis)
    tell("fitting")
    answer = fit_from(fitted, hypothesis, points)
    fitted, answer = best_form(fitted, answer)
    if predicted is not None:
        predicted = with_form(predicted, form_of(fitted))
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
    """Return the trials to fit and the trials set aside; None if none are set aside."""
    names = [run.trial.name for run in experiment.runs]
    fitted, aside = _matching(names, train), _matching(names, test)
    if not train:
        fitted = set(names) - aside
    if train and not test:
        aside = set(names) - fitted
    if not fitted:
        raise IdentificationError("trials to fit", expected="at least one", received="all trials set aside")
    if fitted & aside:
        both = ", ".join(sorted(fitted & aside))
        raise IdentificationError("trials", expected="each trial either fitted or set aside", received=f"{both} in both")
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
    """Fit from several initial values: a quick fit from each of them, and a full fit from the best result."""
    if len(points) == 1:
        return fit(experiment, hypothesis, start=points[0])
    quick = [fit(experiment, hypothesis, start=point, quick=True) for point in points]
    best = min(quick, key=lambda answer: answer.rms)
    return fit(experiment, hypothesis, start=best.values)


def simulated(experiment: Experiment, hypothesis: Hypothesis, values: Array) -> list[Array]:
    """Return, for each run, prediction minus measurement (T, M, A) [m] with the open parameters at ``values`` (P,)."""
    return residuals(experiment, predict_all(experiment, hypothesis, values))
