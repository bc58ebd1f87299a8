"""What a print is: one thing that recordings show without any model, in numbers, in a sentence and in a picture."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.identification.jackknife import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: What a print may point to: kinds of physics, and what is no physics of the arm.
KINDS = (
    "elastic",
    "damping",
    "friction",
    "creep",
    "actuation_time",
    "actuation_map",
    "mass_gravity",
    "contact",
    "measurement",
)


@dataclass(frozen=True, eq=False)
class Print(ABC):
    """One print. A subclass holds the numbers; what they point to follows from them."""

    name: ClassVar[str]
    title: ClassVar[str]

    @property
    @abstractmethod
    def sentence(self) -> str:
        """One sentence: the numbers, and what they point to."""

    @property
    @abstractmethod
    def kinds(self) -> tuple[str, ...]:
        """Of :data:`KINDS`, those that it points to; none if all is as in the nominal arm."""

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """What was measured, as plain numbers and texts."""

    @abstractmethod
    def draw(self, axes: Axes) -> None:
        """Draw it, in the style of :func:`hsr_pin.diagnosis.inline_svg.drawing`."""

    def to_json(self) -> dict[str, Any]:
        """As ``json.dumps(..., allow_nan=False)`` takes it."""
        return {"name": self.name, "kinds": list(self.kinds), "sentence": self.sentence, **plain(self.numbers())}


def said(value: float) -> str:
    """A number in a sentence: two digits."""
    return (
        "?"
        if not np.isfinite(value)
        else "0"
        if value == 0
        else f"{value:#.2g}".rstrip(".")
        if abs(value) < 100
        else f"{value:.0f}"
    )


def counted(count: int, thing: str) -> str:
    """``1 step``, ``2 steps``."""
    return f"{count} {thing}{'s' * (count != 1)}"


def logarithmic(axes: Axes) -> None:
    """A logarithmic axis below, with plain numbers at 1, 2 and 5."""
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def plain(value: Any) -> Any:
    """Numbers, texts, lists and dictionaries only; what is not finite becomes None."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, Estimate):
        return {"value": plain(value.value), "ci95": [plain(value.low), plain(value.high)]}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    return value
