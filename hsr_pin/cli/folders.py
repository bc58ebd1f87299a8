"""Where a command may write a dataset: never over recordings that it did not write itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import click

from hsr_pin.cli.sim_runs import DESCRIPTION
from hsr_pin.errors import OutputError, RecordingError, one_line
from hsr_pin.output import check_folder_writable
from hsr_pin.recordings.declaration import FILE_NAME, read_declaration
from hsr_pin.recordings.write import check_target, mend

#: What a dataset of each command has in its ``dataset.toml``.
SIGNS = {"hsr-sim": DESCRIPTION, "hsr-import": "# imported from "}


def check_folder(folder: str, command: str, read: Sequence[str | None], force: bool, sources: Sequence[str] = ()) -> None:
    """Refuse a folder for a dataset that holds anything but an older one by the same command, or what is read.

    What a killed command left there is mended first, and told.

    Args:
        folder: to be written.
        command: one of :data:`SIGNS`.
        read: files that the command reads.
        force: replace any dataset.
        sources: names of the files that are imported; what was imported from others is not replaced.

    Raises:
        OutputError: saying what is there.
    """
    check_folder_writable(folder)
    for sentence in mend(folder):
        click.echo(f"warning: {one_line(sentence)}", err=True)
    check_target(folder)
    if any(name is not None and Path(folder).resolve() in Path(name).resolve().parents for name in read):
        raise OutputError("will not write over what is read", hint="write to another folder", file=folder)
    if not force and not _written_by(command, Path(folder)):
        raise OutputError(
            "will not replace the dataset",
            expected=f"a new or empty folder, or what {command} wrote",
            received="other recordings",
            hint="--force replaces them",
            file=folder,
        )
    others = _imported_from_others(Path(folder), sources) if sources and not force else []
    if others:
        expected, received = "what was imported from the same files", f"recordings of {', '.join(others)}"
        raise OutputError(
            "will not replace the dataset", expected=expected, received=received, hint="--force replaces them", file=folder
        )


def _imported_from_others(folder: Path, sources: Sequence[str]) -> list[str]:
    """The files, other than some, that the recordings in a folder were imported from, as the notes there have it."""
    if not (folder / FILE_NAME).exists():
        return []
    sign = SIGNS["hsr-import"]
    lines = (folder / FILE_NAME).read_text(encoding="utf-8").splitlines()
    said = [line.removeprefix(sign) for line in lines if line.startswith(sign)]
    own = tuple(f"{name} {joint}" for name in sources for joint in ("(", "by "))
    return [re.split(r" \(| by ", each)[0] for each in said if not each.startswith(own)]


def _written_by(command: str, folder: Path) -> bool:
    """Whether a folder is absent, empty, or holds what a command wrote and nothing else."""
    there = {path.name for path in folder.iterdir()} if folder.exists() else set()
    if not there:
        return True
    try:
        declared = read_declaration(folder / FILE_NAME)
    except RecordingError:
        return False
    text = (folder / FILE_NAME).read_text(encoding="utf-8")
    return SIGNS[command] in text and there == {FILE_NAME, *(trial.file for trial in declared.trials)}
