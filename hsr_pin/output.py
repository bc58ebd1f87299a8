"""Writing a file whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from hsr_pin.errors import OutputError


def write_text(path: str | Path, text: str) -> None:
    """Write ``text`` (UTF-8) to ``path``; a file that was there is replaced in one step, or left as it was.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        target = Path(path).resolve()
        if target.exists() and not target.is_file():  # a device or a pipe cannot be replaced; a folder is refused here
            target.write_text(text, encoding="utf-8")
            return
        draft = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            draft.write_text(text, encoding="utf-8")
            os.replace(draft, target)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise
    except (OSError, ValueError, RuntimeError) as error:  # ValueError: a null byte in the name; RuntimeError: a loop of links
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(
            "cannot write the file", expected="a path in a folder that exists and can be written", received=reason, file=path
        ) from error
