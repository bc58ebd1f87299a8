"""Text as laboratories have it, whatever its encoding and line ends, as UTF-8 with lines that end in a line feed."""

from __future__ import annotations

import codecs
from pathlib import Path

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import read_bytes

#: So much of the beginning tells the encoding [bytes].
HEAD = 4096


def read_plain(path: Path) -> tuple[bytes, str]:
    """The text of a file as UTF-8, and what it was encoded in where that was not UTF-8.

    Raises:
        RecordingError: unreadable, too large, empty, or no text.
    """
    data = read_bytes(path)
    text, encoding = plain(data, path)
    if not text.strip():
        raise RecordingError("the file is empty", file=path, line=1, column=1)
    return text, encoding


def plain(data: bytes, path: Path) -> tuple[bytes, str]:
    """The same of bytes that were read already.

    Raises:
        RecordingError: no text.
    """
    encoding = _wide(data[:HEAD])
    try:
        if encoding:
            data = data.decode(encoding).encode()
    except UnicodeDecodeError as error:
        raise RecordingError(
            "not text", expected=encoding.upper(), received=f"a wrong byte at {error.start}", file=path
        ) from error
    data = data.removeprefix(codecs.BOM_UTF8)
    zero = data.find(b"\0")
    if zero >= 0:
        line = data.count(b"\n", 0, zero) + 1
        raise RecordingError(
            "not text", received="a byte of zero", hint="is the file damaged, or binary?", file=path, line=line, column=1
        )
    if not data.isascii():
        try:
            data.decode()
        except UnicodeDecodeError:
            data, encoding = data.decode("cp1252", "replace").encode(), "Windows-1252"
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    return data, encoding.upper() if encoding.startswith("utf") else encoding


def head_text(head: bytes) -> str:
    """The beginning of a file as text, to tell its format by."""
    encoding = _wide(head)
    return head.decode(encoding or "utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _wide(head: bytes) -> str:
    """UTF-16, by its mark or by the zeros in it; else empty."""
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    zeros = [head[side::2].count(0) for side in (0, 1)]
    for side, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) >= 8 and zeros[side] > 0.8 * (len(head) // 2) and zeros[1 - side] == 0:
            return encoding
    return ""
