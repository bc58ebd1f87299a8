"""Text files of tracking systems: header lines above rows of numbers, with the line and column of every fault."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from dataclasses import field as slot
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.delimited import number, numbers
from hsr_pin.recordings.importers.matlab import is_matlab, read_matlab
from hsr_pin.recordings.importers.plain import read_plain
from hsr_pin.recordings.importers.workbook import is_workbook, read_workbook
from hsr_pin.recordings.text import field_column, split_fields
from hsr_pin.trajectory import Array

#: Largest accepted coordinate, in any unit.
LARGEST = 1e9
#: Number of rows before the last one that determine the form of a complete row.
USUAL = 50
#: Size of the beginning of a text from which its form is determined [bytes].
HEAD = 1 << 20


@dataclass(frozen=True, eq=False)
class Sheet:
    """Non-blank rows of a text file.

    Attributes:
        path: the file.
        text: content of the file as UTF-8.
        starts: (R + 1,) positions at which the rows begin and the last one ends [bytes].
        lines: (R,) line number of each row, counted from 1.
        separator: character between fields.
        decimal: decimal mark.
        encoding: encoding of the file if not UTF-8.
        cells: whether the rows are cells of a workbook or arrays, so that a field is a column of its own.
    """

    path: Path
    text: bytes
    starts: NDArray[np.int64]
    lines: NDArray[np.int64]
    separator: str
    decimal: str
    encoding: str
    cells: bool = False
    _known: dict[int, list[str]] = slot(default_factory=dict)

    def __len__(self) -> int:
        return len(self.lines)

    def source(self, row: int) -> str:
        """Return the text of a row."""
        return self.text[self.starts[row] : self.starts[row + 1]].split(b"\n", 1)[0].decode("utf-8", "replace")

    def row(self, row: int) -> list[str]:
        """Return the fields of a row; no fields beyond the last row."""
        if not 0 <= row < len(self):
            return []
        if row not in self._known:
            try:
                self._known[row] = split_fields(self.source(row), self.separator)
            except csv.Error as error:
                raise RecordingError(
                    "not a table", received=error, file=self.path, line=int(self.lines[row]), column=1
                ) from error
        return self._known[row]

    def release(self) -> None:
        """Release the memory of rows that were cached."""
        self._known.clear()

    def field(self, row: int, index: int) -> str:
        """Return a field; empty beyond the end of its row and beyond the last row."""
        fields = self.row(row)
        return fields[index] if index < len(fields) else ""

    def fault(self, row: int, index: int, subject: str, **facts: Any) -> RecordingError:
        """Return an error at a field (of the last row if the row does not exist)."""
        row = min(row, len(self) - 1)
        column = index + 1 if self.cells else field_column(self.source(row), index, self.separator)
        return RecordingError(subject, file=self.path, line=int(self.lines[row]), column=column, **facts)

    def value(self, row: int, index: int) -> float:
        """Return the number in a field; NaN if it is empty.

        Raises:
            ValueError: the field is not a number.
        """
        text = self.field(row, index)
        return number(text if self.decimal == "." else text.replace(self.decimal, "."))

    def is_number(self, row: int, index: int) -> bool:
        """Return whether a field is a finite number."""
        try:
            return bool(np.isfinite(self.value(row, index)))
        except ValueError:
            return False

    def titles(self, known: Iterable[str]) -> list[int]:
        """Return the rows that contain only one of the given words, in upper or lower case."""
        words = "|".join(re.escape(word) for word in known)
        pattern = rf'^[ "]*(?:{words})[ "]*{re.escape(self.separator)}*[ \t]*\r?$'
        found = [match.start() for match in re.finditer(pattern.encode(), self.text, re.IGNORECASE | re.MULTILINE)]
        return [int(row) for row in np.searchsorted(self.starts, found, side="right") - 1]

    def numbers(self, rows: range, columns: Sequence[int], names: Sequence[str] = ()) -> Array:
        """Return the numbers (rows, columns) of some columns; NaN where a field is empty or absent.

        Args:
            rows: range of the rows.
            columns: indices of the columns, counted from 0.
            names: names of the first columns, which must not be empty; the other columns are coordinates.

        Raises:
            RecordingError: a field is not a number (the error names the first one), or the last row is truncated.
        """
        if len(rows) == 0:
            return np.empty((0, len(columns)))
        self._check_end(rows)
        body = memoryview(self.text)[self.starts[rows[0]] : self.starts[rows[-1] + 1]]
        width = max(columns) + 1
        form: dict[str, Any] = {"separator": self.separator, "decimal": self.decimal, "strict": False}
        try:
            values = numbers(body, width, columns=list(columns), **form)
            if len(values) != len(rows):
                raise ValueError("blank rows")
        except ValueError:
            values = self._row_by_row(rows, columns, names)
        places = values[:, len(names) :]
        if np.fmax.reduce(places, axis=None, initial=0) > LARGEST or np.fmin.reduce(places, axis=None, initial=0) < -LARGEST:
            row, column = (int(place) for place in np.argwhere(np.abs(places) > LARGEST)[0])
            expected, received = f"at most {LARGEST:g}", f"{places[row, column]:g}"
            raise self.fault(rows[row], columns[column + len(names)], "coordinate", expected=expected, received=received)
        empty = np.argwhere(np.isnan(values[:, : len(names)]))
        if empty.size:
            row, column = (int(place) for place in empty[0])
            received = repr(self.field(rows[row], columns[column])[:40])
            raise self.fault(rows[row], columns[column], names[column], expected="a number", received=received)
        return values

    def check_count(self, rows: range, stated: float | None, where: str) -> None:
        """Check that a file has as many rows as it states.

        Raises:
            RecordingError: the file has fewer rows.
        """
        if stated is not None and len(rows) < stated:
            raise self.fault(
                len(self) - 1,
                0,
                "the file is truncated",
                expected=f"{stated:g} frames, as stated by {where}",
                received=len(rows),
                hint="copy or export it again; if it was cut on purpose, correct that number",
            )

    def _row_by_row(self, rows: range, columns: Sequence[int], names: Sequence[str]) -> Array:
        values = np.empty((len(rows), len(columns)))
        for place, row in enumerate(rows):
            for column, index in enumerate(columns):
                try:
                    values[place, column] = self.value(row, index)
                except ValueError:
                    received = repr(self.field(row, index)[:40])
                    what = names[column] if column < len(names) else "coordinate"
                    raise self.fault(row, index, what, expected="a finite number", received=received) from None
            self.release()
        return values

    def _check_end(self, rows: range) -> None:
        """Check that the last row is complete; a shorter last row without a line end shows a truncated file."""
        if rows[-1] != len(self) - 1 or self.text.endswith((b"\n", b"\r")) or len(rows) < 2:
            return
        last, others = self.row(rows[-1]), [self.row(row) for row in rows[-USUAL - 1 : -1]]
        filled = max(len(row) - next((n for n, field in enumerate(reversed(row)) if field), len(row)) for row in others)
        least = min(filled, *(len(row) for row in others))
        digits = [_decimals(row[len(last) - 1]) for row in others if len(row) >= len(last) > 0]
        if len(last) < least or (digits and last[-1] and _decimals(last[-1]) < min(digits)):
            raise self.fault(
                rows[-1],
                len(last) - 1,
                "the file is truncated",
                expected=f"a last row of {least} fields that ends with a line break",
                received=f"{len(last)} fields, the last {last[-1][:40]!r}" if last else "none",
                hint="copy or export it again, or remove its last line",
            )


def positive(text: str) -> float | None:
    """Return a positive number in a header field; None if it is not one."""
    try:
        value = number(text.replace(",", "."))
    except ValueError:
        return None
    return value if value > 0 else None


def _decimals(text: str) -> int:
    return len(text) - 1 - max(text.find("."), text.find(","), -1) if "." in text or "," in text else 0


def read_sheet(path: Path, worksheet: str | None = None) -> Sheet:
    """Read a text file with commas, semicolons, tabs, bars or spaces between fields, an Excel workbook, or a MATLAB file.

    Args:
        path: the file.
        worksheet: name of the worksheet of a workbook; None: the first one.

    Raises:
        RecordingError: the file cannot be read, or is not text, or has no such worksheet.
        MissingDependencyError: the package that reads such a file is not installed.
    """
    if is_workbook(path):
        return _sheet_of_cells(path, read_workbook(path, worksheet))
    if worksheet is not None:
        raise RecordingError("[file] sheet", expected="an Excel workbook (.xlsx)", received="another file", file=path)
    if is_matlab(path):
        return _sheet_of_cells(path, read_matlab(path))
    text, encoding = read_plain(path)
    starts, lines = _rows(text)
    sample = _sample(text, starts)
    spaced = b"," not in sample and len(sample.split()) > 1
    separator = next((mark for mark in ("\t", ";", "|") if mark.encode() in sample), " " if spaced else ",")
    if separator == " ":
        text = re.sub(rb"(?m)^ +| +(?=[\r\n]|\Z)", b"", re.sub(rb" {2,}", b" ", text))
        starts, lines = _rows(text)
    decimal = "," if separator != "," and re.search(rb"\d,\d", sample) else "."
    return Sheet(path, text, starts, lines, separator, decimal, encoding)


def _sheet_of_cells(path: Path, rows: Iterable[Sequence[str]]) -> Sheet:
    """Return the sheet of rows of cells."""
    clean = str.maketrans('\t\r\n"', "   '")
    text = "".join("\t".join(cell.translate(clean) for cell in row) + "\n" for row in rows).encode()
    if not text.strip():
        raise RecordingError("the file is empty", file=path, line=1, column=1)
    starts, lines = _rows(text)
    return Sheet(path, text, starts, lines, "\t", ".", "", cells=True)


def _sample(text: bytes, starts: NDArray[np.int64]) -> bytes:
    """Return the last row of the beginning of a text, which is a row of numbers if the text has any."""
    row = max(0, int(np.searchsorted(starts[:-1], HEAD)) - 1)
    return text[int(starts[row]) : int(starts[row + 1])]


def _rows(text: bytes) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the positions of the non-blank rows and of the end of the text, and the line numbers of the rows."""
    content = np.frombuffer(text, dtype=np.uint8)
    ends = [np.flatnonzero(content[at : at + HEAD] == 10) + at for at in range(0, len(content), HEAD)]
    starts = np.concatenate([[0], *(places + 1 for places in ends)]).astype(np.int64)
    starts = starts[starts < len(text)]
    stops = np.append(starts[1:], len(text))
    doubtful = np.isin(content[starts], np.frombuffer(b' ,;|\t"\r\n', dtype=np.uint8))
    blank = [bool(doubt) and not text[a:b].strip(b' ,;|\t"\r\n') for a, b, doubt in zip(starts, stops, doubtful, strict=True)]
    kept = ~np.array(blank, dtype=bool)
    return np.append(starts[kept], len(text)), np.flatnonzero(kept).astype(np.int64) + 1
