"""Lines of the table: what is compared, both results, and how many times as long the peer takes."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

HEADER = "| task | hsr_pin | peer | peer / hsr_pin | reach |\n|---|---|---|---|---|\n"
NOTHING = "-"


@dataclass(frozen=True)
class Title:
    """What a line compares.

    Attributes:
        task: what both do.
        peer: its name.
        module: that must be installed for it; empty: none.
        reach: what the last number of the line should be at least.
    """

    task: str
    peer: str
    module: str = ""
    reach: float | None = None

    @property
    def installed(self) -> bool:
        """Whether the peer is there."""
        return not self.module or find_spec(self.module) is not None


@dataclass(frozen=True)
class Row:
    """One line, measured.

    Attributes:
        title: what it compares.
        ours, theirs: results in words.
        ratio: of theirs to ours.
        above: the true ratio is larger: the peer was stopped.
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
    """A time [s] in a unit that suits it."""
    for factor, unit in ((1, "s"), (1e3, "ms"), (1e6, "µs")):
        if value * factor >= 1:
            return f"{value * factor:.3g} {unit}"
    return f"{1e6 * value:.2g} µs"
