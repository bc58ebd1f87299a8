"""Reader of tables of numbers whose columns are described by a mapping."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.mapping import Clock, Column, InputMapping, Place, TableMapping
from hsr_pin.recordings.importers.sheet import Sheet, read_sheet
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

#: Largest number of lines between the column names and the numbers, such as lines of units.
BELOW_NAMES = 10
#: Largest share of rows with the time of the previous row, which are left out.
STANDING = 0.1
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
    """
    if mapping.time is None and mapping.rate is None:
        expected = "[time] with a column of times or a rate [Hz]"
        raise RecordingError("no time", expected=expected, received="none", file=mapping.path, line=1, column=1)
    sheet, names, header = _opened(path, mapping)
    places = [_place(sheet, names, header, place) for _, triple in mapping.points for place in triple]
    clock = _clock(sheet, names, header, mapping.time)
    frame = [] if mapping.frame is None else [_find(sheet, names, header, mapping.frame)]
    used = [place.column for place in places if isinstance(place.column, int)]
    parts = [_find(sheet, names, header, column) for _, columns in mapping.poses for column in columns]
    rows = _body(sheet, header, [*clock, *frame, *used][0] if mapping.time is None or mapping.time.form is None else used[0])
    stamps, values = _values(sheet, rows, mapping.time, clock, [*frame, *used, *parts], ["frame"] * len(frame))
    notes = [f"imported from {path.name} by {mapping.path.name} ({unit or mapping.unit})"]
    if stamps is not None:
        kept = _in_order(sheet, rows, stamps)
        stamps, values = stamps[kept], values[kept]
        if len(stamps) < len(rows):
            notes.append(f"{len(rows) - len(stamps)} rows with the time of the previous row were left out")
    time, note = _time(stamps, values[:, 0] if frame else None, len(values), mapping)
    found = iter(values[:, len(frame) :].T)
    nothing = np.zeros(len(values))
    columns = [nothing if place.column is None else place.sign * next(found) for place in places]
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
        encoding=sheet.encoding,
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
    """
    own = path.resolve() != recording.path.resolve()
    sheet, names, header = _opened(path, replace(mapping, header=None) if own and mapping.header else mapping)
    times = wanted.time or (_own_clock(mapping.time, names) if own else mapping.time)
    clock = _clock(sheet, names, header, times)
    fields = [_find(sheet, names, header, column) for _, column in wanted.columns]
    rows = _body(sheet, header, [*clock, *fields][0] if times is None or times.form is None else fields[0])
    stamps, values = _values(sheet, rows, times, clock, fields, [])
    commands = values * wanted.factor
    given = np.isfinite(commands).all(axis=1)
    if not given.any():
        raise sheet.fault(rows[0], fields[0], "no command", expected="a number in at least one row", received="none")
    if not own and len(rows) == len(recording.time):
        stamps = recording.time
    elif stamps is not None:
        stamps = stamps - (recording.start if not own or wanted.clock == "shared" else 0.0)
    else:
        hint = f"give [input] time in {mapping.path.name}"
        raise sheet.fault(max(header, 0), 0, "the commands have no times", expected="a column of times", hint=hint)
    given &= _in_order(sheet, rows, stamps)
    return CommandRows(path, stamps[given], tuple(name for name, _ in wanted.columns), commands[given])


def _own_clock(clock: Clock | None, names: list[str]) -> Clock | None:
    """Return the default clock of a separate file of commands: that of the recording, or else the column ``t`` [s]."""
    there = clock is not None and all(isinstance(column, int) or column in names for column in clock.columns)
    return Clock(("t",)) if "t" in names and not there else clock


def _opened(path: Path, mapping: TableMapping) -> tuple[Sheet, list[str], int]:
    """Return the sheet, the names of its columns, and the row of the names (-1 if there are none)."""
    sheet = read_sheet(path)
    if mapping.separator or mapping.decimal:
        separator, decimal = mapping.separator or sheet.separator, mapping.decimal or sheet.decimal
        sheet = replace(sheet, separator=separator, decimal=decimal, _known={})
    if mapping.header == 0:
        return sheet, [], -1
    row = 0 if mapping.header is None else int(np.searchsorted(sheet.lines, mapping.header))
    if row >= len(sheet) or (mapping.header is not None and sheet.lines[row] != mapping.header):
        expected = f"column names in line {mapping.header}, as given by the mapping"
        raise sheet.fault(len(sheet) - 1, 0, "header", expected=expected, received="none")
    names = sheet.row(row)[1:] if sheet.field(row, 0) in COMMENT else sheet.row(row)
    return sheet, [name.lstrip("".join(COMMENT)).strip() for name in names], row


def _find(sheet: Sheet, names: list[str], header: int, column: Column) -> int:
    """Return the index of a column, counted from 0."""
    row = max(header, 0)
    if isinstance(column, int):
        width = len(sheet.row(max(header + 1, len(sheet) // 2)))
        if not 1 <= column <= width:
            raise sheet.fault(row, 0, f"column {column}", expected=f"1 to {width}", received=column, hint="check the mapping")
        return column - 1
    same = [index for index, name in enumerate(names) if name == column.strip()]
    same = same or [index for index, name in enumerate(names) if name.lower() == column.strip().lower()]
    if len(same) == 1:
        return same[0]
    if same:
        hint = f"give its number in the mapping: {' or '.join(str(index + 1) for index in same[:4])}"
        raise sheet.fault(row, same[1], f"column {column!r} occurs {len(same)} times in the header", hint=hint)
    hint = nearest(column, [name for name in names if name][:200], "columns") if names else "give column numbers"
    raise sheet.fault(row, 0, f"the table has no column {column!r}", hint=hint)


def _place(sheet: Sheet, names: list[str], header: int, place: Place) -> Place:
    """Return a place with its column as an index from 0; a minus sign before the name or number inverts the coordinate."""
    column = place.column
    if column is None:
        return place
    if isinstance(column, int):
        return Place(_find(sheet, names, header, abs(column)), -1.0 if column < 0 else 1.0)
    bare = column.strip()
    turned = bare.startswith("-") and bare not in names
    return Place(_find(sheet, names, header, bare[1:] if turned else bare), -1.0 if turned else 1.0)


def _body(sheet: Sheet, header: int, column: int) -> range:
    """Return the range of the rows of numbers."""
    below = range(header + 1, min(len(sheet), header + 1 + BELOW_NAMES))
    first = next((row for row in below if sheet.is_number(row, column)), None)
    if first is None:
        hint = "if the column names are in another line, give [file] header"
        raise sheet.fault(header + 1, column, "no rows of numbers under the column names", hint=hint)
    return range(first, len(sheet))


def _clock(sheet: Sheet, names: list[str], header: int, clock: Clock | None) -> list[int]:
    """Return the indices of the columns of times, counted from 0."""
    return [] if clock is None else [_find(sheet, names, header, column) for column in clock.columns]


def _values(
    sheet: Sheet, rows: range, clock: Clock | None, clocks: list[int], columns: list[int], names: list[str]
) -> tuple[Array | None, Array]:
    """Return the times (T,) [s], None without a clock, and the numbers (T, columns) of some columns, the first with names."""
    if clock is None or clock.form is not None:
        stamps = None if clock is None else _calendar(sheet, rows, clocks[0], clock.form or "")
        return stamps, sheet.numbers(rows, columns, names)
    values = sheet.numbers(rows, [*clocks, *columns], ["time"] * len(clocks) + names)
    return values[:, : len(clocks)] @ np.array(clock.factors), values[:, len(clocks) :]


def _calendar(sheet: Sheet, rows: range, column: int, form: str) -> Array:
    """Return dates and times of day as seconds (T,) since 1970."""
    stamps = np.empty(len(rows))
    for place, row in enumerate(rows):
        text = sheet.field(row, column)
        try:
            stamps[place] = datetime.strptime(text, form).replace(tzinfo=timezone.utc).timestamp()
        except ValueError as error:
            raise sheet.fault(
                row, column, "time", expected=f"as {form}", received=repr(text[:40]), hint=str(error)[:100]
            ) from error
        sheet.release()
    return stamps


def _time(stamps: Array | None, frames: Array | None, rows: int, mapping: TableMapping) -> tuple[Array, str]:
    if stamps is None:
        frames = np.arange(rows, dtype=float) if frames is None else frames
        return (frames - frames[0]) / (mapping.rate or 1.0), ""
    return (stamps, "") if frames is None else frame_times(frames, mapping.rate, stamps)


def _in_order(sheet: Sheet, rows: range, stamps: Array) -> NDArray[np.bool_]:
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
        raise sheet.fault(row, 0, "time", expected=expected, received=received, hint=hint)
    return np.concatenate([[True], steps > 0])
