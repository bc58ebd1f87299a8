"""The base class of a model-free indicator: a result in numbers, in one sentence and in a figure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from hsr_pin.identification.jackknife import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Items = TypeVar("Items", tuple[Any, ...], list[Any], NDArray[np.float64])


@dataclass(frozen=True, eq=False)
class Indicator(ABC):
    """A model-free indicator; a subclass holds the numbers and derives the conclusions from them."""

    name: ClassVar[str]
    title: ClassVar[str]

    @property
    @abstractmethod
    def sentence(self) -> str:
        """One sentence with the numbers and the conclusion."""

    @property
    @abstractmethod
    def kinds(self) -> tuple[str, ...]:
        """Kinds of physics that it points to (:data:`hsr_pin.effects.effect.KINDS`); none if the arm behaves like the model."""

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return the measured values as plain numbers and texts."""

    @abstractmethod
    def draw(self, axes: Axes) -> None:
        """Draw the indicator in the style of :func:`hsr_pin.report.inline_svg.drawing`."""

    def to_json(self) -> dict[str, Any]:
        """Return plain numbers and texts for ``json.dumps(..., allow_nan=False)``."""
        return {"name": self.name, "kinds": list(self.kinds), "sentence": self.sentence, **jsonable(self.numbers())}


def rounded(value: float) -> str:
    """Return a number with two significant digits as text."""
    if not np.isfinite(value):
        return "?"
    if value == 0:
        return "0"
    return f"{value:#.2g}".rstrip(".") if abs(value) < 100 else f"{value:.0f}"


def rounded_range(low: float, high: float) -> str:
    """Return an interval with two significant digits as text, or one number if both ends look the same."""
    return rounded(low) if rounded(low) == rounded(high) else f"{rounded(low)} to {rounded(high)}"


def counted(count: int, thing: str) -> str:
    """Return a count with its noun: ``1 step``, ``2 steps``."""
    return f"{count} {thing}{'s' * (count != 1)}"


def thinned(items: Items, most: int) -> Items:
    """Return every n-th item, so that a figure shows at most ``most`` of them."""
    return items[:: max(1, -(-len(items) // most))]


def logarithmic(axes: Axes) -> None:
    """Make the horizontal axis logarithmic, with plain numbers at 1, 2 and 5."""
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def jsonable(value: Any) -> Any:
    """Return a value as numbers, texts, lists and dictionaries only; None for values that are not finite."""
    if isinstance(value, dict):
        return {key: jsonable(each) for key, each in value.items()}
    if isinstance(value, Estimate):
        return {"value": jsonable(value.value), "ci95": [jsonable(value.low), jsonable(value.high)]}
    if isinstance(value, np.ndarray | list | tuple):
        return [jsonable(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    return value
