"""Command ``hsr-diagnose --since``: find the changes of an arm between recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hsr_pin.cli.arm import chain_from
from hsr_pin.cli.judging import effects_from, loss_from, print_and_write, progress
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
    from hsr_pin.cli.console import print_lines
    from hsr_pin.diagnosis.change.document import history_to_json
    from hsr_pin.diagnosis.change.report import write_report

    print_and_write(
        options,
        lambda: history_to_json(found),
        lambda: print_lines(lambda width: screen(found, width)),
        lambda path: write_report(found, path),
    )


def _history(folders: list[str], options: dict[str, Any]) -> History:
    from hsr_pin.diagnosis.change.history import history
    from hsr_pin.diagnosis.change.mounting import MOUNTING
    from hsr_pin.recordings.read import read_dataset

    effects = effects_from(options, MOUNTING)
    sessions = [read_dataset(folder) for folder in folders]
    given = {name: options[name] for name in ("max_effects", "jobs", "cluster", "seed", "delay")} | chain_from(options)
    loss = loss_from(options)
    stages = options["max_effects"] + _STAGES * (len(sessions) - 1)
    with progress(stages) as (report_stage, advance):
        return history(sessions, effects=effects, loss=loss, **given, tell=report_stage, advance=advance)
