"""Why a robot does not move as its model: explain for the joints of a robot of rigid links."""

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

#: How a verdict on a robot calls what it speaks of.
WORDS = Vocabulary("the declared numbers", floors, KINDS)


def explain_robot(
    recordings: RobotRecordings | str | Path, *, seconds: float | None = None, test: Sequence[str] = (), **options: Any
) -> Explanation:
    """Say what the declared model of a robot lacks.

    Args:
        recordings: of the robot, or the folder that holds them (``robot.toml``).
        seconds: of the stretches into which they are cut; default: chosen by the data.
        test: names of trials that are set aside: the ladder is told on them.
        options: as of :func:`~hsr_pin.explain.explain.explain`.

    Raises:
        InputError: recordings that cannot be read, or say too little.
    """
    given = recordings if isinstance(recordings, RobotRecordings) else read_robot(recordings)
    model = RobotModel.of(given)
    stretches = model.trials(seconds)
    aside = [each.name for each in stretches if each.labels["trial"] in test]
    found = explain(model.as_model, stretches, test=aside, words=WORDS, **options)
    return replace(found, notes=(*given.notes, _cut(stretches)))


def explain_robot_change(
    new: RobotRecordings | str | Path, old: RobotRecordings | str | Path, *, seconds: float | None = None, **options: Any
) -> Explanation:
    """Say what differs in a robot between two sessions in which it was driven alike.

    Args:
        new: recordings of the later session, or their folder.
        old: of the earlier one; trials of the same name are compared.
        seconds: of the stretches into which they are cut; default: chosen by the data of the earlier one.
        options: as of :func:`~hsr_pin.explain.explain.explain`.

    Raises:
        InputError: recordings that cannot be read, or that have nothing to compare.
    """
    late, early = (each if isinstance(each, RobotRecordings) else read_robot(each) for each in (new, old))
    before = RobotModel.of(early)
    old_trials = before.trials(seconds)
    length = float(old_trials[0].time[-1] - old_trials[0].time[0])
    new_trials = RobotModel(late, before.causes, before.sizes).trials(length)
    words = replace(CHANGE, kinds=KINDS)
    found = explain_change(before.as_model, new_trials, old_trials, words=words, **options)
    return replace(found, notes=(*late.notes, _cut(old_trials)))


def _cut(stretches: Sequence[Any]) -> str:
    """What was looked at."""
    seconds = float(stretches[0].time[-1] - stretches[0].time[0])
    return f"{len(stretches)} stretches of {seconds:.2g} s are simulated, each from where the encoders show the robot to be"
