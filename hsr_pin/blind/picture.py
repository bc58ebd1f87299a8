"""The confusion matrix as a picture."""

from __future__ import annotations

from pathlib import Path

from hsr_pin.blind.plants.laws import CATALOGUE
from hsr_pin.blind.scoring import ALL, IN, RIGHT, SEVERAL, SOME, Score
from hsr_pin.replay.plots import save

#: Of verdicts: Okabe and Ito's green and vermilion, which colour-blind readers can tell apart, and grey.
COLOURS = {"right": "#009E73", "nameless": "#888888", "wrong": "#D55E00"}


def draw(score: Score, path: str | Path) -> None:
    """Write it to a .png, .pdf or .svg file: a row for each truth, a column for each verdict."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch, Rectangle

    shown = [k for k, counts in enumerate(score.counts) if sum(counts)]
    figure = Figure(figsize=(10.5, 2.8 + 0.27 * len(shown)), layout="constrained")
    axes = figure.add_subplot()
    for y, k in enumerate(shown):
        row, counts = score.rows[k], score.counts[k]
        for x, (column, count) in enumerate(zip(score.columns, counts, strict=True)):
            if count:
                depth = 0.25 + 0.75 * count / sum(counts)
                colour = COLOURS[meaning(row, column)]
                axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=colour, alpha=depth, linewidth=0))
                axes.text(x, y, str(count), ha="center", va="center", fontsize=9, color="white" if depth > 0.6 else "black")
    axes.set_xlim(-0.5, len(score.columns) - 0.5)
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xticks(range(len(score.columns)), score.columns, rotation=60, ha="left", rotation_mode="anchor", fontsize=8)
    axes.set_yticks(range(len(shown)), [f"{score.rows[k]}  ({sum(score.counts[k])})" for k in shown], fontsize=8)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.set_xticks([x + 0.5 for x in range(len(score.columns) - 1)], minor=True)
    axes.set_yticks([y + 0.5 for y in range(len(shown) - 1)], minor=True)
    axes.grid(which="minor", color="#DDDDDD", linewidth=0.6)
    axes.tick_params(which="minor", length=0)
    axes.set_ylabel("truth (cases)")
    labels = {"right": "right", "nameless": "too little said", "wrong": "wrong"}
    handles = [Patch(color=COLOURS[key], label=text) for key, text in labels.items()]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=3, frameon=False, fontsize=8)
    save(figure, path)


def meaning(row: str, column: str) -> str:
    """Whether a verdict is right, wrong, or names nothing: a key of `COLOURS`."""
    if column in (row, ALL, IN) or column in RIGHT.get(row, ()):
        return "right"
    return "wrong" if column in CATALOGUE or (column in SEVERAL and column != SOME) else "nameless"
