"""Where ``hsr-sim --csv`` may write: never over recordings."""

from __future__ import annotations

from pathlib import Path

from hsr_pin.cli.sim_runs import DESCRIPTION
from hsr_pin.errors import OutputError, RecordingError
from hsr_pin.output import check_folder_writable
from hsr_pin.recordings.declaration import FILE_NAME, read_declaration
from hsr_pin.recordings.write import check_target


def check_folder(folder: str, input_file: str | None, force: bool) -> None:
    """Refuse a folder for a dataset that holds anything but an older simulation, or the input.

    Raises:
        OutputError: saying what is there.
    """
    check_folder_writable(folder)
    check_target(folder)
    if input_file is not None and Path(folder).resolve() in Path(input_file).resolve().parents:
        raise OutputError("will not write over what is read", hint="write to another folder", file=folder)
    if not force and not _simulated_before(Path(folder)):
        raise OutputError(
            "will not replace the dataset",
            expected="a new or empty folder, or what hsr-sim wrote",
            received="other recordings",
            hint="--force replaces them",
            file=folder,
        )


def _simulated_before(folder: Path) -> bool:
    """Whether a folder is absent, empty, or holds what ``hsr-sim`` wrote and nothing else."""
    there = {path.name for path in folder.iterdir()} if folder.exists() else set()
    if not there:
        return True
    try:
        declared = read_declaration(folder / FILE_NAME)
    except RecordingError:
        return False
    return declared.description.startswith(DESCRIPTION) and there == {FILE_NAME, *(trial.file for trial in declared.trials)}
