"""What the commands that name causes share: the loss that was asked for, and how far they have come."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hsr_pin.inference import Loss

#: What a fit leaves of a stage.
_SHARE = 0.9


def loss_from(options: dict[str, Any]) -> Loss | None:
    """The loss that was given; None for the usual one."""
    from hsr_pin.inference import Loss

    return None if options["loss"] is None else Loss.of(options["loss"])


@contextmanager
def progress(stages: int) -> Iterator[tuple[Callable[[str], None], Callable[[], None]]]:
    """What to call at each stage and after each fit: a bar on a terminal, nothing anywhere else.

    How many fits a stage takes is not known before: each fills a fixed share of what its stage still lacks.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    from hsr_pin.cli.console import console

    screen = console(stderr=True)
    stage = TextColumn("{task.description}", markup=False)
    columns = (stage, BarColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("starting", total=stages)
        begun, fits = 0, 0

        def tell(line: str) -> None:
            nonlocal begun, fits
            begun, fits = begun + 1, 0
            bar.update(task, description=line, completed=begun - 1)

        def advance() -> None:
            nonlocal fits
            fits += 1
            bar.update(task, completed=begun - _SHARE**fits)

        yield tell, advance
