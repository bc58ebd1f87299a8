"""The form of a command between its samples, if it is not declared: held, or interpolated linearly.

A command that is held acts half a sample later than one that is interpolated. For a chirp, a ramp or a measured pressure, this is
equivalent to a small lag, which no law of an arm can compensate. Therefore, if the form is not declared and a command of the
recordings is a curve, the fit decides between three forms: all commands are held; only the curves are interpolated; all are
interpolated (if a controller is faster than the recording, a step occurs anywhere between two samples, half a sample earlier on
average). If all commands consist of steps, they are held.
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

#: Forms of undeclared commands: all are held, only those with steps are held, or all are interpolated.
Form = Literal["held", "steps held", "straight"]
_FORMS: tuple[Form, ...] = ("held", "steps held", "straight")
#: Share of changing samples above which a command is treated as a curve instead of a sequence of steps.
_CURVE = 0.25
_STRAIGHT = (
    'is interpolated linearly between samples, because the recordings fit better (input = "held" in dataset.toml overrides this)'
)


def is_open(run: Run) -> bool:
    """Return whether the form of a run's command is undeclared and makes a difference."""
    return run.trial.interpolated is None and _changing(run) > 0


def form_of(experiment: Experiment) -> Form:
    """Return the form that an experiment currently uses for undeclared commands."""
    runs = [run for run in experiment.runs if is_open(run) and run.interpolated]
    return "held" if not runs else "steps held" if all(map(_is_curve, runs)) and _steps(experiment) else "straight"


def with_form(experiment: Experiment, form: Form) -> Experiment:
    """Return an experiment with a given form of undeclared commands."""

    def straight(run: Run) -> bool:
        return form == "straight" or (form == "steps held" and _is_curve(run))

    runs = tuple(replace(run, interpolated=straight(run)) if is_open(run) else run for run in experiment.runs)
    names = [run.trial.name for run in runs if is_open(run) and run.interpolated]
    notes = [note for note in experiment.notes if not note.endswith(_STRAIGHT)]
    added = [f"the command of {', '.join(names)} {_STRAIGHT}"] if names else []
    return replace(experiment, runs=runs, notes=(*notes, *added))


def alternative_forms(experiment: Experiment) -> list[Experiment]:
    """Return experiments with the other possible forms of undeclared commands; none if no undeclared command is a curve."""
    if not any(is_open(run) and _is_curve(run) for run in experiment.runs):
        return []
    forms = _FORMS if _steps(experiment) else (_FORMS[0], _FORMS[2])
    return [with_form(experiment, form) for form in forms if form != form_of(experiment)]


def best_form(experiment: Experiment, found: Fit) -> tuple[Experiment, Fit]:
    """Return the experiment and the fit with the form of undeclared commands that fits best."""
    tried = [(experiment, found)]
    tried += [(other, fit(other, found.hypothesis, start=found.values)) for other in alternative_forms(experiment)]
    return min(tried, key=lambda each: each[1].rms)


def _steps(experiment: Experiment) -> Sequence[Run]:
    return [run for run in experiment.runs if is_open(run) and not _is_curve(run)]


def _is_curve(run: Run) -> bool:
    return _changing(run) >= _CURVE


def _changing(run: Run) -> float:
    """Return the share of samples at which a command changes, among those at which its logger allows changes."""
    return float(np.diff(run.command, axis=0).any(axis=1).mean()) * clock(run.command)
