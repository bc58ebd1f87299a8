"""Figures of a report on a change: gains of the hypotheses, changed motion, and all quantities over the sessions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis
from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.history import History
from hsr_pin.diagnosis.change.verdict import ChangeEvidence
from hsr_pin.diagnosis.words import readable
from hsr_pin.report.inline_svg import ROLES, page_figure
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Largest number of trials that are shown.
_SHOWN = 2


def gains_figure(found: ChangeEvidence) -> Figure:
    """Return a figure of how much each change explains, compared with the required gain."""
    fits = [fitted for fitted, _ in found.fits]
    at = np.arange(len(fits))
    gains = np.array([max(found.gain(fitted), 0.5) for fitted in fits])
    needed = np.full(len(fits), found.needed)
    with page_figure(0.6 + 0.3 * len(fits)) as figure:
        axes = figure.add_subplot()
        axes.barh(at, gains, height=0.62, color=ROLES["bar"])
        axes.plot(needed, at, "|", color=ROLES["declared"], ms=12, mew=2)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_yticks(at, [readable(fitted.change.names) for fitted in fits])
        axes.invert_yaxis()
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("drop of -2 log likelihood")
    return figure


def shown_trials(diagnosis: ChangeDiagnosis) -> list[tuple[int, str]]:
    """Return the trials of the current recording that are shown, with captions: those that the change affects most."""
    if diagnosis.found is None or not diagnosis.verdict.changes:
        return []
    moves = [float(np.mean(each**2)) for each in _named(diagnosis.found, diagnosis).moved]
    chosen = np.argsort(moves)[::-1][:_SHOWN]
    names = [diagnosis.pair.new.runs[k].trial.name for k in chosen]
    marker = diagnosis.pair.new.markers[_far(diagnosis)].name
    return [
        (int(k), f"{name}, marker {marker}: predicted influence of the change, and measured deviation")
        for k, name in zip(chosen, names, strict=True)
    ]


def motion_figure(diagnosis: ChangeDiagnosis, index: int) -> Figure:
    """Return a figure of one current trial: its deviation from the prediction, and the part that the change explains."""
    found, pair = diagnosis.found, diagnosis.pair
    assert found is not None
    fitted, marker = _named(found, diagnosis), _far(diagnosis)
    bins = pair.bins[len(pair.old.runs) + index]
    seen = _seen(found, marker, index)
    rows, columns = (1, 2) if len(seen) == 2 else (len(seen), 1)
    with page_figure(2.4 * rows) as figure:
        for axis, along in enumerate(pair.experiment.axes):
            axes = figure.add_subplot(rows, columns, axis + 1)
            shown = bins.counts[:, marker] > 0
            axes.plot(bins.time, 1e3 * seen[axis], ".", ms=3, color=ROLES["measured"], label="measured")
            axes.plot(
                bins.time[shown],
                1e3 * fitted.moved[index][shown, marker, axis],
                color=ROLES["model"],
                label="predicted by the change",
            )
            axes.axhline(0.0, color=ROLES["noise"], lw=1, ls=(0, (4, 3)))
            axes.set_xlabel("time [s]")
            axes.set_title(f"{'xyz'[along]}: deviation from the prediction of the first recording [mm]")
            if not axis:
                axes.legend(frameon=False, loc="best")
    return figure


def _named(found: ChangeEvidence, diagnosis: ChangeDiagnosis) -> Fitted:
    """Return the fit of the change that the verdict names first, with as few other changes as possible."""
    named = set(next(iter(diagnosis.verdict.alternatives), diagnosis.verdict.effects))
    return min((f for f, _ in found.fits if named <= set(f.change.names)), key=lambda f: len(f.change.names))


def _seen(found: ChangeEvidence, marker: int, index: int) -> Array:
    """Return the deviation (A, B) of a marker from the reference prediction in one run of the current recording [m]."""
    frame = found.frame
    answer = np.full((len(frame.pair.experiment.axes), len(frame.pair.bins[len(frame.pair.old.runs) + index].time)), np.nan)
    ends = np.cumsum([len(rows.run) for rows in frame.rows])[:-1]
    for rows, part in zip(frame.rows, np.split(frame.prediction_error, ends), strict=True):
        own = rows.run == index
        so_far = np.nan_to_num(answer[:, rows.place[own]])
        answer[:, rows.place[own]] = so_far - rows.mix[marker][:, None] * part[own]
    return answer


def _far(diagnosis: ChangeDiagnosis) -> int:
    return int(np.argmax([marker.arc_length for marker in diagnosis.pair.new.markers]))


def sessions_figure(history: History) -> Figure:
    """Return a figure of all quantities over the sessions."""
    at = np.arange(len(history.names))
    with page_figure(1.5 * len(history.quantities) + 0.4) as figure:
        panels = np.atleast_1d(figure.subplots(len(history.quantities), 1, sharex=True))
        for axes, quantity in zip(panels, history.quantities, strict=True):
            for k, point in zip(at, quantity.points, strict=True):
                colour = ROLES["declared"] if point.changed == "certain" else ROLES["model"]
                filled = colour if point.changed != "perhaps" else "none"
                if point.interval is not None:
                    axes.plot([k, k], point.interval, color=colour, lw=1.5)
                axes.plot([k], [point.value], "o", color=colour, mfc=filled, ms=5)
            axes.plot(at, [point.value for point in quantity.points], color=ROLES["grid"], lw=1, zorder=0)
            unit = "" if quantity.unit == "1" else f" [{quantity.unit}]"
            axes.set_title(f"{quantity.name}{unit}")
        panels[-1].set_xticks(at, history.names)
        panels[-1].set_xlim(-0.4, len(at) - 0.6)
    return figure
