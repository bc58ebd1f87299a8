"""Text files and numeric CSV tables, with the line and column of every fault."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.delimited import CHUNK, number, numbers
from hsr_pin.recordings.files import LARGEST, read_bytes
from hsr_pin.trajectory import Array

_MARK = b"\xef\xbb\xbf"


def read_text(path: Path, largest: int = LARGEST) -> str:
    """Return the text of a UTF-8 file without its byte order mark.

    Raises:
        RecordingError: the file does not exist, is not a regular file, is too large or empty, or is not UTF-8 (with line and
            column of the first wrong byte).
    """
    return _decoded(read_bytes(path, largest), path)


def _decoded(data: bytes, path: Path) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].split(b"\n")
        raise RecordingError(
            "not UTF-8 text",
            received=f"byte 0x{data[error.start]:02x}",
            hint="save the file as UTF-8",
            file=path,
            line=len(before),
            column=len(before[-1].decode("utf-8", "replace")) + 1,
        ) from error
    if not text.strip():
        raise RecordingError("the file is empty", file=path, line=1, column=1)
    return text


def nearest(name: str, known: Iterable[str], what: str) -> str:
    """Return a hint with the known name most similar to ``name``, or with all known names."""
    names = list(known)
    close = difflib.get_close_matches(name.lower(), [candidate.lower() for candidate in names], n=1, cutoff=0.5)
    if close:
        return f"did you mean {next(candidate for candidate in names if candidate.lower() == close[0])!r}?"
    return f"known {what}: {', '.join(names)}" if names else f"there are no {what}"


def field_column(line: str, field: int, separator: str = ",") -> int:
    """Return the text column, counted from 1, at which a field (counted from 0) starts in its line."""
    quoted = False
    line = line.rstrip("\r\n")
    for place, character in enumerate(line):
        if field == 0:
            return place + 1
        if character == '"':
            quoted = not quoted
        elif character == separator and not quoted:
            field -= 1
    return len(line) + 1


def split_fields(line: str, separator: str = ",") -> list[str]:
    """Return the fields of one line of delimited text, stripped.

    Raises:
        csv.Error: the line is not valid delimited text.
    """
    return [field.strip() for row in csv.reader([line.rstrip("\r\n")], delimiter=separator) for field in row]


@dataclass(frozen=True, eq=False)
class Table:
    """A CSV table with one header line.

    Attributes:
        path: the file.
        text: content of the file.
        header: (C,) names of the columns.
        header_line: line of the header, counted from 1.
        values: (T, C) numbers; NaN where a field is empty or ``nan``.
    """

    path: Path
    text: bytes
    header: tuple[str, ...]
    header_line: int
    values: Array

    @cached_property
    def place(self) -> dict[str, int]:
        """Index of each column, counted from 0, by name."""
        return {name: field for field, name in enumerate(self.header)}

    def column(self, name: str) -> Array:
        """Return the values (T,) of a column that is in the header."""
        return np.asarray(self.values[:, self.place[name]])

    def fault(
        self, subject: str, row: int | None, field: int, *, expected: str = "", received: object = None, hint: str = ""
    ) -> RecordingError:
        """Return an error at a field of a row (None: of the header)."""
        line, content = next(iter(_rows(self.text, 0 if row is None else row + 1)), (self.header_line, ""))
        column = field_column(content, field)
        facts: dict[str, Any] = {"expected": expected, "received": received, "hint": hint}
        return RecordingError(subject, **facts, file=self.path, line=line, column=column)


def _rows(text: bytes, first: int = 0) -> Iterable[tuple[int, str]]:
    """Yield line number and text of each non-blank line after the first ``first``; lines beyond :data:`CHUNK` bytes are cut."""
    at, line, found = 0, 0, 0
    while at < len(text):
        end = text.find(b"\n", at)
        end = len(text) if end < 0 else end
        line += 1
        content = text[at : min(end, at + CHUNK)]  # no valid row is longer, and its beginning shows the fault
        at = end + 1
        if content.strip(b' ,"\r\t\xef\xbb\xbf'):
            if found >= first:
                yield line, content.removeprefix(_MARK if line == 1 else b"").decode("utf-8", "replace")
            found += 1


def read_table(path: Path) -> Table:
    """Read a CSV file of numbers under one header line.

    Raises:
        RecordingError: the file cannot be read or has no rows, a column is named twice, a row has the wrong number of fields, or
            a field is not a number.
    """
    text = read_bytes(path)
    if not text.isascii() or not text or text.isspace():
        _decoded(text, path)
    if b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    top, first = next(iter(_rows(text)), (1, ""))
    try:
        header = tuple(split_fields(first))
    except csv.Error as error:
        raise RecordingError("not a CSV table", received=error, file=path, line=top, column=1) from error
    table = Table(path, text, header, top, np.empty((0, len(header))))
    _check_header(table, first)
    values = _values(table)
    if not len(values):
        raise RecordingError("no rows under the header", file=path, line=top + 1, column=1)
    return Table(path, text, header, top, values)


def _check_header(table: Table, first: str) -> None:
    taken: set[str] = set()
    for field, name in enumerate(table.header):
        if name in taken:
            raise table.fault(f"column {name!r} occurs twice in the header", None, field)
        taken.add(name)
    if len(table.header) == 1 and any(mark in first for mark in ";|\t"):
        hint = "separate the columns by commas, and use decimal points"
        raise table.fault("header", None, 0, expected="columns separated by commas", received=first[:40], hint=hint)


def _values(table: Table) -> Array:
    start = 0
    for _ in range(table.header_line):
        start = table.text.find(b"\n", start) + 1 or len(table.text)
    try:
        values = numbers(memoryview(table.text)[start:], len(table.header))
    except ValueError:
        values = _row_by_row(table)
    blank = np.isnan(values).all(axis=1)
    return values[~blank] if blank.any() else values


def _row_by_row(table: Table) -> Array:
    """Return the numbers of a table parsed row by row, and raise an error at the first fault."""
    found = []
    for index, (_, content) in enumerate(_rows(table.text, 1)):
        try:
            row = split_fields(content)
        except csv.Error as error:
            raise table.fault("not a CSV table", index, 0, received=error) from error
        if len(row) != len(table.header):
            at, hint = min(len(row), len(table.header)), ""
            if len(row) > len(table.header):
                hint = "use decimal points, not commas"
            raise table.fault("row", index, at, expected=f"{len(table.header)} fields", received=len(row), hint=hint)
        values = []
        for field, part in enumerate(row):
            try:
                values.append(number(part))
            except ValueError:
                subject, received = f"column {table.header[field]}", repr(part[:40])
                raise table.fault(subject, index, field, expected="a finite number", received=received) from None
        found.append(values)
    return np.array(found).reshape(len(found), len(table.header))
