"""What a command does between its samples, where recordings do not say: held, or straight from one to the next.

A command that is held comes half a sample later than one that is not. Of steps it makes no difference which is meant; of a chirp,
a ramp or a measured pressure it is as much as a small lag, and no law of an arm mends it. So where it is not declared, and the
command changes from sample to sample, the recordings decide.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.fit import Fit, fit

#: A command that changes at this share of its samples is a curve, and no row of steps.
_CURVE = 0.25
_STRAIGHT = 'goes straight from sample to sample, as these recordings show (input = "held" in dataset.toml says otherwise)'


def is_open(run: Run) -> bool:
    """Whether nobody says what the command of a run does between its samples, and it makes a difference."""
    return run.trial.interpolated is None and float(np.diff(run.command, axis=0).any(axis=1).mean()) >= _CURVE


def goes_straight(experiment: Experiment) -> bool:
    """How commands that are open are taken now."""
    return any(is_open(run) and run.interpolated for run in experiment.runs)


def taken(experiment: Experiment, *, straight: bool) -> Experiment:
    """With every command that is open held between its samples, or straight from one to the next."""
    names = [run.trial.name for run in experiment.runs if is_open(run)]
    runs = tuple(replace(run, interpolated=straight) if is_open(run) else run for run in experiment.runs)
    notes = [note for note in experiment.notes if not note.endswith(_STRAIGHT)]
    told = [f"the command of {', '.join(names)} {_STRAIGHT}"] if names and straight else []
    return replace(experiment, runs=runs, notes=(*notes, *told))


def otherwise(experiment: Experiment) -> Experiment | None:
    """With every command that is open taken the other way; None where none is."""
    return taken(experiment, straight=not goes_straight(experiment)) if any(map(is_open, experiment.runs)) else None


def as_it_fits(experiment: Experiment, found: Fit) -> tuple[Experiment, Fit]:
    """A fit, and its experiment, with the commands that are open as they fit best."""
    other = otherwise(experiment)
    if other is None:
        return experiment, found
    turned = fit(other, found.hypothesis, start=found.values)
    return (other, turned) if turned.rms < found.rms else (experiment, found)
