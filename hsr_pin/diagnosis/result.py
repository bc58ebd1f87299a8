"""What a diagnosis found, and how it is shown in Python."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hsr_pin.diagnosis.fingerprint.fingerprint import Fingerprint
from hsr_pin.diagnosis.next_experiment import Proposal
from hsr_pin.diagnosis.repeats import Repeats
from hsr_pin.diagnosis.where import Where
from hsr_pin.diagnosis.words import sentence
from hsr_pin.errors import MissingDependencyError
from hsr_pin.identification.experiment import Experiment
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
    """All that was found.

    Attributes:
        experiment: the recordings as they were used.
        verdict: what may be said.
        ladder: how far each step shrinks the gap.
        search: every model that was tried; None where there was too little to try any.
        limits: what is too small to report.
        nominal: for each run (T, M, 3) [m] predicted minus measured by the model as declared.
        where: maps of the gap that fitted stiffness and damping leave; None where there was too little to fit.
        next_experiment: what to record next, the most telling first; empty where the verdict needs no more.
        fingerprint: what the recordings show without a model.
        repeats: trial-to-trial repeatability; None where no trials repeat one another.
        loss: by which the report was chosen.
    """

    experiment: Experiment
    verdict: Verdict
    ladder: tuple[Rung, ...]
    search: Search | None
    limits: Limits
    nominal: tuple[Array, ...]
    where: Where | None = None
    next_experiment: tuple[Proposal, ...] = ()
    fingerprint: Fingerprint | None = None
    repeats: Repeats | None = None
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
        """The diagnosis in plain numbers and texts, as ``hsr-diagnose --json`` writes it."""
        from hsr_pin.diagnosis.document import to_json

        return to_json(self)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(rung.name)}</td><td>{number(1e3 * rung.rms)}</td><td>{100 * rung.share:.1f} %</td></tr>"
            for rung in self.ladder
        )
        title = html.escape(f"{self.experiment.dataset.name}: {headline(self.verdict)}")
        said = html.escape(sentence(self.verdict.sentence))
        columns = "<tr><th>model</th><th>RMS [mm]</th><th>share of the squared gap</th></tr>"
        return f"<h4>{title}</h4><p>{said}</p><table>{columns}{rows}</table>"

    def plot(self) -> Figure:
        """The error of each model on held-out trials, and the probability of each set of causes."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        errors, causes = figure.subplots(1, 2)
        errors.barh([rung.name for rung in self.ladder], [1e3 * rung.rms for rung in self.ladder], color="#0072B2")
        errors.set_xlabel("RMS on held-out trials [mm]")
        sets = {} if self.search is None else self.search.posterior.sets
        shown = [(" + ".join(names) or "none of these", p) for names, p in sets.items()][:6]
        causes.barh([name for name, _ in shown], [p for _, p in shown], color="#D55E00")
        causes.set_xlabel("probability")
        causes.set_xlim(0, 1)
        for axes in (errors, causes):
            axes.invert_yaxis()
            axes.tick_params(labelsize=8)
        figure.suptitle(f"{self.experiment.dataset.name}: {headline(self.verdict)}", fontsize=10)
        return figure

    def to_dataframe(self) -> Any:
        """A pandas ``DataFrame`` with a row for each fitted model.

        Columns: causes, probability, heldout_rms [m], and the value of each parameter by its name.

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
