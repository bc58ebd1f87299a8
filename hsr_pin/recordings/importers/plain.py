"""Conversion of text of any encoding and line ending to UTF-8 with line feeds."""

from __future__ import annotations

import codecs
from pathlib import Path

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import read_bytes

#: Size of the beginning from which the encoding is determined [bytes].
HEAD = 4096


def read_plain(path: Path) -> tuple[bytes, str]:
    """Return the text of a file as UTF-8, and its encoding if that was not UTF-8.

    Raises:
        RecordingError: the file cannot be read, is too large or empty, or is not text.
    """
    data = read_bytes(path)
    text, encoding = plain(data, path)
    if not text.strip():
        raise RecordingError("the file is empty", file=path, line=1, column=1)
    return text, encoding


def plain(data: bytes, path: Path) -> tuple[bytes, str]:
    """Return bytes as UTF-8 text, and their encoding if that was not UTF-8.

    Raises:
        RecordingError: the bytes are not text.
    """
    encoding = _wide(data[:HEAD])
    try:
        if encoding:
            data = data.decode(encoding).encode()
    except UnicodeDecodeError as error:
        raise RecordingError(
            "not text", expected=encoding.upper(), received=f"an invalid byte at {error.start}", file=path
        ) from error
    data = data.removeprefix(codecs.BOM_UTF8)
    zero = data.find(b"\0")
    if zero >= 0:
        line = data.count(b"\n", 0, zero) + 1
        raise RecordingError(
            "not text", received="a null byte", hint="the file may be damaged or binary", file=path, line=line, column=1
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
    """Return the beginning of a file as text, from which its format is determined."""
    encoding = _wide(head)
    return head.decode(encoding or "utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _wide(head: bytes) -> str:
    """Return the name of the UTF-16 encoding if a byte order mark or null bytes show it; otherwise an empty text."""
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    zeros = [head[side::2].count(0) for side in (0, 1)]
    for side, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) >= 8 and zeros[side] > 0.8 * (len(head) // 2) and zeros[1 - side] == 0:
            return encoding
    return ""
