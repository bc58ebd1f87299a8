"""Check of the folder into which a command writes a dataset, so that no other recordings are overwritten."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import click

from hsr_pin.cli.sim_runs import DESCRIPTION
from hsr_pin.errors import OutputError, RecordingError, one_line
from hsr_pin.output import check_folder_writable
from hsr_pin.recordings.declaration import FILE_NAME, read_declaration
from hsr_pin.recordings.write import check_target, recover

#: Text in the ``dataset.toml`` of every dataset written by a command.
SIGNS = {"hsr-sim": DESCRIPTION, "hsr-import": "# imported from "}


def check_folder(folder: str, command: str, read: Sequence[str | None], force: bool, sources: Sequence[str] = ()) -> None:
    """Check that a dataset may be written to a folder: it is empty or holds an older dataset by the same command.

    Files left there by an interrupted command are removed or restored first, with a warning.

    Args:
        folder: the folder to write.
        command: name of the command, one of :data:`SIGNS`.
        read: files that the command reads.
        force: replace any dataset.
        sources: names of the imported files; a dataset imported from other files is not replaced.

    Raises:
        OutputError: the folder may not be written; the error names what it contains.
    """
    check_folder_writable(folder)
    for sentence in recover(folder):
        click.echo(f"warning: {one_line(sentence)}", err=True)
    check_target(folder)
    if any(name is not None and Path(folder).resolve() in Path(name).resolve().parents for name in read):
        raise OutputError("the output folder contains an input file", hint="write to another folder", file=folder)
    if not force and not _written_by(command, Path(folder)):
        raise OutputError(
            "will not replace the dataset",
            expected=f"a new or empty folder, or a dataset written by {command}",
            received="other recordings",
            hint="--force replaces them",
            file=folder,
        )
    others = _imported_from_others(Path(folder), sources) if sources and not force else []
    if others:
        expected, received = "a dataset imported from the same files", f"recordings of {', '.join(others)}"
        raise OutputError(
            "will not replace the dataset", expected=expected, received=received, hint="--force replaces them", file=folder
        )


def _imported_from_others(folder: Path, sources: Sequence[str]) -> list[str]:
    """Return the files from which a dataset was imported, according to its notes, except for the given sources."""
    if not (folder / FILE_NAME).exists():
        return []
    sign = SIGNS["hsr-import"]
    lines = (folder / FILE_NAME).read_text(encoding="utf-8").splitlines()
    notes = [line.removeprefix(sign) for line in lines if line.startswith(sign)]
    own = tuple(f"{name} {joint}" for name in sources for joint in ("(", "by "))
    return [re.split(r" \(| by ", each)[0] for each in notes if not each.startswith(own)]


def _written_by(command: str, folder: Path) -> bool:
    """Return whether a folder is absent, empty, or contains only a dataset written by a command."""
    there = {path.name for path in folder.iterdir()} if folder.exists() else set()
    if not there:
        return True
    try:
        declared = read_declaration(folder / FILE_NAME)
    except RecordingError:
        return False
    text = (folder / FILE_NAME).read_text(encoding="utf-8")
    return SIGNS[command] in text and there == {FILE_NAME, *(trial.file for trial in declared.trials)}
