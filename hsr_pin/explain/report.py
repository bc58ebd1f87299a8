"""An explanation as one self-contained HTML file, without network access or scripts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from hsr_pin.explain.where import sentence
from hsr_pin.inference.estimates import estimates
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.output import write_text
from hsr_pin.report.inline_svg import ROLES, inline, page_figure
from hsr_pin.report.page import environment
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hsr_pin.explain.result import Explanation

#: Largest number of rows in the table of probabilities, and least probability that is listed.
_ROWS, _LISTED = 8, 0.01
#: Largest number of parts of a map in the report; larger maps are in the JSON document only.
_PARTS = 16
#: Largest number of channels that are drawn.
_DRAWN = 4


def write_report(found: Explanation, path: str | Path) -> None:
    """Write the HTML report of an explanation to a file.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, report(found))


def report(found: Explanation) -> str:
    """Return the HTML report of an explanation as text."""
    best = found.search.best
    sets = [(" + ".join(names), p) for names, p in found.search.posterior.sets.items() if p >= _LISTED][:_ROWS]
    index = int(np.argmax([_square(each) for each in found.nominal]))
    run = found.recordings.runs[index]
    caption = f"{run.name}, the trial with the largest error of the declared model"
    return (
        environment(Path(__file__).parent)
        .get_template("explanation.html.jinja")
        .render(
            found=found,
            model=found.recordings.model,
            verdict=found.verdict,
            headline=found.headline,
            sets=sets,
            causes=[found.recordings.model.cause(name) for name in _named_causes(found)],
            estimates=estimates(best.fit),
            doubts=uncertainty(best.fit).weak if len(best.fit.values) else (),
            where=sentence(found.where),
            maps=[each for each in found.where if len(each.parts) <= _PARTS],
            channels=_channels(found),
            caption=caption,
            motion=Markup(inline(_motion(found, index), "motion", caption)),
        )
    )


def _named_causes(found: Explanation) -> list[str]:
    """Return the causes that the verdict or the most probable model names, in the order of the model."""
    named = {*found.verdict.effects, *found.search.best.names, *(name for names in found.verdict.alternatives for name in names)}
    return [cause.name for cause in found.recordings.model.causes if cause.name in named]


def _channels(found: Explanation) -> list[dict[str, Any]]:
    """Return the errors of each channel with the declared, the fitted and the most probable model, in its unit."""
    recordings = found.recordings
    fitted = [found.search.base.heldout] if recordings.model.parameters else []
    shown = (found.nominal, *fitted, found.search.best.heldout)
    rows = []
    for m, (name, unit) in enumerate(zip(recordings.channels, recordings.units, strict=True)):
        errors = [unit * _square([each[:, m] for each in residuals]) ** 0.5 for residuals in shown]
        rows.append({"name": name, "unit": recordings.model.units.get(name, ""), "errors": errors, "floor": unit})
    return rows


def _motion(found: Explanation, index: int) -> Figure:
    """Return a figure of one trial: measured values and the predictions of the declared and the most probable model."""
    recordings, run = found.recordings, found.recordings.runs[index]
    best = found.search.best.heldout[index]
    channels = recordings.channels[:_DRAWN]
    with page_figure(0.4 + 1.3 * len(channels)) as figure:
        for m, axes in enumerate(figure.subplots(len(channels), 1, sharex=True, squeeze=False)[:, 0]):
            unit, measured = recordings.units[m], run.compared[:, m, 0]
            axes.plot(run.time, unit * measured, color=ROLES["measured"], lw=2.4, alpha=0.5, label="measured")
            axes.plot(
                run.time, unit * (measured + found.nominal[index][:, m, 0]), color=ROLES["declared"], label="declared model"
            )
            axes.plot(run.time, unit * (measured + best[:, m, 0]), color=ROLES["model"], label="most probable model")
            shown = recordings.model.units.get(channels[m], "")
            axes.set_ylabel(f"{channels[m]} [{shown}]" if shown else channels[m])
        figure.axes[0].legend(ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
        figure.axes[-1].set_xlabel("time [s]")
    return figure


def _square(residuals: Any) -> float:
    parts: list[Array] = [np.ravel(each) for each in residuals]
    return float(np.nanmean(np.concatenate(parts) ** 2))
