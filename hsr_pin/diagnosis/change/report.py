"""A diagnosis of changes as one self-contained HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from markupsafe import Markup

from hsr_pin.diagnosis.change import figures
from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis
from hsr_pin.diagnosis.change.history import History
from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.words import HEADLINES, advice, rounded
from hsr_pin.diagnosis.words import EXPERIMENTS, readable, sentence
from hsr_pin.inference.estimates import number
from hsr_pin.output import write_text
from hsr_pin.report.inline_svg import inline
from hsr_pin.report.page import environment


def write_report(history: History, path: str | Path) -> None:
    """Write the HTML report to a file: the last session compared with the first, and an overview of more than two sessions.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, report(history))


def report(history: History) -> str:
    """Return the HTML report as text."""
    diagnosis = history.diagnoses[-1]
    verdict, pair, reference = diagnosis.verdict, diagnosis.pair, diagnosis.reference
    return (
        environment(Path(__file__).parent)
        .get_template("report.html.jinja")
        .render(
            history=history,
            diagnosis=diagnosis,
            verdict=verdict,
            old=pair.old.dataset,
            new=pair.new.dataset,
            headline=HEADLINES[verdict.status],
            sentence=sentence(verdict.sentence),
            advice=advice(diagnosis),
            experiments=EXPERIMENTS,
            sizes=[_size(each) for each in verdict.changes],
            limits=[f"{name} {number(value)}" for name, value in sorted(verdict.limits.items())],
            reference="nothing" if reference is None else readable(reference.names) or "stiffness and damping",
            notes=[*pair.old.notes, *pair.new.notes],
            **_figures(history, diagnosis),
        )
    )


def _size(size: Size) -> dict[str, str]:
    span = size.becomes
    return {
        "name": size.parameter,
        "before": "" if size.before is None else rounded(size.before, span),
        "after": rounded(size.after, span),
        "becomes": f"{rounded(span[0], span)} to {rounded(span[1], span)}",
        "step": "" if size.step is None else f"{rounded(size.step[0], size.step)} to {rounded(size.step[1], size.step)}",
        "unit": "" if size.unit == "1" else size.unit,
    }


def _figures(history: History, diagnosis: ChangeDiagnosis) -> dict[str, Any]:
    found = diagnosis.found
    motions = []
    for k, caption in figures.shown_trials(diagnosis):
        motions.append((caption, Markup(inline(figures.motion_figure(diagnosis, k), f"motion{k}", caption))))
    gains = found and Markup(inline(figures.gains_figure(found), "gains", "What each change explains"))
    several = len(history.names) > 2
    sessions = several and Markup(inline(figures.sessions_figure(history), "sessions", "Every quantity over the sessions"))
    return {"motions": motions, "gains_svg": gains, "sessions_svg": sessions}
