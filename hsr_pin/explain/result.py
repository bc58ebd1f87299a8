"""What an explanation found, and how it is shown in Python."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hsr_pin.explain.recordings import Recordings
from hsr_pin.explain.where import Map
from hsr_pin.inference.decision import Loss
from hsr_pin.inference.estimates import Estimate, estimates
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.search import Search
from hsr_pin.inference.verdict import HEADLINES, Limits, Verdict, Vocabulary
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """What a model of your own misses of recordings, and why.

    Distances are over the floor: what noise, and the truest of models, leave of a channel.

    Attributes:
        recordings: the trials beside the model.
        verdict: what may be said.
        ladder: how far each step shrinks the gap, on trials that it was not fitted to.
        search: every model that was tried.
        limits: what is too small to report.
        nominal: for each run (T, M, 1) predicted minus measured by the model as declared.
        where: maps of the gap that the fitted numbers leave.
        next_experiment: of the trials that were offered, the most telling first: name, and how far apart alternatives are in it.
        notes: what a reader should know of the recordings.
        loss: by which the report was chosen.
        words: how the verdict calls what it speaks of.
    """

    recordings: Recordings
    verdict: Verdict
    ladder: tuple[Rung, ...]
    search: Search
    limits: Limits
    nominal: tuple[Array, ...]
    where: tuple[Map, ...]
    next_experiment: tuple[tuple[str, float], ...] = ()
    notes: tuple[str, ...] = ()
    loss: Loss = field(default_factory=Loss)
    words: Vocabulary | None = None

    @property
    def headline(self) -> str:
        """What the verdict comes down to."""
        return (self.words.headlines if self.words else HEADLINES)[self.verdict.status]

    def __repr__(self) -> str:
        return f"<Explanation of {self.recordings.model.name}: {self.verdict.status}. {self.verdict.sentence}>"

    def __str__(self) -> str:
        rungs = [f"{rung.name:<44} {rung.rms:9.3g} {100 * rung.share:7.1f} %" for rung in self.ladder]
        lines = [f"{self.recordings.model.name}: {self.headline}", self.verdict.sentence, ""]
        lines += [f"{'error on trials it was not fitted to':<44} {'[floors]':>9} {'of gap²':>9}", *rungs, ""]
        return "\n".join([*lines, *map(str, self.estimates)])

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """The numbers of the most probable model, with their 95 % intervals."""
        return estimates(self.search.best.fit)

    @property
    def values(self) -> dict[str, float]:
        """All values of the most probable model by name, as the model's function takes them."""
        best = self.search.best.fit
        named: dict[str, float] = best.hypothesis.named(best.values)
        return named

    def to_json(self) -> dict[str, Any]:
        """The explanation in plain numbers and texts."""
        from hsr_pin.explain.document import to_json

        return to_json(self)

    def to_html(self, path: str | Path) -> None:
        """Write the report into one self-contained HTML file.

        Raises:
            OutputError: the file cannot be written.
        """
        from hsr_pin.explain.report import write_report

        write_report(self, path)

    def _repr_html_(self) -> str:
        title = html.escape(f"{self.recordings.model.name}: {self.headline}")
        rows = "".join(
            f"<tr><td>{html.escape(rung.name)}</td><td>{rung.rms:.3g}</td><td>{100 * rung.share:.1f} %</td></tr>"
            for rung in self.ladder
        )
        columns = "<tr><th>model</th><th>RMS [floors]</th><th>share of the squared gap</th></tr>"
        return f"<h4>{title}</h4><p>{html.escape(self.verdict.sentence)}</p><table>{columns}{rows}</table>"
