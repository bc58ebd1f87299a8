"""Text files and the tables of numbers in them, with the place of every fault."""

from __future__ import annotations

import csv
import difflib
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.trajectory import Array


def read_text(path: Path) -> str:
    """The text of a UTF-8 file (a byte order mark is taken off).

    Raises:
        RecordingError: no such file, not a file, not UTF-8 (with line and column of the first wrong byte), or empty.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise RecordingError("cannot read the file", received=getattr(error, "strerror", None) or error, file=path) from error
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
    """A hint: the known name that looks most like ``name``, or all of them."""
    names = list(known)
    close = difflib.get_close_matches(name.lower(), [candidate.lower() for candidate in names], n=1, cutoff=0.5)
    if close:
        return f"did you mean {next(candidate for candidate in names if candidate.lower() == close[0])!r}?"
    return f"known {what}: {', '.join(names)}" if names else f"there are no {what}"


def number(text: str) -> float:
    """The number in a field; NaN for an empty field or ``nan``.

    Raises:
        ValueError: anything else, infinity among it.
    """
    text = text.strip()
    if text == "" or text.lower() == "nan":
        return math.nan
    value = float(text)
    if not math.isfinite(value) or "_" in text:
        raise ValueError(text)
    return value


def field_column(line: str, field: int) -> int:
    """The column, counted from 1, at which a comma-separated field (counted from 0) starts in its line."""
    quoted = False
    line = line.rstrip("\r\n")
    for place, character in enumerate(line):
        if field == 0:
            return place + 1
        if character == '"':
            quoted = not quoted
        elif character == "," and not quoted:
            field -= 1
    return len(line) + 1


def csv_lines(text: str) -> list[str]:
    """The lines of a CSV text, as the csv module counts them."""
    return list(io.StringIO(text, newline=""))


def csv_rows(text: str, path: Path) -> list[tuple[int, list[str]]]:
    """The rows of a CSV text that are not blank, each with its line.

    Raises:
        RecordingError: the text is not CSV.
    """
    reader = csv.reader(csv_lines(text))
    rows = []
    try:
        for row in reader:
            if any(field.strip() for field in row):
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise RecordingError("not a CSV table", received=error, file=path, line=reader.line_num, column=1) from error
    return rows


@dataclass(frozen=True, eq=False)
class Table:
    """A CSV table with one header line.

    Attributes:
        path: its file.
        source: (lines,) the text of each line, to find places in.
        header: (C,) names of the columns.
        header_line: the line they stand in, counted from 1.
        lines: (T,) line of each row in the file, counted from 1.
        values: (T, C) its numbers; NaN where a field is empty or ``nan``.
    """

    path: Path
    source: Sequence[str]
    header: tuple[str, ...]
    header_line: int
    lines: tuple[int, ...]
    values: Array

    def column(self, name: str) -> Array:
        """(T,) the values under a name that is in the header."""
        return np.asarray(self.values[:, self.header.index(name)])

    def fault(
        self, subject: str, row: int | None, field: int, *, expected: str = "", received: object = None, hint: str = ""
    ) -> RecordingError:
        """An error at a field of a row (None: of the header)."""
        line = self.header_line if row is None else self.lines[row]
        return fault_in(self.path, self.source, line, field, subject, expected=expected, received=received, hint=hint)


def fault_in(
    path: Path,
    source: Sequence[str],
    line: int,
    field: int,
    subject: str,
    *,
    expected: str = "",
    received: object = None,
    hint: str = "",
) -> RecordingError:
    """An error at a field (counted from 0) of a line (counted from 1) of a CSV text."""
    column = field_column(source[line - 1], field) if line <= len(source) else 1
    return RecordingError(subject, expected=expected, received=received, hint=hint, file=path, line=line, column=column)


def read_table(path: Path) -> Table:
    """Read a CSV file of numbers under one header line.

    Raises:
        RecordingError: unreadable, no rows, a column named twice, a row of another length, or a field that is no number.
    """
    text = read_text(path)
    source = csv_lines(text)
    (top, first), *body = csv_rows(text, path) or [(1, [""])]
    header = tuple(name.strip() for name in first)
    for field, name in enumerate(header):
        if name in header[:field]:
            raise fault_in(path, source, top, field, f"column {name!r} stands twice in the header")
    if len(header) == 1 and any(mark in first[0] for mark in ";\t"):
        raise fault_in(path, source, top, 0, "header", expected="columns separated by commas", received=first[0][:40])
    if not body:
        raise RecordingError("no rows under the header", file=path, line=top + 1, column=1)
    values = np.empty((len(body), len(header)))
    for index, (line, row) in enumerate(body):
        if len(row) != len(header):
            raise fault_in(
                path, source, line, min(len(row), len(header)), "row", expected=f"{len(header)} fields", received=len(row)
            )
        for field, content in enumerate(row):
            try:
                values[index, field] = number(content)
            except ValueError:
                raise fault_in(
                    path, source, line, field, f"column {header[field]}", expected="a finite number", received=repr(content[:40])
                ) from None
    return Table(path, source, header, top, tuple(line for line, _ in body), values)
