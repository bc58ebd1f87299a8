"""Writing a file whole or not at all, and not over what is someone else's."""

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

#: Who made a file, in the formats that have a place for it; in a page it stands as :data:`PAGE_SIGNATURE`.
GENERATOR = "hsr_pin"
PAGE_SIGNATURE = f'<meta name="generator" content="{GENERATOR}">'
#: By what the files of hsr_pin are known, in their first or last bytes: pages, pictures (png, pdf, svg), URDF, JSON.
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
#: Ending of the names of drafts.
DRAFT = "part"
#: Bytes of a file that are looked at, at either end.
_LOOK = 8192


def write_text(path: str | Path, text: str) -> None:
    """Write ``text`` (UTF-8) to ``path``; a file that was there is replaced in one step and keeps its mode, or is left as it was.

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
        draft = draft_of(target)
        try:
            with draft.open("xb") as file:  # what stands there already is not followed, and not written to
                if target.exists():
                    draft.chmod(stat.S_IMODE(target.stat().st_mode))  # before anything is in it that others may not read
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
        draft = draft_of(target.resolve())
        draft.touch(exist_ok=False)
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        raise _refusal(path, error) from error


def check_replaceable(path: str | Path, *, read: Iterable[str | Path] = (), force: bool = False) -> None:
    """Refuse to write over what is read, and over what another program wrote.

    Args:
        path: of the file that will be written.
        read: files, and folders of them: nothing that is read is ever written over.
        force: what another program wrote may be replaced.

    Raises:
        OutputError: saying which of the two it is.
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
    """Whether a file is empty, or one that hsr_pin wrote."""
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(0)
        seen = file.read(_LOOK)
        if size > _LOOK:
            file.seek(-_LOOK, os.SEEK_END)
            seen += file.read(_LOOK)
    return not size or any(signature.search(seen) for signature in _SIGNATURES)


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
        draft = draft_of(ancestor / "check")
        draft.touch(exist_ok=False)
        draft.unlink()
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(
            "cannot write the folder", expected="a place where a folder can be made", received=reason, file=path
        ) from error


def draft_of(target: Path) -> Path:
    """Where a file or a folder is written before it is moved to its place: beside it, under a name that nobody can foresee."""
    return target.with_name(f".{target.name}.{os.getpid()}.{secrets.token_hex(4)}.{DRAFT}")


def left_by_killed(target: Path, ending: str) -> list[Path]:
    """Drafts of a file or a folder, or what took their name with another ending, of processes that were killed over it."""
    form = re.compile(rf"\.{re.escape(target.name)}\.(\d+)(\.[0-9a-f]+)?\.{ending}")
    there = ((path, form.fullmatch(path.name)) for path in target.parent.glob(f".{glob.escape(target.name)}.*.{ending}"))
    return [path for path, owner in there if owner and not _runs(int(owner[1]))]


def _runs(process: int) -> bool:
    if os.name == "nt":  # where a signal of zero would end it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # another user's
        return True
    return True


def _refusal(path: str | Path, error: Exception) -> OutputError:
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(
        "cannot write the file", expected="a path in a folder that exists and can be written", received=reason, file=path
    )
