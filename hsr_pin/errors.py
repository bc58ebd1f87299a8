"""Error classes of hsr_pin, all derived from :class:`HsrError`.

The message of an error is one line: the place, what was expected, what was received and what to try. The error keeps these facts
as attributes, so that a program can read them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

#: Largest number of characters that a message quotes of one name, value or path, and of a list of names.
LONGEST_QUOTE, LONGEST_LIST = 200, 1000
#: Pattern of a name in a message: a quoted text or a word.
_NAME = re.compile(r"""'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|\S+""", re.DOTALL)


def printable(text: str) -> str:
    """Return a text with control characters and undecodable bytes escaped, so that a terminal can show it; line breaks stay."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode("ascii") for c in text)


def one_line(text: object) -> str:
    """Return any object as one printable line in which long names are shortened."""
    line = printable(" ".join(_text(text).split()))
    return line if len(line) <= LONGEST_QUOTE else _cut(_NAME.sub(lambda name: _cut(name[0]), line), LONGEST_LIST)


def quoted(value: object) -> str:
    """Return the ``repr`` of a value, shortened for an error message."""
    try:
        return _cut(" ".join(repr(value).split()))
    except ValueError:  # Python refuses to write out an integer of too many digits
        return f"a very large {type(value).__name__}"


def _text(value: object) -> str:
    """Return the ``str`` of a value, or a substitute for an integer of too many digits."""
    try:
        return str(value)
    except ValueError:  # Python refuses to write out an integer of too many digits
        return f"a very large {type(value).__name__}"


def _cut(text: str, room: int = LONGEST_QUOTE) -> str:
    """Return a text, without its middle if it is longer than ``room`` characters."""
    return text if len(text) <= room else f"{text[: room - 41]}…{text[-40:]}"


class HsrError(Exception):
    """Base class of all errors of hsr_pin; a command prints such an error as one line and exits with code 2."""

    def __reduce__(self) -> tuple[Any, ...]:  # keeps the attributes of an error from a worker process
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[HsrError], arguments: tuple[Any, ...], facts: dict[str, Any]) -> HsrError:
    """Return an unpickled error of a class with its arguments and attributes."""
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(facts)
    return error


class InputError(HsrError, ValueError):
    """A value given by the user is invalid.

    Args:
        subject: the quantity or option that is wrong, in a few words (``"links"``).
        expected: description of valid values (``"a whole number from 1 to 1000"``).
        received: the value that was given.
        hint: what to try.
        file, line, column: position of the value if it was read from a file (line and column are counted from 1).
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
        """Return the one-line message built from the attributes."""
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
    """A quantity of the arm is outside its valid range."""


class UrdfError(InputError):
    """A file is not a URDF file, or was not written by hsr_pin."""


class PressureError(InputError):
    """Pressures, a stiffness or a bending angle are outside the range of the pressure map."""


class EffectError(InputError):
    """An effect is unknown, or a parameter of an effect is outside its bounds."""


class RecordingError(InputError):
    """A dataset, or a file to import, violates its format."""


class IdentificationError(InputError):
    """A fit or a diagnosis cannot be started with the given data or options."""


class OutputError(InputError):
    """A file cannot be written."""


class MissingDependencyError(HsrError, ImportError):
    """An optional package is not installed; the message names the dependency group that contains it."""

    def __init__(self, package: str, group: str) -> None:
        self.package, self.group = package, group
        command = f"python3 scripts/install.py {group}, or pip install 'hsr_pin[{group}]'" if group else f"pip install {package}"
        super().__init__(f"{package} is not installed; it comes with {command}")


class WorkerError(HsrError, RuntimeError):
    """Worker processes ended unexpectedly several times in a row."""

    def __init__(self, tries: int) -> None:
        self.tries = tries
        super().__init__(
            f"worker processes ended {tries} times in a row before their work was done; try --jobs 1 (jobs=1), which uses none"
        )


class SimulationFailure(HsrError, RuntimeError):
    """A simulation stopped early; the error carries the partial result.

    Attributes:
        result: the ``SimulationResult`` up to the failure (its ``outcome`` names the reason).
    """

    def __init__(self, message: str, result: Any) -> None:
        self.result = result
        super().__init__(message)
