"""Any table of numbers, read as a mapping says."""

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

#: Lines of units and the like below the names are passed over, up to so many.
BELOW_NAMES = 10
#: Rows whose time is that of the row before are left out, if they are no larger a share than this.
STANDING = 0.1
#: What may stand before the names.
COMMENT = ("#", "%")


def read_mapped(path: Path, mapping: TableMapping, unit: str | None = None) -> Capture:
    """Read a recording.

    Args:
        path: the table.
        mapping: what stands where.
        unit: of length, in place of the mapping's.

    Raises:
        RecordingError: with file, line and column of the first fault.
    """
    if mapping.time is None and mapping.rate is None:
        expected = "[time] with a column of times, or a rate [Hz]"
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
            notes.append(f"{len(rows) - len(stamps)} rows with the time of the row before were left out")
    time, note = _time(stamps, values[:, 0] if frame else None, len(values), mapping)
    found = iter(values[:, len(frame) :].T)
    nothing = np.zeros(len(values))
    columns = [nothing if place.column is None else place.sign * next(found) for place in places]
    said, called = unit or mapping.unit, [name for name, _ in mapping.points]
    turned = values[:, len(frame) + len(used) :]
    return capture(
        path,
        f"table, by {mapping.path.name}",
        time,
        called,
        np.stack(columns, axis=1).reshape(len(values), len(mapping.points), 3),
        up=mapping.known_up,
        unit=said,
        factor=metres(unit) if unit else mapping.factor,
        notes=[*notes, *([note] if note else [])],
        encoding=sheet.encoding,
        turns={called.index(name): turned[:, 4 * k : 4 * k + 4] for k, (name, _) in enumerate(mapping.poses)},
        still_at_zero=True,
    )


def read_mapped_commands(path: Path, mapping: TableMapping, wanted: InputMapping, recording: Capture) -> CommandRows:
    """Read commands: of a file of their own, or of the recording's. Rows without one are passed over: the last is held.

    Args:
        path: the table.
        mapping: of the recording.
        wanted: what stands where.
        recording: whose clock the rows are put on.

    Raises:
        RecordingError: with file, line and column of the first fault.
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
        raise sheet.fault(rows[0], fields[0], "no command", expected="a number in some row", received="none")
    if not own and len(rows) == len(recording.time):
        stamps = recording.time
    elif stamps is not None:
        stamps = stamps - (recording.start if not own or wanted.clock == "shared" else 0.0)
    else:
        hint = f"say it in {mapping.path.name}: [input] time"
        raise sheet.fault(max(header, 0), 0, "no time of the commands", expected="a column of times", hint=hint)
    given &= _in_order(sheet, rows, stamps)
    return CommandRows(path, stamps[given], tuple(name for name, _ in wanted.columns), commands[given])


def _own_clock(clock: Clock | None, names: list[str]) -> Clock | None:
    """Where times are in a file of commands, if nothing is said of it: as in the recording, or else in ``t`` [s]."""
    there = clock is not None and all(isinstance(column, int) or column in names for column in clock.columns)
    return Clock(("t",)) if "t" in names and not there else clock


def _opened(path: Path, mapping: TableMapping) -> tuple[Sheet, list[str], int]:
    """The sheet, the names of its columns, and their row; -1 where there are none."""
    sheet = read_sheet(path)
    if mapping.separator or mapping.decimal:
        separator, decimal = mapping.separator or sheet.separator, mapping.decimal or sheet.decimal
        sheet = replace(sheet, separator=separator, decimal=decimal, _known={})
    if mapping.header == 0:
        return sheet, [], -1
    row = 0 if mapping.header is None else int(np.searchsorted(sheet.lines, mapping.header))
    if row >= len(sheet) or (mapping.header is not None and sheet.lines[row] != mapping.header):
        expected = f"names in line {mapping.header}, as the mapping says"
        raise sheet.fault(len(sheet) - 1, 0, "header", expected=expected, received="none")
    names = sheet.row(row)[1:] if sheet.field(row, 0) in COMMENT else sheet.row(row)
    return sheet, [name.lstrip("".join(COMMENT)).strip() for name in names], row


def _find(sheet: Sheet, names: list[str], header: int, column: Column) -> int:
    """Where a column stands, counted from 0."""
    row = max(header, 0)
    if isinstance(column, int):
        width = len(sheet.row(max(header + 1, len(sheet) // 2)))
        if not 1 <= column <= width:
            raise sheet.fault(row, 0, f"column {column}", expected=f"1 to {width}", received=column, hint="see the mapping")
        return column - 1
    same = [index for index, name in enumerate(names) if name == column.strip()]
    same = same or [index for index, name in enumerate(names) if name.lower() == column.strip().lower()]
    if len(same) == 1:
        return same[0]
    if same:
        hint = f"give its number in the mapping: {' or '.join(str(index + 1) for index in same[:4])}"
        raise sheet.fault(row, same[1], f"column {column!r} stands {len(same)} times in the header", hint=hint)
    hint = nearest(column, [name for name in names if name][:200], "columns") if names else "without a header, give numbers"
    raise sheet.fault(row, 0, f"no column {column!r}", hint=hint)


def _place(sheet: Sheet, names: list[str], header: int, place: Place) -> Place:
    """A place with its column counted from 0; a minus before a name or a number turns it round."""
    column = place.column
    if column is None:
        return place
    if isinstance(column, int):
        return Place(_find(sheet, names, header, abs(column)), -1.0 if column < 0 else 1.0)
    bare = column.strip()
    turned = bare.startswith("-") and bare not in names
    return Place(_find(sheet, names, header, bare[1:] if turned else bare), -1.0 if turned else 1.0)


def _body(sheet: Sheet, header: int, column: int) -> range:
    """The rows of numbers."""
    below = range(header + 1, min(len(sheet), header + 1 + BELOW_NAMES))
    first = next((row for row in below if sheet.is_number(row, column)), None)
    if first is None:
        hint = "is the line of the names another? say it: [file] header"
        raise sheet.fault(header + 1, column, "no rows of numbers under the names", hint=hint)
    return range(first, len(sheet))


def _clock(sheet: Sheet, names: list[str], header: int, clock: Clock | None) -> list[int]:
    """The columns of times, counted from 0."""
    return [] if clock is None else [_find(sheet, names, header, column) for column in clock.columns]


def _values(
    sheet: Sheet, rows: range, clock: Clock | None, clocks: list[int], columns: list[int], names: list[str]
) -> tuple[Array | None, Array]:
    """(T,) [s] the times, None without a clock; and (T, columns) what stands in some columns, the first of which have names."""
    if clock is None or clock.form is not None:
        stamps = None if clock is None else _calendar(sheet, rows, clocks[0], clock.form or "")
        return stamps, sheet.numbers(rows, columns, names)
    values = sheet.numbers(rows, [*clocks, *columns], ["time"] * len(clocks) + names)
    return values[:, : len(clocks)] @ np.array(clock.factors), values[:, len(clocks) :]


def _calendar(sheet: Sheet, rows: range, column: int, form: str) -> Array:
    """(T,) [s] dates and times of day, since 1970."""
    stamps = np.empty(len(rows))
    for place, row in enumerate(rows):
        text = sheet.field(row, column)
        try:
            stamps[place] = datetime.strptime(text, form).replace(tzinfo=timezone.utc).timestamp()
        except ValueError as error:
            raise sheet.fault(
                row, column, "time", expected=f"as {form}", received=repr(text[:40]), hint=str(error)[:100]
            ) from error
        sheet.forget()
    return stamps


def _time(stamps: Array | None, frames: Array | None, rows: int, mapping: TableMapping) -> tuple[Array, str]:
    if stamps is None:
        frames = np.arange(rows, dtype=float) if frames is None else frames
        return (frames - frames[0]) / (mapping.rate or 1.0), ""
    return (stamps, "") if frames is None else frame_times(frames, mapping.rate, stamps)


def _in_order(sheet: Sheet, rows: range, stamps: Array) -> NDArray[np.bool_]:
    """(T,) whether each row comes after the one before: of two with one time, the first.

    Raises:
        RecordingError: time goes back, or stands still in more than a few rows.
    """
    steps = np.diff(stamps)
    wrong = np.flatnonzero(steps < 0)
    if not wrong.size and np.sum(steps == 0) > STANDING * len(stamps):
        wrong = np.flatnonzero(steps == 0)
    if wrong.size:
        row, before = rows[int(wrong[0]) + 1], stamps[int(wrong[0])]
        expected, received = f"more than {before:.16g} s, the time before it", f"{stamps[int(wrong[0]) + 1]:.16g} s"
        hint = "take double rows away, or give a frame column and the rate"
        raise sheet.fault(row, 0, "time", expected=expected, received=received, hint=hint)
    return np.concatenate([[True], steps > 0])
