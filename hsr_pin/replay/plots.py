"""Pictures for paper and screen: tip paths, markers against time, error against time.

Matplotlib's objects only, no pyplot: nothing global is touched and no display is needed. Colours are Okabe and Ito's, which
colour-blind readers can tell apart; dashes and shapes tell in grey what colours tell, and dots what is measured.
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

#: Of runs: Okabe and Ito, Color Universal Design, 2008; without the yellow, which is too light for lines on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
#: Of markers, from the tip: the rest, where the first two mean simulated and measured.
MARKER_COLOURS = COLOURS[2:]

#: Dashes of curves, in the order of their colours, and shapes of their ends.
DASHES: tuple[Any, ...] = ("-", (0, (7, 2)), (0, (2, 1.5)), (0, (7, 2, 2, 2)), (0, (4, 1)), (0, (1, 1)), (0, (9, 2, 2, 2, 2, 2)))
SHAPES = ("o", "s", "^", "D", "v", "P", "X")

FORMATS = ("png", "pdf", "svg")

#: Characters of a text in a picture, at most.
LONGEST_TEXT = 80
#: Names side by side in a legend, and characters of each, at most.
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
#: Format -> where it says who made it.
_METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": GENERATOR},
    "pdf": {"Creator": GENERATOR},
    "svg": {"Creator": GENERATOR, "Date": None},
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
    _make_plain(figure)
    content = io.BytesIO()
    with matplotlib.rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)  # a box stands for it
        figure.savefig(content, format=kind, metadata=_METADATA[kind])
    write_bytes(path, content.getvalue())


def _make_plain(figure: Figure) -> None:
    """Let every text in a figure stand as it is: a name may hold any sign, dollars among them, and be of any length."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        text.set_parse_math(False)
        text.set_text(_cut(text.get_text(), LONGEST_TEXT))


def _cut(text: str, room: int) -> str:
    return text if len(text) <= room else f"{text[: room - 1]}…"


def tip_figure(runs: Sequence[Drawn]) -> Figure:
    """The tips' paths in the plane of bending, as the paper's Fig. 4: one colour per run, constant curvature for reference.

    In space there are two pictures, x-z and y-z, and no reference.
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
    """One run beside its measurement: tip paths, every marker against time, error against time.

    In space the paths are seen from the side to which the tip goes farther.
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
    """(n, 2) [m] x and z of the tip of an arm bent into a circular arc of its length, by angles (n,) [rad]."""
    model = build_model(arm)
    normal = np.cross(model.joint_axis, model.direction)
    half = np.asarray(bending)[:, None] / 2
    chord = arm.length * np.sinc(half / np.pi)
    tip = chord * (np.cos(half) * model.direction + np.sin(half) * normal)
    return np.asarray(tip[:, [0, 2]])


def _views(runs: Sequence[Drawn]) -> tuple[tuple[int, int], ...]:
    """Pairs of world axes, across and up."""
    return ((0, 2), (1, 2)) if any(run.arm.bending == "space" for run in runs) else ((0, 2),)


def _draw_paths(axes: Axes, runs: Sequence[Drawn], view: tuple[int, int], *, legend: bool) -> None:
    """Paths of the tips, and the arms at their ends, along two axes of the world."""
    shown_from = list(view)
    space = len(_views(runs)) > 1
    if not space:
        _draw_reference(axes, runs)
    # the shortest path on top: under the same arm, paths lie on each other for a good part
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
    """Where the tip of a constant-curvature arm can be, a little beyond what is reached; once for each kind of arm."""
    bent = np.concatenate([run.angles.sum(axis=1) for run in runs])
    low, high = min(-0.1, 1.4 * bent.min()), max(0.1, 1.4 * bent.max())
    kinds = {(run.arm.mount, run.arm.tilt, run.arm.length): run.arm for run in runs}
    for number, arm in enumerate(kinds.values()):
        arc = 1e3 * constant_curvature(arm, np.linspace(low, high, 200))
        label = "" if number else "tip of a constant-curvature arm"
        axes.plot(*arc.T, color="#777777", lw=1.0, ls=(0, (5, 3)), label=label, zorder=2.5)


def _backbone(run: Drawn) -> Array:
    """(n, 3) [m] the chain at the end of a run, from base to tip."""
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
