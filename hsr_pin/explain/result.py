"""The explanation of a model's gap, and its display in Python."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hsr_pin.explain.recordings import Recordings
from hsr_pin.explain.where import Map
from hsr_pin.inference.decision import Loss
from hsr_pin.inference.detection import detection_sentence
from hsr_pin.inference.estimates import Estimate, estimates
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.search import Search
from hsr_pin.inference.verdict import HEADLINES, Limits, Verdict, Vocabulary
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False, repr=False)
class Explanation:
    """Explanation of the gap between a user-defined model and recordings.

    Distances are in floors; the floor of a channel combines its noise with the accuracy of the best possible model.

    Attributes:
        recordings: the trials together with the model.
        verdict: the conclusion.
        ladder: how much each step explains of the gap, on held-out trials.
        search: all models that were fitted.
        limits: thresholds below which a gap is not reported.
        nominal: for each run (T, M, 1) predicted minus measured by the declared model.
        where: maps of the gap that the fitted parameters leave.
        next_experiment: names of the proposed experiments and the distance between the alternatives in each, the largest first.
        notes: remarks on the recordings.
        loss: gains and losses by which the report was chosen.
        words: vocabulary of the verdict.
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
        """Headline of the verdict."""
        return (self.words.headlines if self.words else HEADLINES)[self.verdict.status]

    def __repr__(self) -> str:
        return f"<Explanation of {self.recordings.model.name}: {self.verdict.status}. {self.verdict.sentence}>"

    def __str__(self) -> str:
        rungs = [f"{rung.name:<44} {rung.rms:9.3g} {100 * rung.share:7.1f} %" for rung in self.ladder]
        lines = [f"{self.recordings.model.name}: {self.headline}", self.verdict.sentence, ""]
        lines += [f"{'error on held-out trials':<44} {'[floors]':>9} {'of gap²':>9}", *rungs, ""]
        limits = detection_sentence(self.search.detection)
        return "\n".join([*lines, *map(str, self.estimates), *["", limits] * bool(limits)])

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Parameters of the most probable model with their 95 % intervals."""
        return estimates(self.search.best.fit)

    @property
    def values(self) -> dict[str, float]:
        """All parameter values of the most probable model by name, as the model's function receives them."""
        best = self.search.best.fit
        named: dict[str, float] = best.hypothesis.named(best.values)
        return named

    def to_json(self) -> dict[str, Any]:
        """Return the explanation as a dictionary of plain numbers and texts."""
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
