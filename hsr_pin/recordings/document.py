"""A TOML document whose values know where they stand."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import LARGEST_DOCUMENT
from hsr_pin.recordings.plausible import angle_doubt
from hsr_pin.recordings.text import nearest, read_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # type: ignore[import-not-found,unused-ignore]

#: Way to a value through tables (names) and arrays of tables (indices).
Way = tuple[str | int, ...]
#: Line and column, both counted from 1.
Place = tuple[int, int]

#: A key that starts later in its line than this is not looked for.
LONGEST_KEY = 500
#: No key has more parts than this, and no line more brackets: parsers need time and memory that grow with their square.
DEEPEST = 64

# Each takes time in proportion to a line: no two parts that follow each other take the same sign.
_HEADER = re.compile(r"\s*(?P<open>\[\[?)(?P<name>[^\[\]]+)\]")
_KEY = re.compile(r"""\s*(?P<name>(?=\S)(?:"[^"]*"|'[^']*'|[\w\-. \t])+)=""")
_STRING = re.compile(r""""(?:[^"\\]|\\.)*"|'[^']*'|#.*|\\.""")
_PART = re.compile(r""""[^"]*"|'[^']*'|[^.\s]+""")


def places(text: str) -> dict[Way, Place]:
    """Where each table and key of a TOML text stands. What stands inside of one line's value is not listed."""
    found: dict[Way, Place] = {}
    counts: dict[tuple[str, ...], int] = {}
    table: Way = ()
    inside = ""  # the quotes of a string over several lines that we are in
    for line, content in enumerate(text.split("\n"), start=1):
        if not inside:
            start = content[:LONGEST_KEY]
            if header := _HEADER.match(start):
                names = _parts(header["name"])
                table = names
                if header["open"] == "[[":
                    counts[names] = counts.get(names, -1) + 1
                    table = (*names, counts[names])
                found.setdefault(table, (line, header.start("open") + 1))
            elif key := _KEY.match(start):
                found.setdefault((*table, *_parts(key["name"])), (line, key.start("name") + 1))
        for quotes in re.findall(r'"""|\'\'\'', content):
            inside = "" if inside == quotes else inside or quotes
    return found


def _parts(name: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in _PART.findall(name))


@dataclass(frozen=True, eq=False)
class Section:
    """One table of a TOML file, read key by key.

    Attributes:
        path: the file.
        way: to this table from the top.
        values: what stands in it.
        places: of every key of the file.
    """

    path: Path
    way: Way
    values: Mapping[str, Any]
    places: Mapping[Way, Place]

    def fault(self, subject: str, key: str | None = None, **facts: Any) -> RecordingError:
        """An error at a key of this table, or at the table itself."""
        way = self.way if key is None else (*self.way, key)
        while way and way not in self.places:
            way = way[:-1]
        line, column = self.places.get(way, (1, 1))
        return RecordingError(subject, file=self.path, line=line, column=column, **facts)

    def only(self, *known: str) -> None:
        """Refuse keys that are not known.

        Raises:
            RecordingError: naming the known key that looks most like it.
        """
        for key in self.values:
            if key not in known:
                raise self.fault(f"unknown key {key!r}", key, hint=nearest(key, known, "keys"))

    def text(self, key: str, default: str | None = None) -> str:
        """A string that can be printed on one line; ``default`` where it is absent (None: it must be there).

        Raises:
            RecordingError: absent, of another type, or empty.
        """
        if key not in self.values and default is not None:
            return default
        value = self._value(key, "a text")
        if not isinstance(value, str) or not value.isprintable() or (not value.strip() and default is None):
            raise self.fault(key, key, expected="a text of one line in quotes", received=repr(value)[:60])
        return value

    def number(self, key: str, unit: str, *, zero: bool = False, sign: bool = False) -> float:
        """A finite number: positive, or also ``zero``, or of any ``sign``.

        Raises:
            RecordingError: absent, of another type, or out of range.
        """
        bound = "a number" if sign else f"a number, {'zero or more' if zero else 'more than zero'}"
        value = self._value(key, f"{bound} [{unit}]")
        if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < sys.float_info.max:
            result = float(value)
            if math.isfinite(result) and (sign or result > 0 or (zero and result == 0)):
                return result
        raise self.fault(key, key, expected=f"{bound} [{unit}]", received=repr(value)[:60])

    def angle(self, key: str) -> float:
        """A direction [rad], within a turn either way.

        Raises:
            RecordingError: absent, of another type, or out of range.
        """
        value = self.number(key, "rad", sign=True)
        if doubt := angle_doubt(value):
            raise self.fault(key, key, **doubt.facts)
        return value

    def section(self, key: str) -> Section:
        """The table ``[key]``.

        Raises:
            RecordingError: absent, or not a table.
        """
        value = self._value(key, f"a table [{key}]")
        if not isinstance(value, dict):
            raise self.fault(key, key, expected=f"one table [{key}]", received=_kind(value))
        return Section(self.path, (*self.way, key), value, self.places)

    def sections(self, key: str) -> tuple[Section, ...]:
        """The tables ``[[key]]``, at least one.

        Raises:
            RecordingError: absent, empty, or not an array of tables.
        """
        value = self._value(key, f"at least one table [[{key}]]")
        if not isinstance(value, list) or not value or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, key, expected=f"at least one table [[{key}]]", received=_kind(value))
        return tuple(Section(self.path, (*self.way, key, index), item, self.places) for index, item in enumerate(value))

    def _value(self, key: str, expected: str) -> Any:
        if key not in self.values:
            table = ".".join(str(part) for part in self.way if isinstance(part, str))
            raise self.fault(f"{key} is missing{f' in [{table}]' if table else ''}", expected=expected)
        return self.values[key]


def _kind(value: object) -> str:
    return "one table" if isinstance(value, dict) else "an array" if isinstance(value, list) else repr(value)[:60]


def read_document(path: Path) -> Section:
    """Read a TOML file.

    Raises:
        RecordingError: unreadable, or not TOML (with the line and column where it stops being so).
    """
    text = read_text(path, LARGEST_DOCUMENT)
    _check_depth(text, path)
    try:
        values = tomllib.loads(text)
    except RecursionError:
        raise RecordingError("not TOML: nested too deeply", file=path, line=1, column=1) from None
    except ValueError as error:  # tomllib's own error is one
        message, _, where = str(error).partition(" (at ")
        place = re.match(r"line (\d+), column (\d+)", where)
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1 if where else 1, 1)
        raise RecordingError(f"not TOML: {message}", file=path, line=line, column=column) from error
    return Section(path, (), values, places(text))


def _check_depth(text: str, path: Path) -> None:
    for line, content in enumerate(text.split("\n"), start=1):
        if len(content) > DEEPEST:
            bare = _STRING.sub("", content)
            if max(bare.count(mark) for mark in ".[{") > DEEPEST:
                expected = f"at most {DEEPEST} levels in a line"
                raise RecordingError("not TOML: nested too deeply", expected=expected, file=path, line=line, column=1)
