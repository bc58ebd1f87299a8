"""What a print is: one thing that recordings show without any model, in numbers, in a sentence and in a picture."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from hsr_pin.trajectory import Array

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
#: Probability that an interval covers, and that what is pointed to is no accident.
LEVEL = 0.95


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


class Estimate(NamedTuple):
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def certain(self) -> bool:
        """Whether the interval leaves out zero."""
        return self.low > 0 or self.high < 0


def mean_of(values: Sequence[float] | Array) -> Estimate:
    """Mean of independent values, by Student's t; of fewer than two nothing is certain."""
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    if not len(known):
        return Estimate(np.nan, -np.inf, np.inf)
    value = float(known.mean())
    if len(known) < 2:
        return Estimate(value, -np.inf, np.inf)
    reach = float(stdtrit(len(known) - 1, (1 + LEVEL) / 2) * known.std(ddof=1) / np.sqrt(len(known)))
    return Estimate(value, value - reach, value + reach)


def coefficients_of(design: Array, values: Array, clusters: Sequence[object]) -> tuple[Estimate, ...]:
    """Least squares of ``values`` (n,) on ``design`` (n, k); intervals by leaving out one cluster (trial) at a time.

    With hardly more clusters than coefficients, ten stretches of the values are left out instead.
    """
    groups = _groups(clusters, design.shape[1] + 2)
    count = int(groups.max()) + 1
    best = np.linalg.lstsq(design, values, rcond=None)[0]
    if count <= design.shape[1]:
        return tuple(Estimate(float(b), -np.inf, np.inf) for b in best)
    left = np.array([np.linalg.lstsq(design[groups != g], values[groups != g], rcond=None)[0] for g in range(count)])
    reach = _jackknife(left, design.shape[1])
    return tuple(Estimate(float(b), float(b - r), float(b + r)) for b, r in zip(best, reach, strict=True))


def slope_of(x: Array, values: Array, clusters: Sequence[object]) -> Estimate:
    """Slope of ``values`` (n,) over ``x`` (n,) that single odd values do not move (Theil and Sen); intervals as above."""

    def slope(kept: NDArray[np.bool_]) -> float:
        first, second = np.triu_indices(int(kept.sum()), 1)
        rise, run = (part[kept][second] - part[kept][first] for part in (values, x))
        order = np.argsort(rise / np.where(run == 0, 1e-12, run))  # each pair by its distance: near ones say little
        weight = np.cumsum(np.abs(run)[order])
        at = order[np.searchsorted(weight, weight[-1] / 2)]
        return float(rise[at] / run[at])

    groups = _groups(clusters, 6)
    best = slope(np.ones(len(values), dtype=bool))
    left = np.array([[slope(groups != g)] for g in range(int(groups.max()) + 1)])
    reach = float(_jackknife(left, 1)[0])
    return Estimate(best, best - reach, best + reach)


def _groups(clusters: Sequence[object], fewest: int) -> NDArray[np.intp]:
    """Number of the cluster of each value; of the stretch of values that it is in, ten at most, if there are too few clusters."""
    place = {name: number for number, name in enumerate(dict.fromkeys(clusters))}
    if len(place) >= fewest:
        return np.array([place[name] for name in clusters])
    return np.arange(len(clusters)) * min(10, len(clusters)) // len(clusters)


def _jackknife(left: Array, parameters: int) -> Array:
    """Half the interval of each of (k,) estimates, from what (g, k) leaving out one group each gives (Tukey 1958)."""
    count = len(left)
    error = np.sqrt((count - 1) / count * ((left - left.mean(axis=0)) ** 2).sum(axis=0))
    return np.asarray(stdtrit(count - parameters, (1 + LEVEL) / 2) * error)


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
