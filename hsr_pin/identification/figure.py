"""Figure of the measured, declared and fitted motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hsr_pin.identification.prepared import Run
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hsr_pin.identification.identify import Identification

#: Largest number of trials; trials that were set aside come first.
MOST = 6
#: Colours of measured, declared and fitted motion, by Okabe and Ito, which colour-blind readers can distinguish.
_MEASURED, _DECLARED, _FITTED = "#D55E00", "#999999", "#0072B2"


def fit_figure(found: Identification) -> Figure:
    """Plot the farthest marker over time, in the coordinate in which it moves most, for up to six trials."""
    from matplotlib.figure import Figure

    shown = list(_shown(found))[:MOST]
    columns = 1 if len(shown) == 1 else 2
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(4.6 * columns, 0.6 + 2.1 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes, (title, run, before, after) in zip(grid.flat, shown, strict=False):
        _draw(axes, run, found.tip, before, after)
        axes.set_title(title, fontsize=9)
    for axes in list(grid.flat)[len(shown) :]:
        axes.set_visible(False)
    grid[0, 0].legend(loc="best", fontsize=8, frameon=False)
    figure.suptitle(f"{found.experiment.dataset.name}: marker {found.experiment.markers[found.tip].name}", fontsize=10)
    return figure


def _shown(found: Identification) -> Iterator[tuple[str, Run, Array, Array]]:
    """Yield title, run and the residuals of the declared and the fitted arm, first of trials that were set aside."""
    if found.set_aside:
        trials = zip(found.heldout_experiment.runs, found.heldout_before, found.heldout, strict=True)
        for run, before, after in trials:
            yield f"{run.trial.name}, predicted", run, before, after
    for run, before, after in zip(found.experiment.runs, found.before, found.after, strict=True):
        yield f"{run.trial.name}, fitted", run, before, after


def _draw(axes: Axes, run: Run, marker: int, before: Array, after: Array) -> None:
    measured = run.compared[:, marker]
    seen = measured[np.isfinite(measured).all(axis=1)]
    axis = int(np.argmax(np.ptp(seen, axis=0))) if len(seen) else 0
    axes.plot(run.instants, 1e3 * measured[:, axis], ".", color=_MEASURED, ms=2.5, label="measured")
    for missed, colour, dashes, label in ((before, _DECLARED, "--", "as declared"), (after, _FITTED, "-", "as fitted")):
        axes.plot(run.instants, 1e3 * (measured + missed[:, marker])[:, axis], color=colour, ls=dashes, lw=1.3, label=label)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"{'xyz'[run.axes[axis]]} [mm]")
    axes.grid(color="#DDDDDD", lw=0.6)
