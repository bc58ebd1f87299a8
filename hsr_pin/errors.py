"""Every error that hsr_pin raises on purpose, under one root.

An error says in one line where it is, what was expected, what came instead and what to try; it keeps these facts as attributes,
so that a program can read them too.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any


class HsrError(Exception):
    """Root of all errors of hsr_pin. Commands print it as one line and exit with code 2."""


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
        where = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        text = f"{where}: {self.subject}" if where else self.subject
        if self.expected:
            text += f": expected {self.expected}"
        if self.received is not None:
            text += f"{',' if self.expected else ':'} got {self.received}"
        if self.hint:
            text += f"; {self.hint}"
        return " ".join(text.split())


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
        super().__init__(f"{package} is not installed; it comes with pip install 'hsr_pin[{group}]'")


class SimulationFailure(HsrError, RuntimeError):
    """A simulation ended before its time. Carries the partial answer.

    Attributes:
        result: the ``SimulationResult`` up to the failure (its ``outcome`` names the reason).
    """

    def __init__(self, message: str, result: Any) -> None:
        self.result = result
        super().__init__(message)
