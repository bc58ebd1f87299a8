"""Command ``hsr-diagnose --since``: find the changes of an arm between recordings."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import chain_from
from hsr_pin.errors import InputError

if TYPE_CHECKING:
    from hsr_pin.diagnosis.change.history import History

#: Number of progress stages of a comparison in addition to the model of the reference: reading, discrepancy, changes.
_STAGES = 3


def run_since(dataset: str, options: dict[str, Any]) -> None:
    """Compare the recordings, print the report and write the files.

    Raises:
        InputError: an option does not apply to a comparison, or a recording is named twice.
    """
    for name in ("train", "test"):
        if options[name]:
            raise InputError(f"--{name}", expected="no use of this option with --since", received=options[name])
    folders = [*options["since"], dataset]
    places = [Path(folder).resolve() for folder in folders]
    if len(set(places)) < len(places):
        raise InputError("--since", expected="different recordings", received="the same recording twice")
    found = _history(folders, options)
    from hsr_pin.cli.change_report import screen
    from hsr_pin.cli.console import console, ignore_closed_pipe
    from hsr_pin.cli.diagnose_report import print_written

    with ignore_closed_pipe():
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


def _history(folders: list[str], options: dict[str, Any]) -> History:
    from hsr_pin.cli.judging import loss_from, progress
    from hsr_pin.diagnosis.change.history import history
    from hsr_pin.effects import effect_named
    from hsr_pin.recordings.read import read_dataset

    effects = None
    if options["effects"] is not None:
        from hsr_pin.diagnosis.change.mounting import MOUNTING

        effects = [name.strip() for name in options["effects"].split(",")]
        for name in effects:  # before the recordings are read, which takes longer
            if name not in MOUNTING:
                effect_named(name)
    sessions = [read_dataset(folder) for folder in folders]
    given = {name: options[name] for name in ("max_effects", "jobs", "cluster", "seed", "delay")} | chain_from(options)
    loss = loss_from(options)
    stages = options["max_effects"] + _STAGES * (len(sessions) - 1)
    with progress(stages) as (report_stage, advance):
        return history(sessions, effects=effects, loss=loss, **given, tell=report_stage, advance=advance)


def _document(found: History) -> str:
    from hsr_pin.diagnosis.change.document import history_to_json

    return json.dumps(history_to_json(found), indent=2, allow_nan=False, ensure_ascii=False)


def _write(found: History, options: dict[str, Any]) -> Iterator[str]:
    """Write the requested files, and yield the name of each file once it is written."""
    if options["json_file"] not in (None, "-"):
        from hsr_pin.output import write_text

        write_text(options["json_file"], _document(found) + "\n")
        yield options["json_file"]
    if options["html_file"] is not None:
        from hsr_pin.diagnosis.change.report import write_report

        write_report(found, options["html_file"])
        yield options["html_file"]
