"""Explanation of the differences between a rigid-link robot and its declared model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hsr_pin.explain.explain import CHANGE, explain, explain_change, floors
from hsr_pin.explain.result import Explanation
from hsr_pin.inference.verdict import Vocabulary
from hsr_pin.robots.cause import KINDS
from hsr_pin.robots.model import RobotModel
from hsr_pin.robots.read import RobotRecordings, read_robot

#: Words of a verdict on a robot.
VOCABULARY = Vocabulary("the declared numbers", floors, KINDS)


def explain_robot(
    recordings: RobotRecordings | str | Path, *, seconds: float | None = None, test: Sequence[str] = (), **options: Any
) -> Explanation:
    """Find out which physics the declared model of a robot lacks.

    Args:
        recordings: recordings of the robot, or the folder that contains them (``robot.toml``).
        seconds: length of the stretches into which the trials are cut; default: chosen from the data.
        test: names of held-out trials, on which the error budget is evaluated.
        options: further arguments of :func:`~hsr_pin.explain.explain.explain`.

    Raises:
        InputError: the recordings cannot be read, or contain too little data.
    """
    given = recordings if isinstance(recordings, RobotRecordings) else read_robot(recordings)
    model = RobotModel.of(given)
    stretches = model.trials(seconds)
    heldout = [each.name for each in stretches if each.labels["trial"] in test]
    found = explain(model.as_model, stretches, test=heldout, words=VOCABULARY, **options)
    return replace(found, notes=(*given.notes, _stretch_note(stretches)))


def explain_robot_change(
    new: RobotRecordings | str | Path, old: RobotRecordings | str | Path, *, seconds: float | None = None, **options: Any
) -> Explanation:
    """Find out what differs in a robot between two sessions with the same commands.

    Args:
        new: recordings of the later session, or their folder.
        old: recordings of the earlier session, or their folder; trials of the same name are compared.
        seconds: length of the stretches into which the trials are cut; default: chosen from the data of the earlier session.
        options: further arguments of :func:`~hsr_pin.explain.explain.explain`.

    Raises:
        InputError: the recordings cannot be read, or have no trials in common.
    """
    current, reference = (each if isinstance(each, RobotRecordings) else read_robot(each) for each in (new, old))
    reference_model = RobotModel.of(reference)
    old_trials = reference_model.trials(seconds)
    length = float(old_trials[0].time[-1] - old_trials[0].time[0])
    new_trials = RobotModel(current, reference_model.causes, reference_model.scales).trials(length)
    words = replace(CHANGE, kinds=KINDS)
    found = explain_change(reference_model.as_model, new_trials, old_trials, words=words, **options)
    return replace(found, notes=(*current.notes, _stretch_note(old_trials)))


def _stretch_note(stretches: Sequence[Any]) -> str:
    """Return the note on the number and the length of the simulated stretches."""
    seconds = float(stretches[0].time[-1] - stretches[0].time[0])
    return f"{len(stretches)} stretches of {seconds:.2g} s are simulated; each starts at the encoder angles"
