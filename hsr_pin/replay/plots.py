"""Figures for print and screen: tip paths, markers over time, and errors over time.

The figures use Matplotlib's objects without pyplot, so that they change no global state and need no display. The colours are
those of Okabe and Ito, which colour-blind readers can distinguish. Dashes and shapes distinguish runs in greyscale, and dots
show measurements.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np

from hsr_pin.errors import OutputError
from hsr_pin.output import GENERATOR, write_bytes
from hsr_pin.replay.drawn import Drawn
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array, Marker

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Colours of runs: Okabe and Ito, Color Universal Design, 2008, without yellow, which is too light on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
#: Colours of markers, from the tip; the first two colours of runs stand for simulated and measured.
MARKER_COLOURS = COLOURS[2:]

#: Dashes of curves, in the order of their colours, and shapes of their end points.
DASHES: tuple[Any, ...] = ("-", (0, (7, 2)), (0, (2, 1.5)), (0, (7, 2, 2, 2)), (0, (4, 1)), (0, (1, 1)), (0, (9, 2, 2, 2, 2, 2)))
SHAPES = ("o", "s", "^", "D", "v", "P", "X")

FORMATS = ("png", "pdf", "svg")

#: Largest number of characters of a text in a figure.
LONGEST_TEXT = 80
#: Largest number of names in a row of a legend, and of characters of each name.
_ACROSS, _LONGEST_NAME = 6, 20

_STYLE: Any = {
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
#: Format -> metadata field for the creator.
_METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": GENERATOR},
    "pdf": {"Creator": GENERATOR},
    "svg": {"Creator": GENERATOR, "Date": None},
}


def picture_format(path: str | Path) -> str:
    """Return the picture format given by the ending of a file name.

    Raises:
        OutputError: the ending is not known.
    """
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise OutputError("picture", expected=f"a name ending in {', '.join('.' + f for f in FORMATS)}", received=str(path))
    return suffix


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure completely or not at all, in the format given by the ending of its name.

    Raises:
        OutputError: the ending is unknown, or the file cannot be written.
    """
    kind = picture_format(path)
    _make_plain(figure)
    content = io.BytesIO()
    with matplotlib.rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)  # a box is drawn instead
        figure.savefig(content, format=kind, metadata=_METADATA[kind])
    write_bytes(path, content.getvalue())


def _make_plain(figure: Figure) -> None:
    """Disable the interpretation of special characters in all texts of a figure, and shorten long texts."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        text.set_parse_math(False)
        text.set_text(_cut(text.get_text(), LONGEST_TEXT))


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 1]}…"


def tip_figure(runs: Sequence[Drawn]) -> Figure:
    """Return a figure of the tip paths in the plane of bending, like Fig. 4 of the paper, with a constant-curvature reference.

    In space there are two views, x-z and y-z, and no reference.
    """
    from matplotlib.figure import Figure

    views = _views(runs)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(5.6 if len(views) == 1 else 9.6, 5.2), layout="constrained")
        first = None
        for number, axes in enumerate(views):
            first = panel = figure.add_subplot(1, len(views), number + 1, sharey=first)
            _draw_paths(panel, runs, axes, legend=number == 0)
    return figure


def comparison_figure(run: Drawn) -> Figure:
    """Return a figure that compares a run with its measurement: tip paths, markers over time, and error over time.

    In space the paths are shown in the plane in which the tip moves farther.
    """
    from matplotlib.figure import Figure

    moving = sorted({axis for view in _views([run]) for axis in view})
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(10.0, 3.2 + 1.6 * len(moving)), layout="constrained")
        grid = figure.add_gridspec(len(moving) + 1, 2, width_ratios=(1.0, 1.15))
        ways = np.ptp(run.simulated.marker(run.tip.name), axis=0)
        _draw_paths(figure.add_subplot(grid[:, 0]), [run], max(_views([run]), key=lambda view: ways[view[0]]), legend=True)
        first = figure.add_subplot(grid[0, 1])
        others = [figure.add_subplot(grid[row + 1, 1], sharex=first) for row in range(len(moving))]
        for panel, axis in zip([first, *others], moving, strict=False):
            _draw_motion(panel, run, axis=axis)
            panel.tick_params(labelbottom=False)
        _draw_error(others[-1], run)
        others[-1].set_xlabel("time [s]")
        figure.suptitle(run.label, fontsize=10)
    return figure


def constant_curvature(arm: ArmSpecification, bending: Array) -> Array:
    """Return x and z (n, 2) [m] of the tip of an arm bent into a circular arc by angles (n,) [rad]."""
    model = build_model(arm)
    normal = np.cross(model.joint_axis, model.direction)
    half = np.asarray(bending)[:, None] / 2
    chord = arm.length * np.sinc(half / np.pi)
    tip = chord * (np.cos(half) * model.direction + np.sin(half) * normal)
    return np.asarray(tip[:, [0, 2]])


def _views(runs: Sequence[Drawn]) -> tuple[tuple[int, int], ...]:
    """Return pairs of world axes, horizontal and vertical, of the views to draw."""
    return ((0, 2), (1, 2)) if any(run.arm.bending == "space" for run in runs) else ((0, 2),)


def _draw_paths(axes: Axes, runs: Sequence[Drawn], view: tuple[int, int], *, legend: bool) -> None:
    """Draw the paths of the tips and the arms at the end of the runs, in a view along two axes of the world."""
    shown_from = list(view)
    space = len(_views(runs)) > 1
    if not space:
        _draw_reference(axes, runs)
    # the shortest path is drawn last, as paths of the same arm largely coincide
    order = np.argsort([-np.ptp(run.simulated.marker(run.tip.name), axis=0).max() for run in runs])
    colours = _cycle(len(runs))
    handles: dict[int, Any] = {}
    for layer, index in enumerate(order):
        run, colour, dashes, end = runs[index], colours[index], DASHES[index % len(DASHES)], SHAPES[index % len(SHAPES)]
        alone = len(runs) == 1 and run.measured is not None
        shape = 1e3 * _backbone(run)[:, shown_from]
        axes.plot(*shape.T, color=colour, lw=5.0, alpha=0.22, solid_capstyle="round", zorder=1.5)
        path = 1e3 * run.tip_path[:, shown_from]
        (handles[index],) = axes.plot(
            *path.T, color=colour, ls=dashes, marker=end, markevery=[-1], mec="white", ms=6, zorder=3 + layer,
            label="simulated" if alone else run.label,
        )  # fmt: skip
        if run.measured is not None and run.tip in run.common:
            seen = 1e3 * run.measured.marker(run.tip.name)[:, shown_from]
            dots = COLOURS[1] if alone else colour
            (handle,) = axes.plot(*seen.T, ".", color=dots, ms=2.5, alpha=0.7, zorder=2, label="measured" if alone else "")
            handles[len(runs)] = handle
    axes.plot(0, 0, "s", color="#444444", ms=8, zorder=2)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.07)
    axes.set_xlabel(f"{'xyz'[view[0]]} [mm]")
    axes.set_ylabel(f"{'xyz'[view[1]]} [mm]")
    where = "" if space else " in the plane of bending"
    axes.set_title(f"Path of the tip{where}, and the arm at its end", fontsize=9)
    shown, labels = axes.get_legend_handles_labels()
    rank = {handle: index for index, handle in handles.items()}
    entries = sorted(zip(shown, labels, strict=True), key=lambda entry: rank.get(entry[0], len(runs) + 1))
    if legend:
        axes.legend(*zip(*entries, strict=True), loc="best", handlelength=3.2)


def _draw_reference(axes: Axes, runs: Sequence[Drawn]) -> None:
    """Draw the possible tip positions of a constant-curvature arm, slightly beyond the reached ones, for each kind of arm."""
    bent = np.concatenate([run.angles.sum(axis=1) for run in runs])
    low, high = min(-0.1, 1.4 * bent.min()), max(0.1, 1.4 * bent.max())
    kinds = {(run.arm.mount, run.arm.tilt, run.arm.length): run.arm for run in runs}
    for number, arm in enumerate(kinds.values()):
        arc = 1e3 * constant_curvature(arm, np.linspace(low, high, 200))
        label = "" if number else "tip of a constant-curvature arm"
        axes.plot(*arc.T, color="#777777", lw=1.0, ls=(0, (5, 3)), label=label, zorder=2.5)


def _backbone(run: Drawn) -> Array:
    """Return the points (n, 3) [m] of the chain at the end of a run, from base to tip."""
    arm = run.arm
    bends = np.concatenate([[0.0], arm.joint_arc_lengths * arm.length, [arm.length]])
    if arm.bending == "space":
        return space_marker_map(arm, bends).positions(run.angles[-1].ravel())
    return marker_map(arm, bends).positions(run.angles[-1])


def _draw_motion(axes: Axes, run: Drawn, axis: int) -> None:
    markers = [marker for marker in run.simulated.markers if marker.arc_length > 0]
    lines: list[Any] = []
    for marker in markers:
        name, colour = marker.name, _marker_colour(run, marker)
        if run.measured is not None and marker in run.common:
            axes.plot(run.measured.time, 1e3 * run.measured.marker(name)[:, axis], ".", color=colour, ms=2.5, alpha=0.5)
        lines += axes.plot(
            run.simulated.time, 1e3 * run.simulated.marker(name)[:, axis], color=colour, ls=_marker_dashes(run, marker), lw=1.2
        )
    axes.set_ylabel(f"{'xyz'[axis]} [mm]")
    if axis == 0:
        axes.set_title("Markers: simulated (lines), measured (dots)")
        axes.legend(lines, [_cut(marker.name, _LONGEST_NAME) for marker in markers], loc="best", ncols=min(len(markers), _ACROSS))


def _draw_error(axes: Axes, run: Drawn) -> None:
    for marker in run.moving:
        assert run.measured is not None
        gap = 1e3 * run.gap(marker.name)
        axes.plot(run.measured.time, gap, color=_marker_colour(run, marker), ls=_marker_dashes(run, marker), lw=1.0)
    axes.set_ylabel("distance [mm]")
    axes.set_ylim(bottom=0)
    axes.set_title("Error: distance from simulated to measured")


def _marker_colour(run: Drawn, marker: Marker) -> str:
    return MARKER_COLOURS[_from_the_tip(run, marker) % len(MARKER_COLOURS)]


def _marker_dashes(run: Drawn, marker: Marker) -> Any:
    return DASHES[_from_the_tip(run, marker) % len(DASHES)]


def _from_the_tip(run: Drawn, marker: Marker) -> int:
    return sorted(run.simulated.markers, key=lambda other: -other.arc_length).index(marker)


def _cycle(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]
