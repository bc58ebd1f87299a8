"""Atomic file writing, which never replaces a file of another program unless it is told to."""

from __future__ import annotations

import contextlib
import glob
import os
import re
import secrets
import stat
from collections.abc import Iterable
from pathlib import Path

from hsr_pin.errors import OutputError

#: Name of the program in the metadata of the files that it writes; in an HTML page it is :data:`PAGE_SIGNATURE`.
GENERATOR = "hsr_pin"
PAGE_SIGNATURE = f'<meta name="generator" content="{GENERATOR}">'
#: Patterns in the first or last bytes by which files of hsr_pin are recognised: pages, pictures (png, pdf, svg), URDF, JSON.
_SIGNATURES = tuple(
    re.compile(pattern, re.DOTALL)
    for pattern in (
        PAGE_SIGNATURE.encode(),
        rb"\A\x89PNG\r\n.*Software\0hsr_pin",
        rb"/Creator \(hsr_pin\)",
        rb"<dc:title>hsr_pin</dc:title>",
        rb'<hsr version="',
        rb'\A(<\?xml|""").{1,400}?[Ww]ritten by hsr-export of hsr_pin',
        rb'\A\{\s*"schema": \d+,\s*"dataset": "',
        rb'\A\{\s*"cases": \d+,\s*"missing": \[',
    )
)
#: Suffix of the temporary files that are written before they replace the target.
DRAFT = "part"
#: Number of bytes at either end of a file that are searched for a signature.
_SEARCHED = 8192


def write_text(path: str | Path, text: str) -> None:
    """Write ``text`` (UTF-8) to ``path`` in one step.

    An existing file is replaced and keeps its mode; if the writing fails, it stays unchanged.

    Raises:
        OutputError: the file cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write ``content`` to ``path`` in one step, in the same way as :func:`write_text`.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        target = Path(path)
        if target.exists() and not target.is_file():  # a device or a pipe cannot be replaced; a folder raises an error here
            target.write_bytes(content)
            return
        target = target.resolve()  # a link stays; not before the check above, because a pipe's link cannot be resolved
        draft = draft_of(target)
        try:
            with draft.open("xb") as file:  # an existing file or link of this name raises an error
                if target.exists():
                    draft.chmod(stat.S_IMODE(target.stat().st_mode))  # before private content is written
                file.write(content)
            os.replace(draft, target)
        except BaseException:
            draft.unlink(missing_ok=True)
            raise
        for path in left_by_killed(target, DRAFT):
            with contextlib.suppress(OSError):
                path.unlink()
    except (OSError, ValueError, RuntimeError) as error:  # ValueError: a null byte in the name; RuntimeError: a loop of links
        raise _refusal(path, error) from error


def check_writable(path: str | Path) -> None:
    """Check that :func:`write_bytes` will be able to write to ``path``, without changing anything.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        target = Path(path)
        if target.is_dir():
            raise IsADirectoryError(None, "Is a directory")
        if target.exists() and not target.is_file():
            return
        draft = draft_of(target.resolve())
        draft.touch(exist_ok=False)
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        raise _refusal(path, error) from error


def check_replaceable(path: str | Path, *, read: Iterable[str | Path] = (), force: bool = False) -> None:
    """Check that writing a file replaces neither an input file nor a file of another program.

    Args:
        path: path of the file that will be written.
        read: input files, and folders that contain them; these are never replaced.
        force: whether a file that another program wrote may be replaced.

    Raises:
        OutputError: the file must not be replaced; the message gives the reason.
    """
    try:
        target = Path(path).resolve()
        if not target.is_file():
            return
        ours = is_ours(target)
        for source in (Path(name).resolve() for name in read):
            if target == source or (source in target.parents and not ours):
                raise OutputError("will not write over what is read", hint="write to another file", file=path)
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, OutputError):
            raise
        raise _refusal(path, error) from error
    if not ours and not force:
        raise OutputError(
            "will not replace the file",
            expected="a new file, or one that hsr_pin wrote",
            received="another program's",
            hint="--force replaces it",
            file=path,
        )


def is_ours(path: Path) -> bool:
    """Return whether a file is empty or was written by hsr_pin."""
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(0)
        seen = file.read(_SEARCHED)
        if size > _SEARCHED:
            file.seek(-_SEARCHED, os.SEEK_END)
            seen += file.read(_SEARCHED)
    return not size or any(signature.search(seen) for signature in _SIGNATURES)


def check_folder_writable(path: str | Path) -> None:
    """Check that a folder can be created or filled at ``path``, without changing anything.

    Raises:
        OutputError: the folder cannot be created, or a file exists at the path.
    """
    try:
        ancestor = Path(path).resolve()
        while not ancestor.exists():
            ancestor = ancestor.parent
        if not ancestor.is_dir():
            raise NotADirectoryError(None, f"{ancestor.name} is a file")
        draft = draft_of(ancestor / "check")
        draft.touch(exist_ok=False)
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(
            "cannot write the folder", expected="a place where a folder can be made", received=reason, file=path
        ) from error


def draft_of(target: Path) -> Path:
    """Return the path of the temporary file or folder that is moved to ``target`` later: a random name in the same folder."""
    return target.with_name(f".{target.name}.{os.getpid()}.{secrets.token_hex(4)}.{DRAFT}")


def left_by_killed(target: Path, suffix: str) -> list[Path]:
    """Return the temporary files or folders of ``target`` with a suffix that killed processes left behind."""
    form = re.compile(rf"\.{re.escape(target.name)}\.(\d+)(\.[0-9a-f]+)?\.{suffix}")
    there = ((path, form.fullmatch(path.name)) for path in target.parent.glob(f".{glob.escape(target.name)}.*.{suffix}"))
    return [path for path, owner in there if owner and not _runs(int(owner[1]))]


def _runs(process: int) -> bool:
    """Return whether a process with this id is running (always true on Windows)."""
    if os.name == "nt":  # there, os.kill with the signal 0 would end the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # the process belongs to another user
        return True
    return True


def _refusal(path: str | Path, error: Exception) -> OutputError:
    """Return the error of a file that cannot be written, with the reason from the operating system."""
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(
        "cannot write the file", expected="a path in a folder that exists and can be written", received=reason, file=path
    )
