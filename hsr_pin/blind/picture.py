"""Pictures of the confusion matrix and of the reliability of stated confidences."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from hsr_pin.blind.reliability import Reliability
from hsr_pin.blind.scoring import Score
from hsr_pin.replay.plots import save

#: Colours of verdicts: Okabe and Ito's green and vermilion, which colour-blind readers can distinguish, and grey.
COLOURS = {"right": "#009E73", "nameless": "#888888", "wrong": "#D55E00"}
#: Hatches of verdicts, which distinguish them in greyscale.
HATCHES = {"right": "", "nameless": "....", "wrong": "xxxx"}


def draw(score: Score, path: str | Path) -> None:
    """Write the confusion matrix to a .png, .pdf or .svg file: one row for each truth, one column for each verdict."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch, Rectangle

    meanings: dict[tuple[str, str], Counter[str]] = {}
    for outcome in score.outcomes:
        meanings.setdefault((outcome.row, outcome.column), Counter())[meaning(outcome.grade)] += 1
    shown = [k for k, counts in enumerate(score.counts) if sum(counts)]
    figure = Figure(figsize=(10.5, 2.8 + 0.27 * len(shown)), layout="constrained")
    axes = figure.add_subplot()
    for y, k in enumerate(shown):
        row, counts = score.rows[k], score.counts[k]
        for x, (column, count) in enumerate(zip(score.columns, counts, strict=True)):
            if count:
                depth = 0.25 + 0.75 * count / sum(counts)
                means = meanings[row, column].most_common(1)[0][0]
                cell = Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=COLOURS[means], edgecolor="#666666", alpha=depth)
                cell.set(linewidth=0, hatch=HATCHES[means])
                axes.add_patch(cell)
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
    labels = {"right": "right", "nameless": "incomplete or none", "wrong": "wrong"}
    handles = [Patch(facecolor=COLOURS[key], hatch=HATCHES[key], edgecolor="#666666", label=text) for key, text in labels.items()]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=3, frameon=False, fontsize=8)
    save(figure, path)


def meaning(grade: str) -> str:
    """Return whether a grade counts as right, wrong or without a name: a key of `COLOURS`."""
    return {"right": "right", "exact": "right", "alternatives": "right", "wrong": "wrong"}.get(grade, "nameless")


def draw_reliability(found: Reliability, path: str | Path) -> None:
    """Write the reliability diagram to a .png, .pdf or .svg file: share of right claims over stated confidence."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="#888888", linewidth=1, linestyle="--")
    for each in found.bins:
        low, high = each.right.interval
        axes.plot([each.stated] * 2, [low, high], color=COLOURS["right"], linewidth=1)
        axes.plot(each.stated, each.right.share, "o", color=COLOURS["right"], markersize=5)
        axes.annotate(str(each.right.of), (each.stated, each.right.share), (5, -9), textcoords="offset points", fontsize=7)
    low, high = found.interval
    axes.set_title(f"calibration error {found.error:.3f} ({low:.3f} to {high:.3f})", fontsize=9)
    axes.set(xlim=(0, 1.06), ylim=(0, 1.02), xlabel="stated confidence", ylabel="share that was right")
    save(figure, path)
