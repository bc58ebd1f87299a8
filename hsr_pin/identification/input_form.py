"""What a command does between its samples, where recordings do not say: held, or straight from one to the next.

A command that is held comes half a sample later than one that is not. Of a chirp, a ramp or a measured pressure it is as much as
a small lag, and no law of an arm mends it. So where it is not declared, and a command of the recordings is a curve, they decide:
all are held, or the curves alone go straight, or the steps do too (of a controller that runs faster than it is recorded, a step
comes anywhere between two samples: half a sample earlier in the mean). Of steps alone it is not asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.holds import clock
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.fit import Fit, fit

#: Of open commands: all are held, only steps are, or all go straight from sample to sample.
Form = Literal["held", "steps held", "straight"]
_FORMS: tuple[Form, ...] = ("held", "steps held", "straight")
#: A command that changes at this share of its samples is a curve, and no row of steps.
_CURVE = 0.25
_STRAIGHT = 'goes straight from sample to sample, as these recordings show (input = "held" in dataset.toml says otherwise)'


def is_open(run: Run) -> bool:
    """Whether nobody says what the command of a run does between its samples, and it makes a difference."""
    return run.trial.interpolated is None and _changing(run) > 0


def form_of(experiment: Experiment) -> Form:
    """How commands that are open are taken now."""
    runs = [run for run in experiment.runs if is_open(run) and run.interpolated]
    return "held" if not runs else "steps held" if all(map(_is_curve, runs)) and _steps(experiment) else "straight"


def taken(experiment: Experiment, form: Form) -> Experiment:
    """With the commands that are open taken in one way."""

    def straight(run: Run) -> bool:
        return form == "straight" or (form == "steps held" and _is_curve(run))

    runs = tuple(replace(run, interpolated=straight(run)) if is_open(run) else run for run in experiment.runs)
    names = [run.trial.name for run in runs if is_open(run) and run.interpolated]
    notes = [note for note in experiment.notes if not note.endswith(_STRAIGHT)]
    told = [f"the command of {', '.join(names)} {_STRAIGHT}"] if names else []
    return replace(experiment, runs=runs, notes=(*notes, *told))


def otherwise(experiment: Experiment) -> list[Experiment]:
    """With the commands that are open taken in each of the other ways; none where no curve is open."""
    if not any(is_open(run) and _is_curve(run) for run in experiment.runs):
        return []
    forms = _FORMS if _steps(experiment) else (_FORMS[0], _FORMS[2])
    return [taken(experiment, form) for form in forms if form != form_of(experiment)]


def as_it_fits(experiment: Experiment, found: Fit) -> tuple[Experiment, Fit]:
    """A fit, and its experiment, with the commands that are open as they fit best."""
    tried = [(experiment, found)]
    tried += [(other, fit(other, found.hypothesis, start=found.values)) for other in otherwise(experiment)]
    return min(tried, key=lambda each: each[1].rms)


def _steps(experiment: Experiment) -> Sequence[Run]:
    return [run for run in experiment.runs if is_open(run) and not _is_curve(run)]


def _is_curve(run: Run) -> bool:
    return _changing(run) >= _CURVE


def _changing(run: Run) -> float:
    """Share of the samples at which a command changes, of those at which it may: a logger may hold it between them."""
    return float(np.diff(run.command, axis=0).any(axis=1).mean()) * clock(run.command)
