"""The text of a tracking system: header lines of its own above rows of numbers, with the place of every fault."""

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
from hsr_pin.recordings.importers.plain import read_plain
from hsr_pin.recordings.text import field_column, split_fields
from hsr_pin.trajectory import Array

#: No coordinate is larger, in any unit.
LARGEST = 1e9
#: So many rows before the last tell what a whole one looks like.
USUAL = 50
#: So much of a text is its beginning [bytes].
HEAD = 1 << 20


@dataclass(frozen=True, eq=False)
class Sheet:
    """The rows of a file that are not blank.

    Attributes:
        path: the file.
        text: all of it, as UTF-8.
        starts: (R + 1,) where in the text each row begins, and where the last one ends.
        lines: (R,) line of each row, counted from 1.
        separator: between fields.
        decimal: mark in numbers.
        encoding: what the file was encoded in, if not in UTF-8.
    """

    path: Path
    text: bytes
    starts: NDArray[np.int64]
    lines: NDArray[np.int64]
    separator: str
    decimal: str
    encoding: str
    _known: dict[int, list[str]] = slot(default_factory=dict)

    def __len__(self) -> int:
        return len(self.lines)

    def source(self, row: int) -> str:
        """The text of a row."""
        return self.text[self.starts[row] : self.starts[row + 1]].split(b"\n", 1)[0].decode("utf-8", "replace")

    def row(self, row: int) -> list[str]:
        """The fields of a row; none beyond the last row."""
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

    def forget(self) -> None:
        """Give back the memory of rows that were looked at."""
        self._known.clear()

    def field(self, row: int, index: int) -> str:
        """A field; empty beyond the end of its row, and beyond the last row."""
        fields = self.row(row)
        return fields[index] if index < len(fields) else ""

    def fault(self, row: int, index: int, subject: str, **facts: Any) -> RecordingError:
        """An error at a field (of the last row, if there is no such row)."""
        row = min(row, len(self) - 1)
        column = field_column(self.source(row), index, self.separator)
        return RecordingError(subject, file=self.path, line=int(self.lines[row]), column=column, **facts)

    def value(self, row: int, index: int) -> float:
        """The number in a field; NaN where it is empty.

        Raises:
            ValueError: something else.
        """
        text = self.field(row, index)
        return number(text if self.decimal == "." else text.replace(self.decimal, "."))

    def is_number(self, row: int, index: int) -> bool:
        """Whether a field is a finite number."""
        try:
            return bool(np.isfinite(self.value(row, index)))
        except ValueError:
            return False

    def titles(self, known: Iterable[str]) -> list[int]:
        """The rows that hold one of these words, in letters of any size, and nothing else."""
        words = "|".join(re.escape(word) for word in known)
        pattern = rf'^[ "]*(?:{words})[ "]*{re.escape(self.separator)}*[ \t]*\r?$'
        found = [match.start() for match in re.finditer(pattern.encode(), self.text, re.IGNORECASE | re.MULTILINE)]
        return [int(row) for row in np.searchsorted(self.starts, found, side="right") - 1]

    def numbers(self, rows: range, columns: Sequence[int], names: Sequence[str] = ()) -> Array:
        """(rows, columns) the numbers in some columns; NaN where a field is empty or absent.

        Args:
            rows: which.
            columns: which, counted from 0.
            names: of the first of these columns, which must not be empty; the others are coordinates.

        Raises:
            RecordingError: at the first field that is not a number; or the last row is cut.
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
        """Refuse a file with fewer rows than it says it has.

        Raises:
            RecordingError: it has.
        """
        if stated is not None and len(rows) < stated:
            raise self.fault(
                len(self) - 1,
                0,
                "the file is cut short",
                expected=f"{stated:g} frames, as {where} has it",
                received=len(rows),
                hint="copy or export it anew; if it was cut on purpose, correct that number",
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
            self.forget()
        return values

    def _check_end(self, rows: range) -> None:
        """A file that ends within a line, and sooner than its other rows, was cut: half a number is no number."""
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
                "the file is cut short",
                expected=f"a last row of {least} fields that ends with its line",
                received=f"{len(last)}, the last of them {last[-1][:40]!r}" if last else "none",
                hint="copy or export it anew, or take its last line away",
            )


def positive(text: str) -> float | None:
    """A number above zero in a header; None where there is none."""
    try:
        value = number(text.replace(",", "."))
    except ValueError:
        return None
    return value if value > 0 else None


def _decimals(text: str) -> int:
    return len(text) - 1 - max(text.find("."), text.find(","), -1) if "." in text or "," in text else 0


def read_sheet(path: Path) -> Sheet:
    """Read the text of a tracking system: separated by commas, semicolons, tabs, bars or spaces, decimals with points or commas.

    Raises:
        RecordingError: unreadable, or no text.
    """
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


def _sample(text: bytes, starts: NDArray[np.int64]) -> bytes:
    """The last row of the beginning: where there are rows of numbers, it is one."""
    row = max(0, int(np.searchsorted(starts[:-1], HEAD)) - 1)
    return text[int(starts[row]) : int(starts[row + 1])]


def _rows(text: bytes) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the rows that are not blank begin, with the end of the text, and their lines."""
    content = np.frombuffer(text, dtype=np.uint8)
    ends = [np.flatnonzero(content[at : at + HEAD] == 10) + at for at in range(0, len(content), HEAD)]
    starts = np.concatenate([[0], *(places + 1 for places in ends)]).astype(np.int64)
    starts = starts[starts < len(text)]
    stops = np.append(starts[1:], len(text))
    doubtful = np.isin(content[starts], np.frombuffer(b' ,;|\t"\r\n', dtype=np.uint8))
    blank = [bool(doubt) and not text[a:b].strip(b' ,;|\t"\r\n') for a, b, doubt in zip(starts, stops, doubtful, strict=True)]
    kept = ~np.array(blank, dtype=bool)
    return np.append(starts[kept], len(text)), np.flatnonzero(kept).astype(np.int64) + 1
