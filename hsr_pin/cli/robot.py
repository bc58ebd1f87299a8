"""Command ``hsr-diagnose`` for recordings of a rigid-link robot (a folder with ``robot.toml``)."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from hsr_pin.cli.judging import loss_from, print_and_write, progress
from hsr_pin.errors import InputError

if TYPE_CHECKING:
    from hsr_pin.explain.result import Explanation

#: Number of progress stages in addition to the causes.
_STAGES = 1
#: Options that apply to soft arms only, with their defaults.
_ARMS = {"links": None, "placement": None, "delay": 0.0, "cluster": None}


def run_robot(dataset: str, options: dict[str, Any]) -> None:
    """Explain the recordings of a robot, print the report and write the files.

    Raises:
        InputError: an option does not apply to a robot.
    """
    for name, usual in _ARMS.items():
        if options[name] != usual:
            raise InputError(f"--{name}", expected="no use of this option for a robot (robot.toml)", received=options[name])
    if options["train"]:
        raise InputError("--train", expected="--test with the trials to hold out", received=options["train"])
    found = _explained(dataset, options)
    from hsr_pin.cli.console import print_lines

    print_and_write(options, found.to_json, lambda: print_lines(lambda width: screen(found, width)), found.to_html)


def screen(found: Explanation, width: int) -> list[str]:
    """Return the lines of the report."""
    from hsr_pin.explain.where import sentence
    from hsr_pin.inference.detection import detection_sentence

    lines = [f"{found.recordings.model.name}: {found.headline}", *textwrap.wrap(found.verdict.sentence, width), ""]
    columns = width - 26
    lines.append(f"{'held-out trials':<{columns}}{'RMS [floors]':>14}{'of gap²':>12}")
    for place, stage in enumerate(found.ladder):
        name = "noise floor; rest unexplained" if stage is found.ladder[-1] else stage.name
        share = f"{100 * stage.share:.1f} %" if place else ""
        lines.append(f"{name[:columns]:<{columns}}{stage.rms:>14.3g}{share:>12}")
    lines += ["", f"most probable model: {' + '.join(found.search.best.names) or 'as declared'}"]
    lines += [f"  {each}" for each in found.estimates]
    limits = detection_sentence(found.search.detection)
    rest = [
        ("where: ", sentence(found.where)),
        *[("limit: ", limits)] * bool(limits),
        *(("note:  ", note) for note in found.notes),
    ]
    return [*lines, "", *(line for head, text in rest for line in textwrap.wrap(head + text, width, subsequent_indent=" " * 7))]


def _explained(dataset: str, options: dict[str, Any]) -> Explanation:
    from hsr_pin.cli.trials import listed
    from hsr_pin.robots.explain import explain_robot, explain_robot_change
    from hsr_pin.robots.read import read_robot

    given: dict[str, Any] = {"max_causes": options["max_effects"], "seed": options["seed"], "loss": loss_from(options)}
    given["jobs"] = options["jobs"]
    if options["effects"] is not None:
        given["causes"] = listed(options["effects"])
    recordings = read_robot(dataset)
    with progress(options["max_effects"] + _STAGES) as (report_stage, advance):
        given |= {"tell": report_stage, "advance": advance}
        if not options["since"]:
            return explain_robot(recordings, test=listed(options["test"]), **given)
        if len(options["since"]) > 1 or options["test"]:
            expected = "one earlier session of the robot and no --test"
            raise InputError("--since", expected=expected, received="several sessions or --test")
        return explain_robot_change(recordings, options["since"][0], **given)
