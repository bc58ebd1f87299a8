"""Reader for intermediate files of a check, which may be damaged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hsr_pin.errors import InputError
from hsr_pin.recordings.files import LARGEST_RESULT
from hsr_pin.recordings.text import read_text


def read_state(file: Path, hint: str) -> dict[str, Any]:
    """Return a JSON object that `hsr-blind` wrote.

    Raises:
        InputError: the file contains no JSON object; the message ends with ``hint``.
    """
    try:
        document = json.loads(read_text(file, LARGEST_RESULT))
    except (ValueError, RecursionError) as error:
        reason = getattr(error, "received", None) or str(error)
        raise InputError("damaged", expected="a document of hsr-blind", received=reason, hint=hint, file=file) from error
    if not isinstance(document, dict):
        kind = type(document).__name__
        raise InputError("damaged", expected="a document of hsr-blind", received=f"a {kind}", hint=hint, file=file)
    return document


def is_intact(file: Path) -> bool:
    """Return whether a file exists and contains a whole JSON object."""
    try:
        read_state(file, "")
    except InputError:
        return False
    return True
