"""Diagnosis of every recording of a check, from its folder alone."""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from hsr_pin.blind.pairs import CURRENT, REFERENCE
from hsr_pin.blind.state import is_intact, read_state
from hsr_pin.errors import InputError
from hsr_pin.output import check_folder_writable, write_text
from hsr_pin.parallel import for_each


def recordings(folder: Path) -> list[Path]:
    """Return the sorted folders of a check's cases; for a pair, the folder that contains both recordings.

    Raises:
        InputError: the folder contains no recordings.
    """
    single = {path.parent for path in folder.glob("case_*/dataset.toml")}
    found = sorted(single | {path.parents[1] for path in folder.glob(f"case_*/{CURRENT}/dataset.toml")})
    if not found:
        raise InputError("folder", expected="recordings written by hsr-blind make", received="none", file=folder)
    return found


def diagnose_all(
    folder: Path,
    verdicts: Path,
    *,
    jobs: int = 1,
    cluster: str | None = None,
    seed: int = 0,
    advance: Callable[[], None] = lambda: None,
) -> None:
    """Write a verdict for each case without one; cases that failed before, or whose verdict is damaged, are diagnosed again."""
    check_folder_writable(verdicts)
    verdicts.mkdir(parents=True, exist_ok=True)
    work = partial(diagnose_case, verdicts=verdicts.resolve(), seed=seed)
    for_each(work, recordings(folder.resolve()), jobs=jobs, cluster=cluster, advance=advance)


def diagnose_case(recording: Path, verdicts: Path, seed: int) -> None:
    """Write the document of ``hsr-diagnose``, or the error that occurred, unless another run has written a verdict."""
    file = verdicts / f"{recording.name}.json"
    if _is_done(file):
        return
    document: dict[str, Any]
    try:
        document = _of_pair(recording, seed) if (recording / CURRENT).exists() else _of_one(recording, seed)
    except Exception as error:  # any error is recorded, because one case must not end a check of hundreds
        trace = traceback.format_exc()
        document = {"dataset": recording.name, "error": f"{type(error).__name__}: {error}", "traceback": trace}
    write_text(file, json.dumps(document, indent=1, allow_nan=False) + "\n")


def _of_one(recording: Path, seed: int) -> dict[str, Any]:
    from hsr_pin.diagnosis.diagnose import diagnose
    from hsr_pin.diagnosis.document import to_json
    from hsr_pin.recordings.read import read_dataset

    return to_json(diagnose(read_dataset(recording), jobs=1, seed=seed))


def _of_pair(recording: Path, seed: int) -> dict[str, Any]:
    from hsr_pin.diagnosis.change.diagnose import diagnose_change
    from hsr_pin.diagnosis.change.document import to_json
    from hsr_pin.recordings.read import read_dataset

    return to_json(diagnose_change(read_dataset(recording / CURRENT), read_dataset(recording / REFERENCE), jobs=1, seed=seed))


def read_verdicts(verdicts: Path) -> dict[str, dict[str, Any]]:
    """Return the document that was written for each case, by the name of the case.

    Raises:
        InputError: a file is damaged.
    """
    hint = "hsr-blind run diagnoses this case again"
    return {path.stem: read_state(path, hint) for path in sorted(verdicts.glob("case_*.json"))}


def failed(verdicts: Path) -> dict[str, str]:
    """Return the error of each case without a verdict, by the name of the case."""
    return {name: str(reported["error"]) for name, reported in read_verdicts(verdicts).items() if "error" in reported}


def _is_done(file: Path) -> bool:
    return is_intact(file) and "error" not in read_state(file, "")
