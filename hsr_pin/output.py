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
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write ``content`` to ``path``, as :func:`write_text` does.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        target = Path(path)
        if target.exists() and not target.is_file():  # a device or a pipe cannot be replaced; a folder is refused here
            target.write_bytes(content)
            return
        target = target.resolve()  # a link stays, what it points to is replaced; not sooner: a pipe's link resolves to nothing
        draft = _draft(target)
        try:
            draft.write_bytes(content)
            os.replace(draft, target)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise
    except (OSError, ValueError, RuntimeError) as error:  # ValueError: a null byte in the name; RuntimeError: a loop of links
        raise _refusal(path, error) from error


def check_writable(path: str | Path) -> None:
    """Find out now whether :func:`write_bytes` will be able to write to ``path`` later; leaves everything as it was.

    Raises:
        OutputError: it will not.
    """
    try:
        target = Path(path)
        if target.is_dir():
            raise IsADirectoryError(None, "Is a directory")
        if target.exists() and not target.is_file():
            return
        draft = _draft(target.resolve())
        draft.touch()
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        raise _refusal(path, error) from error


def check_folder_writable(path: str | Path) -> None:
    """Find out now whether a folder can be made or filled at ``path`` later; leaves everything as it was.

    Raises:
        OutputError: it cannot, or a file stands there.
    """
    try:
        ancestor = Path(path).resolve()
        while not ancestor.exists():
            ancestor = ancestor.parent
        if not ancestor.is_dir():
            raise NotADirectoryError(None, f"{ancestor.name} is a file")
        draft = _draft(ancestor / "check")
        draft.touch()
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(
            "cannot write the folder", expected="a place where a folder can be made", received=reason, file=path
        ) from error


def _draft(target: Path) -> Path:
    return target.with_name(f".{target.name}.{os.getpid()}.part")


def _refusal(path: str | Path, error: Exception) -> OutputError:
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(
        "cannot write the file", expected="a path in a folder that exists and can be written", received=reason, file=path
    )
