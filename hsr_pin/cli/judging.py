"""Candidates, loss function, progress bar and output of the commands that diagnose causes."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from hsr_pin.inference import Loss

#: Factor by which each fit reduces the remaining share of its stage in the progress bar.
_SHARE = 0.9


def loss_from(options: dict[str, Any]) -> Loss | None:
    """Return the loss function given by the option; None for the default."""
    from hsr_pin.inference import Loss

    return None if options["loss"] is None else Loss.of(options["loss"])


def effects_from(options: dict[str, Any], others: Collection[str] = ()) -> list[str] | None:
    """Return the candidates given by the option, names of effects or of ``others``; None for the default.

    Raises:
        EffectError: a name is unknown; it is refused before the recordings are read, which takes longer.
    """
    if options["effects"] is None:
        return None
    from hsr_pin.effects import effect_named

    names = [name.strip() for name in options["effects"].split(",")]
    for name in names:
        if name not in others:
            effect_named(name)
    return names


def print_and_write(
    options: dict[str, Any], document: Callable[[], dict[str, Any]], show: Callable[[], None], write_html: Callable[[str], None]
) -> None:
    """Print a report, or JSON if that goes to standard output, and write the requested files.

    The names of the files that were written are printed, also after an error.

    Args:
        options: options of the command, with the names of the files.
        document: function that returns the result for JSON.
        show: function that prints the report.
        write_html: function that writes the report to a file.
    """
    from hsr_pin.cli.console import console, ignore_closed_pipe, written_line
    from hsr_pin.output import write_text

    def text() -> str:
        return json.dumps(document(), indent=2, allow_nan=False, ensure_ascii=False)

    json_file, html_file = options["json_file"], options["html_file"]
    with ignore_closed_pipe():
        if json_file == "-":
            click.echo(text())
        else:
            show()
    written: list[str] = []
    try:
        if json_file not in (None, "-"):
            write_text(json_file, text() + "\n")
            written.append(json_file)
        if html_file is not None:
            write_html(html_file)
            written.append(html_file)
    finally:
        if written and json_file != "-":
            console().print(written_line(written), soft_wrap=True)


@contextmanager
def progress(stages: int) -> Iterator[tuple[Callable[[str], None], Callable[[], None]]]:
    """Yield functions to call at each stage and after each fit, which update a progress bar on a terminal.

    The number of fits of a stage is not known in advance, so that each fit fills a fixed share of the remaining stage.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    from hsr_pin.cli.console import console

    screen = console(stderr=True)
    stage = TextColumn("{task.description}", markup=False)
    columns = (stage, BarColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("starting", total=stages)
        begun, fits = 0, 0

        def report_stage(line: str) -> None:
            nonlocal begun, fits
            begun, fits = begun + 1, 0
            bar.update(task, description=line, completed=begun - 1)

        def advance() -> None:
            nonlocal fits
            fits += 1
            bar.update(task, completed=begun - _SHARE**fits)

        yield report_stage, advance
