"""Reader of tables of numbers whose columns are described by a mapping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.formula import Formula, FormulaError
from hsr_pin.recordings.importers.mapping import Clock, Column, InputMapping, TableMapping
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

#: Largest number of lines between the column names and the numbers, such as lines of units.
BELOW_NAMES = 10
#: Largest share of rows with the time of the previous row, which are left out.
STANDING = 0.1
#: Step [s] and number of the equal samples with which a pose at rest is written.
POSE_STEP, POSE_SAMPLES = 0.05, 20
#: Characters that may precede the column names.
COMMENT = ("#", "%")


def read_mapped(path: Path, mapping: TableMapping, unit: str | None = None) -> Capture:
    """Read a capture from a table with a mapping.

    Args:
        path: the table.
        mapping: meaning of the columns.
        unit: unit of length, in place of that in the mapping.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
        MissingDependencyError: the package that reads such a file is not installed.
    """
    if mapping.time is None and mapping.rate is None and not mapping.rest:
        expected = "[time] with a column of times or a rate [Hz], or rest = true"
        raise RecordingError("no time", expected=expected, received="none", file=mapping.path, line=1, column=1)
    table = _Table.opened(path, mapping)
    places = [None if column is None else table.quantity(column) for _, triple in mapping.points for column in triple]
    clock = table.clock(mapping.time)
    frame = [] if mapping.frame is None else [table.quantity(mapping.frame)]
    used = [place for place in places if place is not None]
    parts = [table.quantity(column) for _, columns in mapping.poses for column in columns]
    rows = table.body([*clock, *frame, *used] if mapping.time is None or mapping.time.form is None else used)
    stamps, values = table.values(rows, mapping.time, clock, [*frame, *used, *parts], len(frame))
    notes = [f"imported from {path.name} by {mapping.path.name} ({unit or mapping.unit})"]
    if stamps is not None:
        kept = table.in_order(rows, stamps)
        stamps, values = stamps[kept], values[kept]
        if len(stamps) < len(rows):
            notes.append(f"{len(rows) - len(stamps)} rows with the time of the previous row were left out")
    if mapping.rest:
        values = np.repeat(values, POSE_SAMPLES, axis=0)
        notes.append(f"each row is a pose at rest, written as {POSE_SAMPLES} equal samples; their noise is not known")
    time, note = _time(stamps, values[:, 0] if frame else None, len(values), mapping)
    found = iter(values[:, len(frame) :].T)
    nothing = np.zeros(len(values))
    columns = [nothing if place is None else next(found) for place in places]
    unit_name, called = unit or mapping.unit, [name for name, _ in mapping.points]
    turned = values[:, len(frame) + len(used) :]
    return capture(
        path,
        f"table, by {mapping.path.name}",
        time,
        called,
        np.stack(columns, axis=1).reshape(len(values), len(mapping.points), 3),
        up=mapping.known_up,
        unit=unit_name,
        factor=metres(unit) if unit else mapping.factor,
        notes=[*notes, *([note] if note else [])],
        encoding=table.sheet.encoding,
        quaternions={called.index(name): turned[:, 4 * k : 4 * k + 4] for k, (name, _) in enumerate(mapping.poses)},
        still_at_zero=True,
    )


def read_mapped_commands(path: Path, mapping: TableMapping, wanted: InputMapping, recording: Capture) -> CommandRows:
    """Read commands from a separate file or from the recording; rows without a command are skipped, as commands are held.

    Args:
        path: the table.
        mapping: mapping of the recording.
        wanted: columns of the commands.
        recording: recording whose clock the times refer to.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
        MissingDependencyError: the package that reads such a file is not installed.
    """
    own = path.resolve() != recording.path.resolve()
    table = _Table.opened(path, replace(mapping, header=None) if own and mapping.header else mapping)
    times = wanted.time or (_own_clock(mapping.time, table.names) if own else mapping.time)
    clock = table.clock(times)
    fields = [table.quantity(column) for _, column in wanted.columns]
    rows = table.body([*clock, *fields] if times is None or times.form is None else fields)
    stamps, values = table.values(rows, times, clock, fields)
    if mapping.rest:
        stamps = np.asarray(np.arange(len(rows)) * POSE_STEP * POSE_SAMPLES)
    elif not own and wanted.time is None and len(rows) == len(recording.time):
        stamps = recording.time
    elif stamps is not None:
        stamps = stamps - (recording.start if not own or wanted.clock == "shared" else 0.0)
    else:
        hint = f"give [input] time in {mapping.path.name}"
        raise table.fault(max(table.header, 0), 0, "the commands have no times", expected="a column of times", hint=hint)
    given, names = table.in_order(rows, stamps), [name for name, _ in wanted.columns]
    found = CommandRows.of(path, stamps[given], names, values[given] * wanted.factor)
    if not len(found.time):
        raise table.fault(rows[0], fields[0].first, "no command", expected="a number in at least one row", received="none")
    return found


def starts_of_poses(time: Array) -> tuple[float, ...]:
    """Return the times [s] at which the poses after the first one begin, in a recording (T,) [s] of poses at rest."""
    return tuple(float(begin) for begin in time[POSE_SAMPLES::POSE_SAMPLES])


def _own_clock(clock: Clock | None, names: Sequence[str]) -> Clock | None:
    """Return the default clock of a separate file of commands: that of the recording, or else the column ``t`` [s]."""
    there = clock is not None and all(isinstance(column, int) or column in names for column in clock.columns)
    return Clock(("t",)) if "t" in names and not there else clock


@dataclass(frozen=True, eq=False)
class _Quantity:
    """One column, or a formula of several.

    Attributes:
        columns: indices of the columns, counted from 0.
        formula: formula of their values; None: the value of the one column.
    """

    columns: tuple[int, ...]
    formula: Formula | None = None

    @property
    def first(self) -> int:
        """Index of the first column, at which an error is reported."""
        return self.columns[0]


@dataclass(frozen=True, eq=False)
class _Table:
    """A sheet with the names of its columns.

    Attributes:
        sheet: the rows of the file.
        names: names of the columns; empty if the file has none.
        header: row of the names, -1 if there are none.
        mapping: the mapping, for errors.
    """

    sheet: Sheet
    names: tuple[str, ...]
    header: int
    mapping: TableMapping

    @classmethod
    def opened(cls, path: Path, mapping: TableMapping) -> _Table:
        """Return a table whose separator, decimal mark and lines of names are those of a mapping, or determined from the file."""
        sheet = read_sheet(path, mapping.sheet)
        if (mapping.separator or mapping.decimal) and not sheet.cells:
            separator, decimal = mapping.separator or sheet.separator, mapping.decimal or sheet.decimal
            sheet = replace(sheet, separator=separator, decimal=decimal, _known={})
        if mapping.header == ():
            return cls(sheet, (), -1, mapping)
        rows = []
        for line in mapping.header or (int(sheet.lines[0]),):
            row = int(np.searchsorted(sheet.lines, line))
            if row >= len(sheet) or sheet.lines[row] != line:
                expected = f"column names in line {line}, as given by the mapping"
                raise sheet.fault(len(sheet) - 1, 0, "header", expected=expected, received="none")
            rows.append(row)
        return cls(sheet, _joined([names_in(sheet, row) for row in rows]), rows[-1], mapping)

    def fault(self, row: int, column: int, subject: str, **facts: Any) -> RecordingError:
        """Return an error at a field."""
        return self.sheet.fault(row, column, subject, **facts)

    def quantity(self, column: Column) -> _Quantity:
        """Return a column by its name, its number counted from 1 (negative: with the opposite sign), or a formula.

        Raises:
            RecordingError: the table has no such column.
        """
        row = max(self.header, 0)
        width = len(self.sheet.row(max(self.header + 1, len(self.sheet) // 2)))
        if isinstance(column, int):
            if not 1 <= abs(column) <= width:
                raise self.fault(row, 0, f"column {column}", expected=f"1 to {width}", received=column, hint="check the mapping")
            return _Quantity((column - 1,)) if column > 0 else self.quantity(f"-${-column}")
        text = column.strip()
        same = [index for index, name in enumerate(self.names) if name == text]
        same = same or [index for index, name in enumerate(self.names) if name.lower() == text.lower()]
        if len(same) == 1:
            return _Quantity((same[0],))
        if same:
            hint = f"give its number in the mapping: {' or '.join(str(index + 1) for index in same[:4])}"
            raise self.fault(row, same[1], f"column {text!r} occurs {len(same)} times in the header", hint=hint)
        if not set(text) & set("-+*/("):
            hint = nearest(text, [name for name in self.names if name][:200], "columns") if self.names else "give column numbers"
            raise self.fault(row, 0, f"the table has no column {text!r}", hint=hint)
        return self._formula(text, row, width)

    def _formula(self, text: str, row: int, width: int) -> _Quantity:
        numbered = [f"${number}" for number in range(1, width + 1)]
        once = [name for name in self.names if self.names.count(name) == 1]
        try:
            formula = Formula.parse(text, [*once, *numbered], once or numbered)
        except FormulaError as error:
            raise self.fault(row, 0, f"{error.subject} in {self.mapping.path.name}", **error.facts) from error
        places = {**{name: index for index, name in enumerate(numbered)}, **{name: self.names.index(name) for name in once}}
        return _Quantity(tuple(places[name] for name in formula.names), formula)

    def clock(self, clock: Clock | None) -> list[_Quantity]:
        """Return the columns of times."""
        return [] if clock is None else [self.quantity(column) for column in clock.columns]

    def body(self, wanted: Sequence[_Quantity]) -> range:
        """Return the rows of numbers of a column; in a workbook, up to its last cell that is not empty."""
        column = wanted[0].first
        below = range(self.header + 1, min(len(self.sheet), self.header + 1 + BELOW_NAMES))
        first = next((row for row in below if self.sheet.is_number(row, column)), None)
        if first is None:
            hint = "if the column names are in another line, give [file] header"
            hint += "; formulas have values only in a workbook that Excel has saved" if self.sheet.cells else ""
            raise self.fault(self.header + 1, column, "no rows of numbers under the column names", hint=hint)
        last = len(self.sheet) - 1
        while self.sheet.cells and not self.sheet.field(last, column):
            last -= 1
        self.sheet.release()
        return range(first, last + 1)

    def values(
        self, rows: range, clock: Clock | None, clocks: Sequence[_Quantity], wanted: Sequence[_Quantity], frames: int = 0
    ) -> tuple[Array | None, Array]:
        """Return the times (T,) [s], None without a clock, and the values (T, W) of some quantities, the first being frames."""
        if clock is not None and clock.form is not None:
            return self._calendar(rows, clocks[0].first, clock.form), self._numbers(rows, wanted, ["frame"] * frames)
        values = self._numbers(rows, [*clocks, *wanted], ["time"] * len(clocks) + ["frame"] * frames)
        return values[:, : len(clocks)] @ np.array(clock.factors) if clock else None, values[:, len(clocks) :]

    def _numbers(self, rows: range, wanted: Sequence[_Quantity], kinds: Sequence[str]) -> Array:
        """Return the values (T, W) of quantities; the first ones are of the given kinds and may not be empty."""
        labels = {column: kind for kind, one in zip(kinds, wanted, strict=False) for column in one.columns}
        columns = list(dict.fromkeys(column for one in wanted for column in one.columns))
        columns.sort(key=lambda column: column not in labels)
        numbers = self.sheet.numbers(rows, columns, list(labels.values()))
        place = {column: index for index, column in enumerate(columns)}
        values = np.empty((len(numbers), len(wanted)))
        for index, one in enumerate(wanted):
            parts = numbers[:, [place[column] for column in one.columns]]
            values[:, index] = parts[:, 0] if one.formula is None else one.formula.of(parts)
            wrong = np.flatnonzero(np.isfinite(parts).all(axis=1) & ~np.isfinite(values[:, index]))
            if wrong.size:
                row, text = rows[int(wrong[0])], one.formula.text if one.formula else ""
                raise self.fault(row, one.first, f"formula {text!r}", expected="a finite value", received=values[wrong[0], index])
        return values

    def _calendar(self, rows: range, column: int, form: str) -> Array:
        """Return dates and times of day as seconds (T,) since 1970."""
        stamps = np.empty(len(rows))
        for place, row in enumerate(rows):
            text = self.sheet.field(row, column)
            try:
                stamps[place] = datetime.strptime(text, form).replace(tzinfo=timezone.utc).timestamp()
            except ValueError as error:
                facts = {"expected": f"as {form}", "received": repr(text[:40]), "hint": str(error)[:100]}
                raise self.fault(row, column, "time", **facts) from error
            self.sheet.release()
        return stamps

    def in_order(self, rows: range, stamps: Array) -> NDArray[np.bool_]:
        """Return a mask (T,) of the rows to use: each row later than the previous one, and the first of several at one time.

        Raises:
            RecordingError: time decreases, or does not increase in more than a few rows.
        """
        steps = np.diff(stamps)
        wrong = np.flatnonzero(steps < 0)
        if not wrong.size and np.sum(steps == 0) > STANDING * len(stamps):
            wrong = np.flatnonzero(steps == 0)
        if wrong.size:
            row, before = rows[int(wrong[0]) + 1], stamps[int(wrong[0])]
            expected, received = f"more than {before:.16g} s, the previous time", f"{stamps[int(wrong[0]) + 1]:.16g} s"
            hint = "remove duplicate rows, or give a frame column and the rate"
            raise self.fault(row, 0, "time", expected=expected, received=received, hint=hint)
        return np.concatenate([[True], steps > 0])


def names_in(sheet: Sheet, row: int) -> list[str]:
    """Return the column names in a row, without the mark of a comment before them."""
    names = sheet.row(row)[1:] if sheet.field(row, 0) in COMMENT else sheet.row(row)
    return [name.lstrip("".join(COMMENT)).strip() for name in names]


def _joined(rows: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return the names in one or more rows, joined by spaces; above a name, an upper name holds until the next one."""
    joined = [""] * max(map(len, rows))
    for row in rows:
        above = ""
        for index, own in enumerate([*row, *[""] * (len(joined) - len(row))]):
            above = joined[index] or above
            joined[index] = f"{above} {own}".strip() if own else joined[index]
    return tuple(joined)


def _time(stamps: Array | None, frames: Array | None, rows: int, mapping: TableMapping) -> tuple[Array, str]:
    if stamps is None:
        frames = np.arange(rows, dtype=float) if frames is None else frames
        return (frames - frames[0]) * (POSE_STEP if mapping.rest else 1 / (mapping.rate or 1.0)), ""
    return (stamps, "") if frames is None else frame_times(frames, mapping.rate, stamps)
