"""Every error that hsr_pin raises on purpose, under one root.

An error says in one line where it is, what was expected, what came instead and what to try; it keeps these facts as attributes,
so that a program can read them too.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

#: No more characters of a name, a value or a path than this are quoted, and of a list of names.
LONGEST_QUOTE, LONGEST_LIST = 200, 1000
#: What may be a name: something in quotes, or a word.
_NAME = re.compile(r"""'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|\S+""", re.DOTALL)


def printable(text: str) -> str:
    """A text of one or more lines as a terminal can show it: control characters, and bytes that are no text, are escaped."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode("ascii") for c in text)


def one_line(text: object) -> str:
    """Anything as one printable line, in which long names are cut."""
    line = printable(" ".join(_text(text).split()))
    return line if len(line) <= LONGEST_QUOTE else _cut(_NAME.sub(lambda name: _cut(name[0]), line), LONGEST_LIST)


def quoted(value: object) -> str:
    """A value as Python writes it, cut to what an error line has room for."""
    try:
        return _cut(" ".join(repr(value).split()))
    except ValueError:  # an integer of too many digits to be written out
        return f"a very large {type(value).__name__}"


def _text(value: object) -> str:
    try:
        return str(value)
    except ValueError:  # as above
        return f"a very large {type(value).__name__}"


def _cut(text: str, room: int = LONGEST_QUOTE) -> str:
    """The beginning and the end of a long text."""
    return text if len(text) <= room else f"{text[: room - 41]}…{text[-40:]}"


class HsrError(Exception):
    """Root of all errors of hsr_pin. Commands print it as one line and exit with code 2."""

    def __reduce__(self) -> tuple[Any, ...]:  # what is raised in a worker arrives as it was, whatever it takes to make one
        return _as_it_was, (type(self), self.args, self.__dict__)


def _as_it_was(kind: type[HsrError], arguments: tuple[Any, ...], facts: dict[str, Any]) -> HsrError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(facts)
    return error


class InputError(HsrError, ValueError):
    """A value given by the user is not one that can be used.

    Args:
        subject: what is wrong, in a few words (``"links"``).
        expected: what would have been right (``"a whole number from 1 to 1000"``).
        received: what came.
        hint: what to try.
        file, line, column: where the value stands, where it came from a file (both counted from 1).
    """

    def __init__(
        self,
        subject: str,
        *,
        expected: str = "",
        received: Any = None,
        hint: str = "",
        file: str | Path | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        self.subject, self.expected, self.received, self.hint = subject, expected, received, hint
        self.file, self.line, self.column = file, line, column
        super().__init__(self._message())

    def _message(self) -> str:
        file = None if self.file is None else _cut(one_line(self.file))
        where = ":".join(str(part) for part in (file, self.line, self.column) if part is not None)
        text = f"{where}: {one_line(self.subject)}" if where else one_line(self.subject)
        if self.expected:
            text += f": expected {one_line(self.expected)}"
        if self.received is not None:
            text += f"{',' if self.expected else ':'} got {_cut(one_line(self.received))}"
        if self.hint:
            text += f"; {one_line(self.hint)}"
        return text


class SpecificationError(InputError):
    """A quantity of the arm is outside of what an arm can be."""


class UrdfError(InputError):
    """A file is not a URDF, or not one that hsr_pin wrote."""


class PressureError(InputError):
    """Pressures, stiffness or bending outside of the pressure map."""


class EffectError(InputError):
    """An unknown effect, or a parameter of an effect out of its bounds."""


class RecordingError(InputError):
    """A dataset, or a file to import, is not what its format demands."""


class IdentificationError(InputError):
    """A fit or a diagnosis cannot be started with what was given."""


class OutputError(InputError):
    """A file cannot be written."""


class MissingDependencyError(HsrError, ImportError):
    """An optional package is not installed; the message names the dependency group that brings it."""

    def __init__(self, package: str, group: str) -> None:
        self.package, self.group = package, group
        command = f"python3 scripts/install.py {group}, or pip install 'hsr_pin[{group}]'" if group else f"pip install {package}"
        super().__init__(f"{package} is not installed; it comes with {command}")


class WorkerError(HsrError, RuntimeError):
    """Worker processes were lost again and again."""

    def __init__(self, tries: int) -> None:
        self.tries = tries
        super().__init__(
            f"worker processes ended {tries} times in a row before their work was done; try --jobs 1 (jobs=1), which needs none"
        )


class SimulationFailure(HsrError, RuntimeError):
    """A simulation ended before its time. Carries the partial answer.

    Attributes:
        result: the ``SimulationResult`` up to the failure (its ``outcome`` names the reason).
    """

    def __init__(self, message: str, result: Any) -> None:
        self.result = result
        super().__init__(message)
