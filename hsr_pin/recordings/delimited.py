"""Parsing of the numbers in delimited text with NumPy's C reader, which is fast and exact and needs little extra memory."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from hsr_pin.trajectory import Array

#: Size of the pieces in which text is parsed [bytes].
CHUNK = 1 << 24
#: Words that mark a missing number, in addition to an empty field and ``nan``, in lower case.
GAPS = (b"null", b"none")


def number(text: str) -> float:
    """Return the number in a field; NaN for an empty field or ``nan``.

    Raises:
        ValueError: the field holds anything else, including infinity.
    """
    text = text.strip()
    if text == "" or text.lower() == "nan":
        return math.nan
    value = float(text)
    if not math.isfinite(value) or "_" in text or not text.isascii():
        raise ValueError(text)
    return value


def numbers(
    body: memoryview,
    width: int,
    *,
    separator: str = ",",
    decimal: str = ".",
    columns: list[int] | None = None,
    strict: bool = True,
) -> Array:
    """Return the numbers (rows, columns) of the lines that are not blank; NaN where a field is empty or ``nan``.

    Args:
        body: lines of text in an encoding that contains ASCII.
        width: number of fields in a row.
        separator: character between fields.
        decimal: decimal mark of the numbers.
        columns: indices of the columns to return, in this order; None: all.
        strict: require ``width`` fields in every row; otherwise missing fields at the end of a row are empty.

    Raises:
        ValueError: a row is not of this form. Reading row by row finds which one.
    """
    form = separator.encode(), decimal.encode(), columns, strict
    values = np.empty((_lines(body), width if columns is None else len(columns)))  # at least as many as there are rows
    rows = 0
    for chunk in _chunks(body):
        part = _part(chunk, width, *form)
        if len(part):
            values[rows : rows + len(part)] = part
            rows += len(part)
    return values[:rows]


def _lines(body: memoryview) -> int:
    return sum(bytes(body[at : at + CHUNK]).count(b"\n") for at in range(0, len(body), CHUNK)) + 1


def _chunks(body: memoryview) -> Iterator[bytes]:
    """Yield pieces of text that end at the end of a line."""
    start = 0
    while start < len(body):
        piece = bytes(body[start : start + CHUNK])
        end = piece.rfind(b"\n") + 1 if start + CHUNK < len(body) else len(piece)
        if end == 0:
            raise ValueError("a line is longer than the read buffer")
        yield piece[:end]
        start += end


def _part(text: bytes, width: int, separator: bytes, decimal: bytes, columns: list[int] | None, strict: bool) -> Array:
    if b"\r" in text:
        text = text.replace(b"\r", b"")
    if decimal != b".":
        text = text.replace(decimal, b".")
    if b"_" in text or b"\0" in text:
        raise ValueError("numbers do not contain underscores or null bytes")
    for repair in (_as_it_is, _lengthened, _stripped):
        if repair is _lengthened and strict:
            continue
        try:
            return _loaded(_filled(repair(text, width, separator), separator), width, separator, columns, strict)
        except ValueError as error:
            failure = error
    raise failure


def _as_it_is(text: bytes, width: int, separator: bytes) -> bytes:
    return text


def _lengthened(text: bytes, width: int, separator: bytes) -> bytes:
    """Return the text with every row padded to at least ``width`` fields."""
    rows = text.split(b"\n")
    return b"\n".join(row + separator * (width - 1 - row.count(separator)) for row in rows if row.strip())


def _stripped(text: bytes, width: int, separator: bytes) -> bytes:
    """Return the text without spaces and quotes around fields, with ``nan`` for the words that mark a gap (ten times slower)."""
    rows = [row for row in text.split(b"\n") if row.strip()]
    return b"\n".join(separator.join(_gap_to_nan(field) for field in row.split(separator)) for row in rows)


def _gap_to_nan(field: bytes) -> bytes:
    bare = field.strip(b' "')
    return b"nan" if not bare or bare.lower() in GAPS else bare


def _filled(text: bytes, separator: bytes) -> bytes:
    """Return the text with ``nan`` in every empty field."""
    gap = separator + b"nan" + separator
    for empty, filled in (
        (separator * 2, gap),
        (separator * 2, gap),
        (separator + b"\n", separator + b"nan\n"),
        (b"\n" + separator, b"\nnan" + separator),
    ):
        if empty in text:
            text = text.replace(empty, filled)
    return (b"nan" if text.startswith(separator) else b"") + text + (b"nan" if text.endswith(separator) else b"")


def _loaded(text: bytes, width: int, separator: bytes, columns: list[int] | None, strict: bool) -> Array:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # raised for a piece without rows
        form: dict[str, Any] = {"delimiter": separator.decode(), "comments": None, "quotechar": '"', "encoding": "latin-1"}
        values = np.loadtxt(io.BytesIO(text), usecols=columns, ndmin=2, **form)
    if values.size and strict and columns is None and values.shape[1] != width:
        raise ValueError("a row has the wrong number of fields")
    if np.isinf(values).any():
        raise ValueError("infinity")
    return np.asarray(values)
