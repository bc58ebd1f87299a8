"""TOML documents whose errors name the line and column of a value."""

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
from hsr_pin.recordings.plausible import implausible_angle
from hsr_pin.recordings.text import nearest, read_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # type: ignore[import-not-found,unused-ignore]

#: Path to a value through tables (names) and arrays of tables (indices).
KeyPath = tuple[str | int, ...]
#: Line and column, both counted from 1.
Place = tuple[int, int]

#: Number of characters of a line in which a key is searched.
LONGEST_KEY = 500
#: Largest number of parts of a key and of brackets in a line; the time and memory of the parser grow with their square.
DEEPEST = 64

# The matching time of each pattern is linear in the length of a line, because consecutive parts match different characters.
_HEADER = re.compile(r"\s*(?P<open>\[\[?)(?P<name>[^\[\]]+)\]")
_KEY = re.compile(r"""\s*(?P<name>(?=\S)(?:"[^"]*"|'[^']*'|[\w\-. \t])+)=""")
_STRING = re.compile(r""""(?:[^"\\]|\\.)*"|'[^']*'|#.*|\\.""")
_PART = re.compile(r""""[^"]*"|'[^']*'|[^.\s]+""")


def places(text: str) -> dict[KeyPath, Place]:
    """Return the line and column of each table and key of a TOML text, except for keys inside inline values."""
    found: dict[KeyPath, Place] = {}
    counts: dict[tuple[str, ...], int] = {}
    table: KeyPath = ()
    inside = ""  # quotes of the multi-line string that the current line is in
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
        key_path: path from the top of the file to this table.
        values: keys and values of the table.
        places: line and column of every key of the file.
    """

    path: Path
    key_path: KeyPath
    values: Mapping[str, Any]
    places: Mapping[KeyPath, Place]

    def fault(self, subject: str, key: str | None = None, **facts: Any) -> RecordingError:
        """Return an error at the position of a key of this table, or of the table itself."""
        key_path = self.key_path if key is None else (*self.key_path, key)
        while key_path and key_path not in self.places:
            key_path = key_path[:-1]
        line, column = self.places.get(key_path, (1, 1))
        return RecordingError(subject, file=self.path, line=line, column=column, **facts)

    def only(self, *known: str) -> None:
        """Check that the table has known keys only.

        Raises:
            RecordingError: a key is not known; the error names the most similar known key.
        """
        for key in self.values:
            if key not in known:
                raise self.fault(f"unknown key {key!r}", key, hint=nearest(key, known, "keys"))

    def text(self, key: str, default: str | None = None) -> str:
        """Return a printable one-line string; ``default`` if the key is absent (None: the key is required).

        Raises:
            RecordingError: the key is absent, or its value has another type or is empty.
        """
        if key not in self.values and default is not None:
            return default
        value = self._value(key, "a string")
        if not isinstance(value, str) or not value.isprintable() or (not value.strip() and default is None):
            raise self.fault(key, key, expected="a string of one line in quotes", received=repr(value)[:60])
        return value

    def number(self, key: str, unit: str, *, zero: bool = False, sign: bool = False) -> float:
        """Return a finite number that is positive, or also zero (``zero``), or of any sign (``sign``).

        Raises:
            RecordingError: the key is absent, or its value has another type or is out of range.
        """
        bound = "a number" if sign else f"a number, {'zero or more' if zero else 'more than zero'}"
        value = self._value(key, f"{bound} [{unit}]")
        if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < sys.float_info.max:
            result = float(value)
            if math.isfinite(result) and (sign or result > 0 or (zero and result == 0)):
                return result
        raise self.fault(key, key, expected=f"{bound} [{unit}]", received=repr(value)[:60])

    def angle(self, key: str) -> float:
        """Return an angle [rad] between minus one and plus one turn.

        Raises:
            RecordingError: the key is absent, or its value has another type or is out of range.
        """
        value = self.number(key, "rad", sign=True)
        if reason := implausible_angle(value):
            raise self.fault(key, key, **reason.facts)
        return value

    def section(self, key: str) -> Section:
        """Return the table ``[key]``.

        Raises:
            RecordingError: the key is absent, or is not a table.
        """
        value = self._value(key, f"a table [{key}]")
        if not isinstance(value, dict):
            raise self.fault(key, key, expected=f"one table [{key}]", received=_kind(value))
        return Section(self.path, (*self.key_path, key), value, self.places)

    def sections(self, key: str) -> tuple[Section, ...]:
        """Return the tables ``[[key]]``, of which at least one is required.

        Raises:
            RecordingError: the key is absent, or is empty or not an array of tables.
        """
        value = self._value(key, f"at least one table [[{key}]]")
        if not isinstance(value, list) or not value or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, key, expected=f"at least one table [[{key}]]", received=_kind(value))
        return tuple(Section(self.path, (*self.key_path, key, index), item, self.places) for index, item in enumerate(value))

    def _value(self, key: str, expected: str) -> Any:
        if key not in self.values:
            table = ".".join(str(part) for part in self.key_path if isinstance(part, str))
            raise self.fault(f"{key} is missing{f' in [{table}]' if table else ''}", expected=expected)
        return self.values[key]


def _kind(value: object) -> str:
    return "one table" if isinstance(value, dict) else "an array" if isinstance(value, list) else repr(value)[:60]


def read_document(path: Path) -> Section:
    """Read a TOML file.

    Raises:
        RecordingError: the file cannot be read, or is not valid TOML (with line and column of the first fault).
    """
    text = read_text(path, LARGEST_DOCUMENT)
    _check_depth(text, path)
    try:
        values = tomllib.loads(text)
    except RecursionError:
        raise RecordingError("invalid TOML: nested too deeply", file=path, line=1, column=1) from None
    except ValueError as error:  # includes tomllib.TOMLDecodeError
        message, _, where = str(error).partition(" (at ")
        place = re.match(r"line (\d+), column (\d+)", where)
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1 if where else 1, 1)
        raise RecordingError(f"invalid TOML: {message}", file=path, line=line, column=column) from error
    return Section(path, (), values, places(text))


def _check_depth(text: str, path: Path) -> None:
    for line, content in enumerate(text.split("\n"), start=1):
        if len(content) > DEEPEST:
            bare = _STRING.sub("", content)
            if max(bare.count(mark) for mark in ".[{") > DEEPEST:
                expected = f"at most {DEEPEST} brackets or key parts in a line"
                raise RecordingError("invalid TOML: nested too deeply", expected=expected, file=path, line=line, column=1)
