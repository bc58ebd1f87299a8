"""Printed report of ``hsr-fit``."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from hsr_pin.cli.console import console
from hsr_pin.identification.identify import Identification
from hsr_pin.identification.links_study import LinksStudy
from hsr_pin.identification.paper_procedure import PaperProcedure
from hsr_pin.identification.profile import Profile
from hsr_pin.inference.residuals import rms
from hsr_pin.trajectory import Array


def print_fit(
    found: Identification,
    profiles: Sequence[Profile] = (),
    paper: PaperProcedure | None = None,
    study: LinksStudy | None = None,
) -> None:
    """Print values with intervals, errors in and out of sample, warnings, and the additional studies that were requested."""
    screen = console()
    experiment, hypothesis = found.experiment, found.fit.hypothesis
    links = "1 link" if hypothesis.links == 1 else f"{hypothesis.links} links"
    trials = "1 trial" if len(experiment.runs) == 1 else f"{len(experiment.runs)} trials"
    title = f"{experiment.dataset.name}: {trials} fitted, {links}, joints at {hypothesis.placement}"
    screen.print(title, style="bold", soft_wrap=True)
    screen.print(_values(found, profiles))
    screen.print(_errors(found))
    for line in _warnings(found):
        screen.print(line, style="yellow", soft_wrap=True)
    if paper is not None:
        _print_paper(screen, paper, experiment.dataset.length)
    if study is not None:
        _print_study(screen, study, experiment.dataset.length)
    for note in experiment.notes:
        screen.print(f"note: {note}", style="yellow", soft_wrap=True)


def _table(*columns: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), header_style="bold cyan")
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number else "left", no_wrap=True)
    return table


def _values(found: Identification, profiles: Sequence[Profile]) -> Table:
    answer, intervals, bounds = found.fit, found.uncertainty.interval, found.fit.on_bound()
    known = {profile.name: profile.interval for profile in profiles}
    table = _table("parameter", "value", "95 % interval", *(["by profile"] if known else []), "unit")
    for fact, value, interval in zip(answer.hypothesis.parameters, answer.values, intervals, strict=True):
        places = _places(interval)
        cells = [_rounded(value, places), _interval(interval, places)]
        cells += [_interval(known[fact.name], places)] if fact.name in known else []
        table.add_row(fact.name, *cells, "" if fact.unit == "1" else fact.unit, style="yellow" if fact.name in bounds else "")
    return table


def _errors(found: Identification) -> Table:
    length = found.experiment.dataset.length
    heldout = "held-out trials" if found.set_aside else "each trial by a fit to the others"
    table = _table("RMS distance", "as declared\nmm", "\n% of L", "fitted\nmm", "\n% of L")
    rows: list[tuple[str, Sequence[Array], Sequence[Array]]] = [("fitted trials", found.before, found.after)]
    if found.heldout:
        rows.append((heldout, found.heldout_before, found.heldout))
    several = len(found.experiment.markers) > 1
    for name, before, after in rows:
        for what, measure in (("", rms), (", tip", found.tip_rms))[: 2 if several else 1]:
            table.add_row(name + what, *_cells([measure(before), measure(after)], length))
    table.add_row("noise alone", "", "", *_cells([found.experiment.noise_rms], length))
    return table


def _cells(distances: Sequence[float], length: float) -> list[str]:
    """Return each distance [m] in mm and in % of the arm's length; a dash if it is unknown."""
    return [f"{scale * d:.2f}" if math.isfinite(d) else "-" for d in distances for scale in (1e3, 100 / length)]


def _warnings(found: Identification) -> list[str]:
    facts = {fact.name: fact for fact in found.fit.hypothesis.parameters}
    lines = [
        f"{name} ended on its bound ({facts[name].lower:g} to {facts[name].upper:g}): its interval is not reliable."
        for name in found.fit.on_bound()
    ]
    lines += [f"not determined by these data: {words}." for words in found.uncertainty.weak]
    lines += [f"{name} cannot be simulated with these values; check its input." for name in found.fit.failed]
    if not found.fit.converged:
        lines.append("The fit stopped before it converged.")
    if not found.heldout:
        lines.append("A single trial leaves nothing to hold out, so that the error on other trials is unknown.")
    return lines


def _print_paper(screen: Console, paper: PaperProcedure, length: float) -> None:
    last = paper.last
    screen.print(f"Procedure of the paper ({paper.links} links, joints at {paper.placement}), C by brute force:", style="bold")
    table = _table("pass", "Keq times", "C times", "RMS, mm", "% of L")
    for number, step in enumerate(paper.passes):
        factors = (f"{step.keq_scale:.4f}", f"{step.damping_scale:.4f}")
        table.add_row(str(number) if number else "declared", *factors, *_cells([step.rms], length))
    screen.print(table)
    screen.print(
        f"Keq times {last.keq_scale:.4f}, C times {last.damping_scale:.4f} after {paper.simulations} simulations of the dataset.",
        style="dim",
        soft_wrap=True,
    )


def _print_study(screen: Console, study: LinksStudy, length: float) -> None:
    screen.print(f"Comparison of numbers of links (joints at {study.placement}):", style="bold")
    table = _table("N", "model error\nmm", "\n% of L", "data error\nmm", "\n% of L", "cost\nrelative")
    for row in study.rows:
        style = "bold" if row.links == study.recommended else ""
        table.add_row(str(row.links), *_cells([row.model_error, row.data_error], length), f"{row.cost:.0f}", style=style)
    screen.print(table)
    screen.print(study.sentence, soft_wrap=True)


def _places(interval: Sequence[float] | Array) -> int:
    """Return the number of decimals that shows two digits of half an interval's width."""
    half = (float(interval[1]) - float(interval[0])) / 2
    return min(9, max(0, 1 - math.floor(math.log10(half)))) if half > 0 and math.isfinite(half) else 4


def _rounded(value: float, places: int) -> str:
    return f"{value:.{places}f}"


def _interval(interval: Sequence[float] | Array, places: int) -> str:
    return f"{_rounded(float(interval[0]), places)} to {_rounded(float(interval[1]), places)}"
