"""What commands print for people, and the one place where names that come from files are made harmless for it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

import click
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from hsr_pin.errors import printable


class _Plain(Console):
    """Takes nothing for markup or an emoji, and lets no control character through."""

    def __init__(self, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def render_str(self, text: str, **options: object) -> Text:
        return super().render_str(printable(text), **options)  # type: ignore[arg-type]

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError  # which :func:`shown` and the command's end know


def console(*, stderr: bool = False) -> Console:
    """Where to print."""
    return _Plain(stderr)


def say(text: str) -> None:
    """Print a text without style."""
    click.echo(printable(text))


@contextmanager
def shown() -> Iterator[None]:
    """Print within this what comes before more work: a reader that has seen enough (``| head``) does not end that."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        silence()


def silence() -> None:
    """Print nothing more on standard output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say_written(paths: Sequence[str]) -> None:
    """Say which files were written, each on its line."""
    for path in paths:
        console().print(f"wrote {path}", style="green", soft_wrap=True)
