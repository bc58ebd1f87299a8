"""What a check has written so far, read back: it may have been damaged meanwhile."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hsr_pin.errors import InputError
from hsr_pin.recordings.files import LARGEST_RESULT
from hsr_pin.recordings.text import read_text


def read_state(file: Path, hint: str) -> dict[str, Any]:
    """A JSON object that `hsr-blind` wrote.

    Raises:
        InputError: it is none, with ``hint`` for what to do about it.
    """
    try:
        document = json.loads(read_text(file, LARGEST_RESULT))
    except (ValueError, RecursionError) as error:
        reason = getattr(error, "received", None) or str(error)
        raise InputError("damaged", expected="what hsr-blind wrote", received=reason, hint=hint, file=file) from error
    if not isinstance(document, dict):
        kind = type(document).__name__
        raise InputError("damaged", expected="what hsr-blind wrote", received=f"a {kind}", hint=hint, file=file)
    return document


def stands(file: Path) -> bool:
    """Whether a file is there, and whole."""
    try:
        read_state(file, "")
    except InputError:
        return False
    return True
