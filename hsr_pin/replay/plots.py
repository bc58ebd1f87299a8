"""Pictures for paper and screen: tip paths, markers against time, error against time.

Matplotlib's objects only, no pyplot: nothing global is touched and no display is needed. Colours are Okabe and Ito's, which
colour-blind readers can tell apart; what is measured is told from what is simulated by line and dots, not by colour alone.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np

from hsr_pin.errors import OutputError
from hsr_pin.output import write_bytes
from hsr_pin.replay.drawn import Drawn
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Okabe and Ito, Color Universal Design, 2008; without the yellow, which is too light for lines on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")

FORMATS = ("png", "pdf", "svg")

_STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.6,
    "savefig.dpi": 200,
    "svg.hashsalt": "hsr_pin",
}


def picture_format(path: str | Path) -> str:
    """The format that a file's name asks for.

    Raises:
        OutputError: none that is known.
    """
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise OutputError("picture", expected=f"a name ending in {', '.join('.' + f for f in FORMATS)}", received=str(path))
    return suffix


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure whole or not at all, as the name's ending says.

    Raises:
        OutputError: an unknown ending, or the file cannot be written.
    """
    kind = picture_format(path)
    content = io.BytesIO()
    with matplotlib.rc_context(_STYLE):
        figure.savefig(content, format=kind, metadata={"Date": None} if kind == "svg" else None)
    write_bytes(path, content.getvalue())


def tip_figure(runs: Sequence[Drawn]) -> Figure:
    """The tips' paths in the plane of bending, as the paper's Fig. 4: one colour per run, constant curvature for reference."""
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(5.6, 5.2), layout="constrained")
        _draw_paths(figure.add_subplot(), runs)
    return figure


def comparison_figure(run: Drawn) -> Figure:
    """One run beside its measurement: tip paths, every marker against time, error against time."""
    from matplotlib.figure import Figure

    markers = [marker.name for marker in run.simulated.markers if marker.arc_length > 0]
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(10.0, 6.4), layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.15))
        _draw_paths(figure.add_subplot(grid[:, 0]), [run])
        first = figure.add_subplot(grid[0, 1])
        second = figure.add_subplot(grid[1, 1], sharex=first)
        third = figure.add_subplot(grid[2, 1], sharex=first)
        _draw_motion(first, run, markers, axis=0)
        _draw_motion(second, run, markers, axis=2)
        _draw_error(third, run)
        for axes in (first, second):
            axes.tick_params(labelbottom=False)
        third.set_xlabel("time [s]")
        figure.suptitle(run.label, fontsize=10)
    return figure


def constant_curvature(arm: ArmSpecification, bending: Array) -> Array:
    """(n, 2) [m] x and z of the tip of an arm bent into a circular arc of its length, by angles (n,) [rad]."""
    model = build_model(arm)
    normal = np.cross(model.joint_axis, model.direction)
    half = np.asarray(bending)[:, None] / 2
    chord = arm.length * np.sinc(half / np.pi)
    tip = chord * (np.cos(half) * model.direction + np.sin(half) * normal)
    return np.asarray(tip[:, [0, 2]])


def _draw_paths(axes: Axes, runs: Sequence[Drawn]) -> None:
    arms = list(dict.fromkeys((run.arm.mount, run.arm.tilt, run.arm.length) for run in runs))
    bent = np.concatenate([run.angles.sum(axis=1) for run in runs])
    low, high = min(0.0, 1.1 * bent.min()), max(0.0, 1.1 * bent.max())
    if high - low < 0.2:
        low, high = low - 0.2, high + 0.2
    for number, (mount, tilt, length) in enumerate(arms):
        arm = next(run.arm for run in runs if (run.arm.mount, run.arm.tilt, run.arm.length) == (mount, tilt, length))
        arc = 1e3 * constant_curvature(arm, np.linspace(low, high, 200))
        axes.plot(*arc.T, color="#888888", lw=1.0, ls=(0, (5, 3)), label="" if number else "constant curvature", zorder=1)
    for run, colour in zip(runs, _cycle(len(runs)), strict=True):
        path = 1e3 * run.simulated.marker(run.tip.name)[:, [0, 2]]
        alone = len(runs) == 1 and run.measured is not None
        axes.plot(*path.T, color=colour, label="simulated" if alone else run.label, zorder=3)
        axes.plot(*path[-1], "o", color=colour, ms=5, zorder=4)
        if run.measured is not None and run.tip in run.common:
            seen = 1e3 * run.measured.marker(run.tip.name)[:, [0, 2]]
            axes.plot(
                *seen.T,
                ".",
                color=_measured_colour(alone, colour),
                ms=2.5,
                alpha=0.7,
                zorder=2,
                label="measured" if alone else "",
            )
    axes.plot(0, 0, "s", color="#444444", ms=7, zorder=2, label="base")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("z [mm]")
    axes.set_title("Path of the tip in the plane of bending")
    axes.legend(loc="best")


def _draw_motion(axes: Axes, run: Drawn, markers: Sequence[str], axis: int) -> None:
    for name, colour in zip(markers, _cycle(len(markers)), strict=True):
        if run.measured is not None and name in [marker.name for marker in run.common]:
            seen = run.measured.marker(name)[:, axis]
            axes.plot(run.measured.time, 1e3 * seen, ".", color=colour, ms=2.5, alpha=0.5)
        axes.plot(run.simulated.time, 1e3 * run.simulated.marker(name)[:, axis], color=colour, label=name, lw=1.2)
    axes.set_ylabel(f"{'xyz'[axis]} [mm]")
    if axis == 0:
        axes.set_title("Markers: simulated (lines), measured (dots)")
        axes.legend(loc="best", ncols=len(markers))


def _draw_error(axes: Axes, run: Drawn) -> None:
    names = [marker.name for marker in run.common if marker.arc_length > 0]
    for name, colour in zip(names, _cycle(len(names)), strict=True):
        assert run.measured is not None
        axes.plot(run.measured.time, 1e3 * run.gap(name), color=colour, label=name, lw=1.0)
    axes.set_ylabel("distance [mm]")
    axes.set_ylim(bottom=0)
    axes.set_title("Error: distance from simulated to measured")


def _measured_colour(alone: bool, colour: str) -> str:
    return COLOURS[1] if alone else colour


def _cycle(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]
