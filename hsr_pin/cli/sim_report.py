"""Printed results of ``hsr-sim``: a table, or one JSON document."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import click

from hsr_pin.cli.sim_runs import Run
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.measures import BAND

#: Headings of the columns: a name in up to two lines, and the unit.
_COLUMNS = (
    "P1\n\nbar",
    "P2\n\nbar",
    "tau\n\nN m",
    "phi\n\nrad",
    "tip x\n\nmm",
    "tip z\n\nmm",
    "settling\ntime\ns",
    "over-\nshoot\n%",
    "off\ncircle\nmm",
)
#: Headings of the columns for an arm in space.
_IN_SPACE = ("tau\n\nN m", "towards\n\nrad", "phi\n\nrad", "tip x\n\nmm", "tip y\n\nmm", *_COLUMNS[5:], "off\nplane\nmm")


def print_table(runs: Sequence[Run], dynamics: str) -> None:
    """Print a table with one row for each run, explanations of the columns, and notes."""
    from rich import box
    from rich.table import Table

    from hsr_pin.cli.console import console

    screen = console()
    several = len({run.arm.keq for run in runs}) > 1
    screen.print(title(runs, dynamics), style="bold", soft_wrap=True)
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), header_style="bold cyan")
    columns = _COLUMNS if runs[0].direction is None else _IN_SPACE
    for column in ("Keq\n\nNm/rad", *columns) if several else columns:
        table.add_column(column, justify="right", no_wrap=True)
    for run in runs:
        table.add_row(*([f"{run.arm.keq:.4g}"] if several else []), *_cells(run))
    screen.print(table)
    for line in _footnotes(runs):
        screen.print(line, style="dim")
    for note in dict.fromkeys(note for run in runs for note in run.notes):
        screen.print(f"note: {note}", style="yellow", soft_wrap=True)


def print_json(runs: Sequence[Run], dynamics: str, written: Sequence[str]) -> None:
    """Print one JSON document in SI units (pressures in bar); unknown values are null."""
    document = {
        "command": "hsr-sim",
        "units": {"pressures": "bar", "angles": "rad", "lengths": "m", "times": "s", "torques": "N m"},
        "dynamics": dynamics,
        "runs": [_record(run) for run in runs],
        "written": list(written),
    }
    click.echo(json.dumps(document, indent=2, allow_nan=False))


def title(runs: Sequence[Run], dynamics: str) -> str:
    """Return one line with the properties that all runs share."""
    arm = runs[0].arm
    stiffness = "" if len({run.arm.keq for run in runs}) > 1 else f", Keq {arm.keq:.4g} Nm/rad, C {arm.damping:.4g} Nm s/rad"
    effects = "".join(f", {effect.name}" for effect in runs[0].effects)
    links = "1 link" if arm.links == 1 else f"{arm.links} links"
    obstacles = "" if not arm.obstacles else f", {len(arm.obstacles)} obstacle" + "s" * (len(arm.obstacles) > 1)
    space = ", in space" if arm.bending == "space" else ""
    return f"{links}{space}{stiffness}, {arm.mount}, joints at {arm.placement}, {dynamics.upper()}{obstacles}{effects}"


def _cells(run: Run) -> list[str]:
    measures, pressures = run.measures, run.pressures
    tip, bent = [f"{1e3 * part:.1f}" for part in (measures.x, measures.y, measures.z)], f"{run.torque / run.arm.keq:.3f}"
    if run.direction is None:
        cells = ["-", "-"] if pressures is None else [f"{p:.4f}" for p in pressures]
        cells += [f"{run.torque:.3f}", bent, tip[0], tip[2]]
    else:
        cells = [f"{run.torque:.3f}", f"{run.direction:.3f}", bent, *tip]
    cells.append("-" if measures.settling_time is None else f"{measures.settling_time:.3f}")
    cells.append("-" if measures.overshoot is None else f"{100 * measures.overshoot:.1f}")
    cells.append("-" if measures.circle is None else f"{1e3 * measures.circle.distance:.3f}")
    if measures.off_plane is not None:
        cells.append(f"{1e3 * measures.off_plane:.3f}")
    return cells


def _footnotes(runs: Sequence[Run]) -> list[str]:
    lines = [
        f"settling time: from the last command until the tip stays within {100 * BAND:g} % of its travel;",
        "off circle: RMS distance of the tip's path from the circle nearest to it",
    ]
    if not all(run.measures.settled for run in runs):
        lines.append("a dash under settling time: the arm did not settle within the run; try a longer --duration")
    if runs[0].direction is not None:
        lines[1] = (
            "off plane: RMS distance of the tip's path from the nearest plane; off circle: in that plane, from the nearest circle"
        )
    elif any(run.drive.pressures is None for run in runs):
        lines.append("P1, P2 with a given torque: pressures that produce this torque (a dash: there are none)")
    return lines


def _record(run: Run) -> dict[str, Any]:
    arm, measures = run.arm, run.measures
    circle = measures.circle
    return {
        "arm": {
            "links": arm.links,
            "keq": float(arm.keq),
            "damping": float(arm.damping),
            "placement": arm.placement,
            "mount": arm.mount,
            "length": float(arm.length),
            "mass": float(arm.mass),
            "diameter": float(arm.diameter),
            "tip_mass": float(arm.tip_mass),
            "tilt": float(arm.tilt),
            **_of_space(arm),
        },
        "effects": [_effect(effect) for effect in run.effects],
        "pressures": run.pressures,
        "torque": run.torque,
        "phi": run.torque / run.arm.keq,
        **({} if run.direction is None else {"direction": run.direction}),
        "tip": {"x": measures.x, "z": measures.z} | ({} if run.direction is None else {"y": measures.y}),
        "settling_time": measures.settling_time,
        "overshoot": measures.overshoot,
        "circle": None
        if circle is None
        else {"radius": circle.radius if math.isfinite(circle.radius) else None, "distance": circle.distance},
        **({} if measures.off_plane is None else {"off_plane": measures.off_plane}),
        "duration": float(run.motion.time[-1] - run.motion.time[0]),
        "notes": list(run.notes),
    }


def _of_space(arm: ArmSpecification) -> dict[str, Any]:
    """Return the JSON entries of an arm in space; a torsion of null is infinite."""
    if arm.bending == "plane":
        return {}
    torsion = float(arm.torsion) if math.isfinite(arm.torsion) else None
    return {"bending": arm.bending, "torsion": torsion, "cross_tilt": float(arm.cross_tilt)}


def _effect(effect: Any) -> dict[str, Any]:
    values = {fact.name: float(getattr(effect, fact.name)) for fact in effect.parameters()}
    return {"name": effect.name, **values, **{name: getattr(effect, name) for name in effect.choices()}}
