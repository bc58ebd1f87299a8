"""Figures of the report: the ladder, the candidates, the maps of the gap, and simulated against measured motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hsr_pin.diagnosis.indicators.indicator import Indicator
from hsr_pin.diagnosis.where import Map, Where
from hsr_pin.diagnosis.words import model_name, readable
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.estimates import number, ranked
from hsr_pin.report.inline_svg import ROLES, page_figure
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hsr_pin.diagnosis.result import Diagnosis

#: Largest number of candidates in their figure.
MOST_CANDIDATES = 14
#: Largest number of dots of one measured curve.
_DOTS = 300


def ladder_figure(diagnosis: Diagnosis) -> Figure:
    """Return a figure of the held-out error of each row of the ladder with its interval, down to the noise floor."""
    rungs = diagnosis.ladder
    at, values = np.arange(len(rungs)), np.array([1e3 * rung.rms for rung in rungs])
    reach = np.abs(1e3 * np.array([rung.interval for rung in rungs]) - values[:, None]).T
    length = diagnosis.experiment.dataset.length
    with page_figure(0.5 + 0.3 * len(rungs)) as figure:
        axes = figure.add_subplot()
        axes.barh(at, values, height=0.62, color=[ROLES["noise" if rung.floor else "bar"] for rung in rungs])
        axes.errorbar(values[:-1], at[:-1], xerr=reach[:, :-1], fmt="none", ecolor=ROLES["ink"], elinewidth=1, capsize=2.5)
        axes.axvline(values[-1], color=ROLES["noise"], lw=1, ls=(0, (4, 3)))
        for y, value, end in zip(at, values, values + reach[1], strict=True):
            axes.annotate(
                f"{number(value)} mm = {number(0.1 * value / length)} % of L",
                (end, y),
                (6, 0),
                textcoords="offset points",
                va="center",
            )
        axes.set_yticks(at, [readable([rung.name.partition(" (")[0]]) for rung in rungs])
        axes.set_xlim(0, 1.32 * float(np.max(values + reach[1])))
        axes.invert_yaxis()
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("RMS marker distance on held-out trials [mm]")
    return figure


def candidates_figure(diagnosis: Diagnosis) -> Figure:
    """Return a figure of the best fitted models, ordered by their error on held-out trials."""
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    assert diagnosis.search is not None
    shown = shown_candidates(diagnosis)
    best, noise = diagnosis.search.best.names, 1e3 * diagnosis.limits.noise
    named = {best, *diagnosis.verdict.alternatives}
    values = [1e3 * candidate.heldout_square**0.5 for candidate in shown]
    with page_figure(0.6 + 0.22 * len(shown)) as figure:
        axes = figure.add_subplot()
        start = max(noise, min(values) / 4)  # very small noise would compress the candidates' axis
        noise_label = "noise" if start == noise else f"noise: {number(noise)}"
        axes.axvline(noise, color=ROLES["noise"], lw=1, ls=(0, (4, 3)))
        axes.annotate(noise_label, (start, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points")
        for y, (candidate, value) in enumerate(zip(shown, values, strict=True)):
            chosen = candidate.names in named
            colour = ROLES["model"] if chosen else ROLES["faint"]
            axes.plot([start, value], [y, y], color=colour, lw=2.2 if chosen else 1.0)
            axes.plot(value, y, "o", color=colour, ms=6 if chosen else 4.5)
            axes.annotate(number(value), (value, y), (7, 0), textcoords="offset points", va="center")
        axes.set_xscale("log")
        axes.set_xlim(0.8 * min([start, *values]), 1.25 * max([start, *values]))
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_yticks(range(len(shown)), [model_name(candidate) for candidate in shown])
        axes.set_ylim(len(shown) - 0.4, -0.6)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("RMS marker distance on held-out trials [mm], logarithmic")
    return figure


def shown_candidates(diagnosis: Diagnosis) -> tuple[Candidate, ...]:
    """Return the best fitted models, including the model without effects."""
    if diagnosis.search is None:
        return ()
    order = ranked(diagnosis.search.candidates)
    base = [candidate for candidate in order[MOST_CANDIDATES - 1 :] if not candidate.names]
    return (*order[: MOST_CANDIDATES - len(base)], *base)


def where_figure(where: Where) -> Figure:
    """Return a figure of all maps of the gap as bars, with the level of noise."""
    maps = [where.arc_length, where.time, where.trials, *where.operating_range]
    rows = -(-len(maps) // 3)
    with page_figure(2.15 * rows) as figure:
        for number, chart in enumerate(maps):
            _draw_map(figure.add_subplot(rows, 3, number + 1), chart)
    return figure


def _draw_map(axes: Axes, chart: Map) -> None:
    at = np.arange(len(chart.bins))
    axes.bar(at, [part.value for part in chart.bins], width=0.74, color=ROLES["bar"])
    for x, part in zip(at, chart.bins, strict=True):
        axes.plot([x - 0.44, x + 0.44], [part.noise, part.noise], color=ROLES["noise"], lw=2)
    labels, unit = _short([part.label for part in chart.bins], chart)
    every = -(-len(at) // 12)
    axes.set_xticks(at[::every], labels[::every], fontsize=7.5)
    axes.tick_params(axis="x", length=0)
    if sum(map(len, labels[::every])) > 26:
        for text in axes.get_xticklabels():
            text.set(rotation=35, ha="right", rotation_mode="anchor")
    axes.grid(axis="y")
    axes.set_title(f"{chart.quantity}{unit}")
    axes.set_ylabel(f"{'torque' if chart.unit == 'N m' else 'distance'} [{chart.unit}]")


def _short(labels: Sequence[str], chart: Map) -> tuple[list[str], str]:
    """Return the labels without their common unit, and that unit for the title."""
    ends = {label.partition(" ")[2] for label in labels}
    if chart.quantity in ("time", "trial") or len(ends) != 1 or "" in ends:
        return [label.replace("trial_", "") if chart.quantity == "trial" else label for label in labels], ""
    return [label.partition(" ")[0].replace("-", "\u2013") for label in labels], f" [{ends.pop()}]"


def motion_figure(diagnosis: Diagnosis, index: int) -> Figure:
    """Return a figure of one run with the declared and the best model: path, motion and error of the outermost marker."""
    from matplotlib.ticker import LogFormatter

    run = diagnosis.experiment.runs[index]
    tip = farthest_seen(run, diagnosis)
    models: list[tuple[str, str, Any, Array]] = [("declared model", "declared", (0, (5, 2)), diagnosis.nominal[index])]
    if diagnosis.search is not None:
        best = diagnosis.search.best
        models.append((f"with {model_name(best)}", "model", "-", best.heldout[index]))
    paths = [_gapless(run, missed, tip) for *_, missed in models]
    seen = run.compared[:: -(-len(run.instants) // _DOTS), tip]
    time = run.instants[:: -(-len(run.instants) // _DOTS)]
    axis = int(np.argmax(np.ptp(paths[-1], axis=0)))
    across = np.sort(np.argsort(np.ptp(paths[-1], axis=0))[-2:])  # the plane with the largest motion
    with page_figure(3.3) as figure:
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.35))
        plane, motion, error = (figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1]))
        for axes, x, y in ((plane, *seen[:, across].T), (motion, time, seen[:, axis])):
            scale = 1e3 if axes is plane else 1.0
            axes.plot(scale * x, 1e3 * y, ".", ms=6, mew=0, color=ROLES["measured"], label="measured")
        for (label, role, line, missed), path in zip(models, paths, strict=True):
            drawn: dict[str, Any] = {"color": ROLES[role], "ls": line, "lw": 1.3}
            plane.plot(*1e3 * path[:, across].T, label=label, **drawn)
            motion.plot(run.time, 1e3 * path[:, axis], **drawn)
            error.plot(run.instants, 1e3 * np.linalg.norm(missed[:, tip], axis=1), **{**drawn, "lw": 1.0, "ls": "-"})
        noise = 1e3 * len(run.axes) ** 0.5 * float(diagnosis.experiment.noise[tip])
        error.set_yscale("log")
        error.yaxis.set_major_formatter("{x:g}")
        error.yaxis.set_minor_formatter(LogFormatter())
        least = np.nanpercentile(np.linalg.norm(models[-1][-1][:, tip], axis=1), 5)
        error.set_ylim(bottom=max(0.2 * noise, 500 * float(least)))
        error.set_title(f"distance to the measurement (noise: {number(noise)} mm)")
        error.axhline(noise, color=ROLES["noise"], lw=1, ls=(0, (4, 3)))
        names = ["xyz"[k] for k in run.axes]
        title = "path in the plane of bending" if len(names) == 2 else "path"
        plane.set(xlabel=f"{names[across[0]]} [mm]", ylabel=f"{names[across[1]]} [mm]", title=title)
        _label(figure, (plane, motion, error), names[axis])
    return figure


def _label(figure: Figure, panels: tuple[Axes, Axes, Axes], axis: str) -> None:
    plane, motion, error = panels
    plane.set_aspect("equal", adjustable="datalim")
    motion.set(ylabel=f"{axis} [mm]", title=f"{axis} against time")
    motion.sharex(error)
    motion.tick_params(labelbottom=False)
    error.set(xlabel="time [s]", ylabel="distance [mm]")
    for axes in panels:
        axes.grid()
    handles, labels = plane.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(handles), markerscale=1.6)


def farthest_seen(run: Run, diagnosis: Diagnosis) -> int:
    """Return the index of the marker farthest from the base, among those that were visible for a good part of a run."""
    seen = np.isfinite(run.measured).all(axis=2).sum(axis=0)
    reach = [marker.arc_length for marker in diagnosis.experiment.markers]
    return int(np.argmax(np.where(seen >= seen.max() / 2, reach, -1.0)))


def _gapless(run: Run, missed: Array, marker: int) -> Array:
    """Return the predicted path (T, A) of one marker [m], interpolated across gaps of the measurement."""
    path = run.compared[:, marker] + missed[:, marker]
    seen = np.isfinite(path).all(axis=1)
    return np.stack([np.interp(run.time, run.instants[seen], column[seen]) for column in path.T], axis=1)


def indicator_figure(shown: Indicator) -> Figure:
    """Return the figure of one indicator."""
    with page_figure(2.4) as figure:
        shown.draw(figure.add_subplot())
    return figure
