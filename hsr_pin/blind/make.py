"""Recordings without labels from a plan, written case by case; an interrupted check can be continued."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from hsr_pin.blind.answers import SEAL, Answer, seal
from hsr_pin.blind.cases import Case
from hsr_pin.blind.state import is_intact
from hsr_pin.blind.workshop import DRAWS, Workshop, build
from hsr_pin.errors import InputError, OutputError, SimulationFailure
from hsr_pin.output import check_folder_writable, check_writable, write_text
from hsr_pin.parallel import for_each


def default_answers(folder: Path) -> Path:
    """Return the default file for the answers, next to the folder of the recordings."""
    return folder.with_name(f"{folder.name}-answers.json")


def check_answers(folder: Path, answers: Path | None, force: bool) -> None:
    """Refuse to replace a file of answers, unless ``force`` is set or the file belongs to this interrupted check.

    Raises:
        OutputError: the file exists.
    """
    file = answers or default_answers(folder.resolve())
    if file.exists() and not (force or _drafts(file).exists()):
        hint = "--force replaces it"
        raise OutputError("will not replace the file", expected="a new file for the answers", hint=hint, file=file)


def _drafts(answers: Path) -> Path:
    return answers.with_name(f"{answers.name}.draft")


def make(
    folder: Path,
    seed: int,
    cases: Sequence[Case],
    answers: Path | None = None,
    *,
    jobs: int = 1,
    workshop: Workshop | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Path:
    """Make the recordings of a check from its plan, or continue an interrupted check, and return the file of its answers.

    Until all recordings are made, the answers are drafts in a folder next to that file.

    Raises:
        InputError: the folder contains another check, or the answers would lie in it.
    """
    workshop, folder = workshop or Workshop(), folder.resolve()
    file = (answers or default_answers(folder)).resolve()
    if folder in file.parents:
        raise InputError("answers", expected=f"a file outside {folder.name}", received=file)
    if (folder / SEAL).exists():
        raise InputError("folder", expected="a folder without a finished check", received=folder)
    check_folder_writable(folder)
    check_writable(file)
    drafts = _drafts(file)
    _begin(folder, drafts, cases)
    open_cases = [case for case in cases if not ((folder / case.name).exists() and is_intact(_draft(drafts, case)))]
    for _ in range(len(cases) - len(open_cases)):
        advance()
    for_each(partial(make_case, folder=folder, drafts=drafts, workshop=workshop), open_cases, jobs=jobs, advance=advance)
    seal(folder, file, seed, [Answer.of(json.loads(_draft(drafts, case).read_text(encoding="utf-8"))) for case in cases])
    shutil.rmtree(drafts)
    return file


def _begin(folder: Path, drafts: Path, cases: Sequence[Case]) -> None:
    """Create the folders for recordings and drafts, and store the plan, so that only the same check is continued."""
    note, wanted = drafts / "plan.json", json.dumps([asdict(case) for case in cases], indent=1)
    if note.exists():
        if note.read_text(encoding="utf-8", errors="replace") != wanted:
            hint = "give the seed and the cases with which it was begun, and use the same version of hsr_pin"
            raise InputError("folder", expected="the check begun in it", hint=hint, file=folder)
    elif folder.exists() and any(folder.iterdir()):
        raise InputError("folder", expected="a new or empty folder", received=folder)
    folder.mkdir(parents=True, exist_ok=True)
    drafts.mkdir(parents=True, exist_ok=True)
    write_text(note, wanted)


def make_case(case: Case, folder: Path, drafts: Path, workshop: Workshop) -> None:
    """Record one case: first the draft of its answer is written, then the whole recording is moved into the folder."""
    for attempt in range(DRAWS):
        shutil.rmtree(drafts / case.name, ignore_errors=True)
        try:
            answer = build(case, drafts / case.name, workshop, attempt)
            break
        except SimulationFailure:
            if attempt == DRAWS - 1:
                raise
    write_text(_draft(drafts, case), json.dumps(answer.document(), indent=1, allow_nan=False))
    _move(drafts / case.name, folder / case.name)


def _move(recording: Path, place: Path) -> None:
    """Move a recording into its place in one step, also from another file system."""
    shutil.rmtree(place, ignore_errors=True)  # a recording whose draft answer was lost
    try:
        os.replace(recording, place)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        copy = place.with_name(f".{place.name}.part")
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(recording, copy)
        os.replace(copy, place)
        shutil.rmtree(recording)


def _draft(drafts: Path, case: Case) -> Path:
    return drafts / f"{case.name}.json"
