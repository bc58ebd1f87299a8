"""Lines of the benchmark table: the task, both results, and the ratio of the peer's result to that of hsr_pin."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

HEADER = "| task | hsr_pin | peer | peer / hsr_pin | reach |\n|---|---|---|---|---|\n"
NOTHING = "-"


@dataclass(frozen=True)
class Title:
    """Definition of one comparison.

    Attributes:
        task: task that both carry out.
        peer: name of the peer.
        module: module that must be installed for the peer; empty: none.
        reach: smallest ratio of the results that is the target; None: no target.
    """

    task: str
    peer: str
    module: str = ""
    reach: float | None = None

    @property
    def installed(self) -> bool:
        """Whether the module of the peer is installed."""
        return not self.module or find_spec(self.module) is not None


@dataclass(frozen=True)
class Row:
    """One measured line.

    Attributes:
        title: definition of the comparison.
        ours, theirs: results as text.
        ratio: ratio of theirs to ours.
        above: whether the true ratio is larger, because the peer was stopped.
    """

    title: Title
    ours: str
    theirs: str = "not installed"
    ratio: float | None = None
    above: bool = False

    def __str__(self) -> str:
        title = self.title
        return f"| {title.task} | {self.ours} | {title.peer}: {self.theirs} | {self._ratio()} | {self._reach()} |\n"

    def _ratio(self) -> str:
        if self.ratio is None:
            return NOTHING
        number = f"{self.ratio:.2g}" if self.ratio < 99.5 else f"{self.ratio:.0f}"
        ahead = " (peer ahead)" if self.ratio < 1 and self.title.reach is None else ""
        return f"{'over ' if self.above else ''}{number}{ahead}"

    def _reach(self) -> str:
        if self.title.reach is None:
            return ""
        missed = " (missed)" if self.ratio is not None and self.ratio < self.title.reach else ""
        return f"{self.title.reach:g}{missed}"


def seconds(value: float) -> str:
    """Return a time [s] as text in a suitable unit."""
    for factor, unit in ((1, "s"), (1e3, "ms"), (1e6, "µs")):
        if value * factor >= 1:
            return f"{value * factor:.3g} {unit}"
    return f"{1e6 * value:.2g} µs"
