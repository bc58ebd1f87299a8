"""Loss function and progress bar of the commands that diagnose causes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hsr_pin.inference import Loss

#: Factor by which each fit reduces the remaining share of its stage in the progress bar.
_SHARE = 0.9


def loss_from(options: dict[str, Any]) -> Loss | None:
    """Return the loss function given by the option; None for the default."""
    from hsr_pin.inference import Loss

    return None if options["loss"] is None else Loss.of(options["loss"])


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
