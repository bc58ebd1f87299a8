"""Printing to the terminal, with control characters from files made harmless."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

import click
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from hsr_pin.errors import printable


class _Plain(Console):
    """Console that interprets no markup or emoji codes and escapes control characters."""

    def __init__(self, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def render_str(self, text: str, **options: object) -> Text:
        return super().render_str(printable(text), **options)  # type: ignore[arg-type]

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError  # handled by :func:`ignore_closed_pipe` and at the end of the command


def console(*, stderr: bool = False) -> Console:
    """Return a console for standard output or standard error."""
    return _Plain(stderr)


def print_text(text: str) -> None:
    """Print a text without style."""
    click.echo(printable(text))


@contextmanager
def ignore_closed_pipe() -> Iterator[None]:
    """Ignore a closed output pipe (``| head``) within the context, so that the work after it continues."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        discard_output()


def discard_output() -> None:
    """Discard all further output to standard output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def print_lines(screen: Callable[[int], Iterable[str | Text]]) -> None:
    """Print the lines that a report has for the width of the terminal."""
    to = console()
    for line in screen(to.width):
        to.print(line, soft_wrap=True)


def written_line(paths: Sequence[str]) -> Text:
    """Return a line with the names of the files that were written."""
    return Text(f"wrote {', '.join(paths)}", style="green")


def print_written_files(paths: Sequence[str]) -> None:
    """Print the names of the files that were written, one on each line."""
    for path in paths:
        console().print(f"wrote {path}", style="green", soft_wrap=True)
