"""Printed comparison of simulation and measurement: a table, or a JSON object."""

from __future__ import annotations

import math
from typing import Any

from hsr_pin.identification.comparison import Comparison, MarkerError


def print_comparison(comparison: Comparison, trial: str | None = None) -> None:
    """Print the error of every marker for each trial and over all trials, in mm and in % of the arm's length.

    Args:
        comparison: comparison of the trials of a dataset.
        trial: name of the only trial to print; None: all trials.
    """
    from rich import box
    from rich.table import Table

    from hsr_pin.cli.console import console

    screen = console()
    dataset = comparison.experiment.dataset
    arm = comparison.trials[0].arm
    links = "1 link" if arm.links == 1 else f"{arm.links} links"
    screen.print(
        f"{dataset.name}: {links}, joints at {arm.placement}, {arm.mount}, L {1e3 * arm.length:g} mm",
        style="bold",
        soft_wrap=True,
    )
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), header_style="bold cyan")
    for column in ("trial\n", "marker\n"):
        table.add_column(column, no_wrap=True)
    for column in ("RMS\nmm", "RMS\n% of L", "95th pct.\nmm", "95th pct.\n% of L", "transient\nRMS, mm", "settled\nRMS, mm"):
        table.add_column(column, justify="right", no_wrap=True)
    chosen = [run for run in comparison.trials if trial in (None, run.name)]
    for run in chosen:
        for number, error in enumerate(_several(run.errors)):
            table.add_row("" if number else run.name, *_cells(error, arm.length))
    if trial is None and len(chosen) > 1:
        for number, error in enumerate(_several(comparison.errors)):
            table.add_row("" if number else "all trials", *_cells(error, arm.length), style="bold")
    screen.print(table)
    screen.print("distance from simulated to measured markers, means not aligned; a dash: no such part", style="dim")
    for note in comparison.experiment.notes:
        screen.print(f"note: {note}", style="yellow", soft_wrap=True)


def comparison_facts(comparison: Comparison, trial: str | None = None) -> dict[str, Any]:
    """Return the errors as a JSON object, in m; unknown values are null."""
    dataset = comparison.experiment.dataset
    return {
        "dataset": dataset.name,
        "unit": "m",
        "length": dataset.length,
        "trials": [
            {"trial": run.name, "keq": float(run.arm.keq), "damping": float(run.arm.damping), "errors": _facts(run.errors)}
            for run in comparison.trials
            if trial in (None, run.name)
        ],
        "errors": _facts(comparison.errors),
        "notes": list(comparison.experiment.notes),
    }


def _several(errors: tuple[MarkerError, ...]) -> tuple[MarkerError, ...]:
    """Return the errors to print: without the total over all markers if there is only one marker."""
    return errors[:-1] if len(errors) == 2 else errors


def _cells(error: MarkerError, length: float) -> list[str]:
    cells = [error.marker]
    for distance in (error.rms, error.p95):
        cells += [_number(1e3 * distance), _number(100 * distance / length)]
    return [*cells, _number(1e3 * error.transient), _number(1e3 * error.settled)]


def _number(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _facts(errors: tuple[MarkerError, ...]) -> list[dict[str, Any]]:
    return [
        {
            "marker": error.marker,
            **{
                name: value if math.isfinite(value := getattr(error, name)) else None
                for name in ("rms", "p95", "transient", "settled")
            },
        }
        for error in errors
    ]
