"""``hsr-diagnose FOLDER`` where the folder holds recordings of a robot of rigid links (``robot.toml``)."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.errors import InputError

if TYPE_CHECKING:
    from hsr_pin.explain.result import Explanation

#: Stages beside the causes.
_STAGES = 1
#: Options that only an arm has, with what they are where nobody gives them.
_ARMS = {"links": None, "placement": None, "delay": 0.0, "cluster": None}


def tell_robot(dataset: str, options: dict[str, Any]) -> None:
    """Explain, print, then write the files.

    Raises:
        InputError: an option that a robot does not have.
    """
    for name, usual in _ARMS.items():
        if options[name] != usual:
            raise InputError(f"--{name}", expected="no such option for a robot (robot.toml)", received=options[name])
    if options["train"]:
        raise InputError("--train", expected="--test, with the trials that are set aside", received=options["train"])
    found = _explained(dataset, options)
    from hsr_pin.cli.console import console, shown
    from hsr_pin.cli.diagnose_report import print_written

    with shown():
        if options["json_file"] == "-":
            click.echo(_document(found))
        else:
            to = console()
            for line in screen(found, to.width):
                to.print(line, soft_wrap=True)
    written: list[str] = []
    try:
        for name in _write(found, options):
            written.append(name)
    finally:
        if options["json_file"] != "-":
            print_written(written)


def screen(found: Explanation, width: int) -> list[str]:
    """The lines of the report."""
    from hsr_pin.explain.where import sentence

    lines = [f"{found.recordings.model.name}: {found.headline}", *textwrap.wrap(found.verdict.sentence, width), ""]
    room = width - 26
    lines.append(f"{'error on trials it was not fitted to':<{room}}{'RMS [floors]':>14}{'of gap²':>12}")
    for place, rung in enumerate(found.ladder):
        name = "noise floor; rest unexplained" if rung is found.ladder[-1] else rung.name
        share = f"{100 * rung.share:.1f} %" if place else ""
        lines.append(f"{name[:room]:<{room}}{rung.rms:>14.3g}{share:>12}")
    lines += ["", f"most probable model: {' + '.join(found.search.best.names) or 'as declared'}"]
    lines += [f"  {each}" for each in found.estimates]
    rest = [("where: ", sentence(found.where)), *(("note:  ", note) for note in found.notes)]
    return [*lines, "", *(line for head, text in rest for line in textwrap.wrap(head + text, width, subsequent_indent=" " * 7))]


def _explained(dataset: str, options: dict[str, Any]) -> Explanation:
    from hsr_pin.cli.judging import loss_from, progress
    from hsr_pin.cli.trials import listed
    from hsr_pin.robots.explain import explain_robot, explain_robot_change
    from hsr_pin.robots.read import read_robot

    given: dict[str, Any] = {"max_causes": options["max_effects"], "seed": options["seed"], "loss": loss_from(options)}
    given["jobs"] = options["jobs"]
    if options["effects"] is not None:
        given["causes"] = listed(options["effects"])
    recordings = read_robot(dataset)
    with progress(options["max_effects"] + _STAGES) as (tell, advance):
        given |= {"tell": tell, "advance": advance}
        if not options["since"]:
            return explain_robot(recordings, test=listed(options["test"]), **given)
        if len(options["since"]) > 1 or options["test"]:
            raise InputError("--since", expected="one earlier session of the robot, and no --test", received="more")
        return explain_robot_change(recordings, options["since"][0], **given)


def _document(found: Explanation) -> str:
    return json.dumps(found.to_json(), indent=2, allow_nan=False, ensure_ascii=False)


def _write(found: Explanation, options: dict[str, Any]) -> Iterator[str]:
    """Write what was asked for, and name each file when it is there."""
    if options["json_file"] not in (None, "-"):
        from hsr_pin.output import write_text

        write_text(options["json_file"], _document(found) + "\n")
        yield options["json_file"]
    if options["html_file"] is not None:
        found.to_html(options["html_file"])
        yield options["html_file"]
