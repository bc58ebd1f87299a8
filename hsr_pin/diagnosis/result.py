"""The result of a diagnosis, and its display in Python."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hsr_pin.diagnosis.indicators.indicators import Indicators
from hsr_pin.diagnosis.next_experiment import Proposal
from hsr_pin.diagnosis.repeatability import Repeatability
from hsr_pin.diagnosis.where import Where
from hsr_pin.diagnosis.words import sentence
from hsr_pin.errors import MissingDependencyError
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.supply import Supply
from hsr_pin.inference import Loss
from hsr_pin.inference.estimates import number
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.search import Search
from hsr_pin.inference.verdict import Limits, Verdict, headline
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Result of a diagnosis.

    Attributes:
        experiment: the recordings as they were used.
        verdict: the conclusion.
        ladder: how much each step explains of the gap.
        search: all fitted models; None if the data were insufficient.
        limits: thresholds below which a gap is not reported.
        nominal: for each run (T, M, 3) predicted minus measured by the declared model [m].
        where: maps of the gap that fitted stiffness and damping leave; None if the data were insufficient.
        next_experiment: proposed experiments, the most informative first; empty if none is needed.
        indicators: model-free indicators of the recordings.
        repeatability: trial-to-trial repeatability; None if no trials repeat one another.
        supply: response of each measured input to its command, for channels that were recorded both as commanded and as measured.
        loss: gains and losses by which the report was chosen.
    """

    experiment: Experiment
    verdict: Verdict
    ladder: tuple[Rung, ...]
    search: Search | None
    limits: Limits
    nominal: tuple[Array, ...]
    where: Where | None = None
    next_experiment: tuple[Proposal, ...] = ()
    indicators: Indicators | None = None
    repeatability: Repeatability | None = None
    supply: tuple[Supply, ...] = ()
    loss: Loss = field(default_factory=Loss)

    def __repr__(self) -> str:
        return f"<Diagnosis of {self.experiment.dataset.name}: {self.verdict.status}. {self.verdict.sentence}>"

    def to_html(self, path: str | Path) -> None:
        """Write the report into one self-contained HTML file.

        Raises:
            OutputError: the file cannot be written.
        """
        from hsr_pin.diagnosis.report import write_report

        write_report(self, path)

    def to_json(self) -> dict[str, Any]:
        """Return the diagnosis as a dictionary of plain numbers and texts, which ``hsr-diagnose --json`` writes."""
        from hsr_pin.diagnosis.document import to_json

        return to_json(self)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(rung.name)}</td><td>{number(1e3 * rung.rms)}</td><td>{100 * rung.share:.1f} %</td></tr>"
            for rung in self.ladder
        )
        title = html.escape(f"{self.experiment.dataset.name}: {headline(self.verdict)}")
        conclusion = html.escape(sentence(self.verdict.sentence))
        columns = "<tr><th>model</th><th>RMS [mm]</th><th>share of the squared gap</th></tr>"
        return f"<h4>{title}</h4><p>{conclusion}</p><table>{columns}{rows}</table>"

    def plot(self) -> Figure:
        """Return a figure with the held-out error of each model and the probability of each set of causes."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        errors, causes = figure.subplots(1, 2)
        errors.barh([rung.name for rung in self.ladder], [1e3 * rung.rms for rung in self.ladder], color="#0072B2")
        errors.set_xlabel("RMS on held-out trials [mm]")
        sets = {} if self.search is None else self.search.posterior.sets
        shown = [(" + ".join(names) or "no cause", p) for names, p in sets.items()][:6]
        causes.barh([name for name, _ in shown], [p for _, p in shown], color="#D55E00")
        causes.set_xlabel("probability")
        causes.set_xlim(0, 1)
        for axes in (errors, causes):
            axes.invert_yaxis()
            axes.tick_params(labelsize=8)
        figure.suptitle(f"{self.experiment.dataset.name}: {headline(self.verdict)}", fontsize=10)
        return figure

    def to_dataframe(self) -> Any:
        """Return a pandas ``DataFrame`` with one row for each fitted model.

        The columns are causes, probability, heldout_rms [m], and the value of each parameter by its name.

        Raises:
            MissingDependencyError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise MissingDependencyError("pandas", "") from error
        models = zip(self.search.candidates, self.search.posterior.probabilities, strict=False) if self.search else ()
        rows = [
            {"causes": " + ".join(each.names), "probability": p, "heldout_rms": each.heldout_square**0.5, **each.fit.named}
            for each, p in models
        ]
        found = pandas.DataFrame(rows, columns=None if rows else ["causes", "probability", "heldout_rms"])
        return found.sort_values("probability", ascending=False, ignore_index=True)
