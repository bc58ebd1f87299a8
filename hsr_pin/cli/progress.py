"""A progress bar on a terminal, nothing anywhere else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

_Item = TypeVar("_Item")


def progress(items: Sequence[_Item], what: str) -> Iterator[_Item]:
    """The items, with a bar on stderr while they are worked on; the bar is gone at the end."""
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    shown: Iterable[_Item] = track(items, what, console=console, transient=True, disable=not console.is_terminal)
    yield from shown
