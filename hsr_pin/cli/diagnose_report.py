"""Printed report of ``hsr-diagnose``, which fits on a screen of 80 x 24 characters."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from rich.text import Text

from hsr_pin.cli.console import print_lines, written_line
from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.diagnosis.words import advice, supply_sentence, where_sentence
from hsr_pin.inference.detection import detection_sentence
from hsr_pin.inference.estimates import estimates, number, ranked
from hsr_pin.inference.verdict import headline

#: Number of lines of a screen, without the line of the next prompt.
LINES = 23
#: Status of the verdict -> colour of its headline.
_COLOURS = {
    "identified": "bold green",
    "partly_identified": "bold green",
    "no_gap": "bold green",
    "parameters": "bold blue",
    "ambiguous": "bold yellow",
    "unexplained": "bold red",
    "insufficient": "bold yellow",
}


def print_report(diagnosis: Diagnosis, files: Sequence[str] = ()) -> None:
    """Print the verdict, the error budget, the best models, the location of the gap and advice, with a line left for files."""
    print_lines(lambda width: screen(diagnosis, width, files)[: -1 if files else None])


def screen(diagnosis: Diagnosis, width: int = 80, written: Sequence[str] = ()) -> list[Text]:
    """Return the lines of the report; if a screen is too small, the last parameters are left out and counted."""
    width = max(40, width)
    name, status = diagnosis.experiment.dataset.name, diagnosis.verdict.status
    verdict = [Text.assemble((f"{name}: ", "bold"), (headline(diagnosis.verdict), _COLOURS[status]))]
    verdict += _wrapped(diagnosis.verdict.sentence, width)
    ladder = _ladder(diagnosis, width)
    rest = [] if diagnosis.where is None else _wrapped(f"where: {where_sentence(diagnosis.where)}", width)
    if diagnosis.indicators is not None and diagnosis.indicators.kinds:
        rest += _wrapped(f"data:  without a model the recordings point to {', '.join(diagnosis.indicators.kinds)}", width)
    if supply := supply_sentence(diagnosis):
        rest += _wrapped(f"supply: {supply}", width)
    if diagnosis.search is not None and (limits := detection_sentence(diagnosis.search.detection)):
        rest += _wrapped(f"limit: {limits}", width)
    rest += [line for sentence in advice(diagnosis) for line in _wrapped(f"next:  {sentence}", width)]
    rest += _notes(diagnosis, width)
    rest += [written_line(written)] if written else []
    models = _models(diagnosis, width, LINES - len(verdict) - len(ladder) - len(rest))
    spare = LINES - len(verdict) - len(ladder) - len(models) - len(rest)
    lines: list[Text] = []
    for block in filter(None, (verdict, ladder, models, rest)):
        if lines and spare > 0:
            lines, spare = [*lines, Text()], spare - 1
        lines += block
    return lines


def _ladder(diagnosis: Diagnosis, width: int) -> list[Text]:
    length, columns = diagnosis.experiment.dataset.length, width - 48
    lines = [
        Text(f"{'held-out trials':<{columns}}{'RMS [mm]':>9}{'% of L':>8}{'95 % interval':>20}{'of gap²':>10}", style="bold cyan")
    ]
    for place, stage in enumerate(diagnosis.ladder):
        last = place == len(diagnosis.ladder) - 1
        low, high = (_short(1e3 * bound) for bound in stage.interval)
        interval = "" if last else f"{low} to {high}"
        share = "" if place == 0 else f"{100 * stage.share:.1f} %".replace("-0.0", "0.0")
        name = _cut("noise floor; rest unexplained" if last else stage.name, columns)
        lines.append(
            Text(f"{name:<{columns}}{_short(1e3 * stage.rms):>9}{_short(100 * stage.rms / length):>8}{interval:>20}{share:>10}")
        )
    return lines


def _short(value: float) -> str:
    """Return a number with three digits, and with at most three decimals."""
    return f"{value:.3f}" if 0 <= value < 0.1 else number(value)


def _models(diagnosis: Diagnosis, width: int, height: int) -> list[Text]:
    """Return the parameters of the best model and the names of the next best ones, in at most ``height`` lines."""
    if diagnosis.search is None:
        return []
    best = diagnosis.search.best
    forms = {effect.name: ", ".join(value for _, value in effect.options) for effect in best.fit.hypothesis.effects}
    parts = [f"{name} ({forms[name]})" if forms.get(name) else name for name in best.names]
    heading = f"most probable model: {' + '.join(parts) or 'stiffness and damping'}"
    others = [candidate for candidate in ranked(diagnosis.search.candidates) if candidate.names != best.names]
    named = [f"{number(1e3 * each.heldout_square**0.5)} {' + '.join(each.names) or 'K and C only'}" for each in others[:3]]
    rivals = [Text(_cut(f"others, by error [mm]: {'; '.join(named)}", width))] if named else []
    own, rows = estimates(best.fit), []
    for each in own:
        if "." not in each.name:
            continue
        value, low, high = each.rounded
        unit = "" if each.unit == "1" else each.unit
        bound = " at bound" if each.on_bound else ""
        rows.append(f"  {each.name:<29}{value:>9}  {f'{low} to {high}':<20} {unit}{bound}")
    rows.append(f"  {', '.join(str(each) for each in own if '.' not in each.name)}")
    free = max(1, height - 1)
    if len(rows) > free:
        rows = [*rows[: free - 1], f"  and {len(rows) - free + 1} more lines of parameters: see --html or --json"]
    lines = [Text(_cut(heading, width), style="bold cyan"), *(Text(_cut(row, width)) for row in rows)]
    return [*lines, *rivals] if len(lines) < height else lines


def _notes(diagnosis: Diagnosis, width: int) -> list[Text]:
    notes = diagnosis.experiment.notes
    if not notes:
        return []
    more = f" (and\N{NO-BREAK SPACE}{len(notes) - 1}\N{NO-BREAK SPACE}more\N{NO-BREAK SPACE}notes)" if len(notes) > 1 else ""
    lines = textwrap.wrap(f"note:  {notes[0]}{more}", width, subsequent_indent=" " * 7)
    return [Text(line.replace("\N{NO-BREAK SPACE}", " "), style="yellow") for line in lines]


def _wrapped(text: str, width: int) -> list[Text]:
    indent = " " * 7 if text.startswith(("where: ", "next:  ", "data:  ", "limit: ", "supply:")) else ""
    lines = textwrap.wrap(text, width, subsequent_indent=indent, max_lines=5, placeholder=" \u2026")
    return [Text(line) for line in lines]


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width - 1]}…"
