"""The CSV of a tracking system: header lines of its own above rows of numbers, with the place of every fault."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.text import csv_lines, csv_rows, fault_in, number, read_text
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class Sheet:
    """The rows of a file that are not blank.

    Attributes:
        path: the file.
        source: (lines,) its text.
        lines: line of each row, counted from 1.
        rows: the fields of each row, stripped.
    """

    path: Path
    source: list[str]
    lines: list[int]
    rows: list[list[str]]

    def field(self, row: int, index: int) -> str:
        """A field; empty beyond the end of its row, and beyond the last row."""
        fields = self.rows[row] if row < len(self.rows) else []
        return fields[index] if index < len(fields) else ""

    def fault(self, row: int, index: int, subject: str, **facts: Any) -> RecordingError:
        """An error at a field (of the last row, if there is no such row)."""
        line = self.lines[min(row, len(self.lines) - 1)]
        return fault_in(self.path, self.source, line, index, subject, **facts)

    def is_number(self, row: int, index: int) -> bool:
        """Whether a field is a finite number."""
        try:
            return bool(np.isfinite(number(self.field(row, index))))
        except ValueError:
            return False

    def numbers(self, rows: range, indices: list[int]) -> Array:
        """(rows, indices) the numbers in some columns; NaN where a field is empty or absent.

        Raises:
            RecordingError: at the first field that is not a number.
        """
        values = np.empty((len(rows), len(indices)))
        for place, row in enumerate(rows):
            for column, index in enumerate(indices):
                try:
                    values[place, column] = number(self.field(row, index))
                except ValueError:
                    received = repr(self.field(row, index)[:40])
                    raise self.fault(row, index, "coordinate", expected="a finite number", received=received) from None
                if abs(values[place, column]) > 1e9:
                    raise self.fault(row, index, "coordinate", expected="at most 1e9", received=f"{values[place, column]:g}")
        return values


def read_sheet(path: Path) -> Sheet:
    """Read the CSV of a tracking system.

    Raises:
        RecordingError: unreadable, or not CSV.
    """
    text = read_text(path)
    rows = csv_rows(text, path) or [(1, [""])]
    return Sheet(path, csv_lines(text), [line for line, _ in rows], [[field.strip() for field in row] for _, row in rows])
