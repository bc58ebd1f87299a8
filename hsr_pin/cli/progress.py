"""A progress bar on a terminal, nothing anywhere else."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

_Item = TypeVar("_Item")


def progress(items: Sequence[_Item], what: str) -> Iterator[_Item]:
    """The items, with a bar on stderr while they are worked on; the bar is gone at the end."""
    shown: Iterable[_Item] = items
    if sys.stderr.isatty():
        from rich.progress import track

        from hsr_pin.cli.console import console

        shown = track(items, what, console=console(stderr=True), transient=True)
    yield from shown


@contextmanager
def counted(what: str, total: int) -> Iterator[Callable[[], None]]:
    """What to call after each of ``total`` pieces of work; the bar is gone at the end."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    from hsr_pin.cli.console import console

    screen = console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda: bar.advance(task)
