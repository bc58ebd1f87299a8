"""Printed report of ``hsr-diagnose --since``: the changes of an arm between recordings."""

from __future__ import annotations

import textwrap

from rich.text import Text

from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis
from hsr_pin.diagnosis.change.history import History, Quantity
from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.words import HEADLINES, advice, rounded
from hsr_pin.inference.estimates import number

_COLOURS = {
    "identified": "bold blue",
    "partly_identified": "bold blue",
    "ambiguous": "bold yellow",
    "unexplained": "bold red",
    "unchanged": "bold green",
    "insufficient": "bold yellow",
}


def screen(found: History, width: int = 80) -> list[Text]:
    """Return the lines of the report."""
    width = max(40, width)
    lines = _comparison(found.diagnoses[-1], width)
    return [*lines, Text(), *_sessions(found, width)] if len(found.names) > 2 else lines


def _comparison(diagnosis: ChangeDiagnosis, width: int) -> list[Text]:
    verdict, pair = diagnosis.verdict, diagnosis.pair
    title = f"{pair.new.dataset.name} since {pair.old.dataset.name}: "
    lines = [Text.assemble((title, "bold"), (HEADLINES[verdict.status], _COLOURS[verdict.status]))]
    lines += _wrapped(verdict.sentence, width)
    if verdict.difference is not None:
        off = verdict.difference
        lines += [Text(), Text(f"{'RMS distance of the current recording from':<56}[mm]", style="bold cyan")]
        lines.append(Text(f"{'the prediction from the reference recording':<54}{number(1e3 * off.before):>6}"))
        if verdict.changes:
            lines.append(Text(f"{'the same prediction with the change':<54}{number(1e3 * off.after):>6}"))
        lines.append(Text(f"{'expected scatter without a change':<54}{number(1e3 * off.scatter):>6}"))
    if verdict.changes:
        lines += [Text(), Text(f"{'what changed':<32}{'from':>10}{'to':>10}   {'95 % interval':<20}", style="bold cyan")]
        lines += [_row(each) for each in verdict.changes]
    if diagnosis.found is not None and len(diagnosis.found.fits) > 1:
        best = diagnosis.found.fits[:4]
        listed = "; ".join(f"{' + '.join(fitted.change.names)} {number(diagnosis.found.gain(fitted))}" for fitted, _ in best)
        lines += [Text(), *_wrapped(f"explanations (drop of -2 log likelihood): {listed}", width)]
    if diagnosis.reference is not None:
        names = " + ".join(diagnosis.reference.names) or "stiffness and damping"
        lines += _wrapped(f"model of the reference recording: {names}, and a smooth model discrepancy", width)
    lines += [line for each in advice(diagnosis) for line in _wrapped(f"next:  {each}", width)]
    return lines


def _row(size: Size) -> Text:
    span = size.becomes
    before = "" if size.before is None else rounded(size.before, span)
    unit = "" if size.unit == "1" else f" {size.unit}"
    between = f"{rounded(span[0], span)} to {rounded(span[1], span)}{unit}"
    return Text(f"  {size.parameter:<30}{before:>10}{rounded(size.after, span):>10}   {between}")


def _sessions(found: History, width: int) -> list[Text]:
    """Return a table of all quantities over the sessions, with * for identified changes and ? for possible changes."""
    columns = max(10, min(18, (width - 30) // len(found.names)))
    heads = "".join(f"{name[: columns - 2]:>{columns}}" for name in found.names)
    lines = [Text(f"{'over the sessions':<30}{heads}", style="bold cyan")]
    lines += [Text(f"  {each.name:<28}{_points(each, columns)}") for each in found.quantities]
    for each in found.quantities:
        if each.first is not None:
            lines.append(Text(f"{each.name}: change identified (*) from {found.names[each.first]} on"))
    return lines


def _points(quantity: Quantity, columns: int) -> str:
    marks = {"certain": "*", "perhaps": "?", "": " "}
    return "".join(f"{number(point.value) + marks[point.changed]:>{columns}}" for point in quantity.points)


def _wrapped(text: str, width: int) -> list[Text]:
    indent = " " * 7 if text.startswith("next:  ") else ""
    return [Text(line) for line in textwrap.wrap(text, width, subsequent_indent=indent)]
