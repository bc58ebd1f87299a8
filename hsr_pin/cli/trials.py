"""Options of the commands that fit some trials and predict others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option("--train", default="", metavar="A,B,...", help="Trials to fit: names or patterns, e.g. 'trial_0[12]'."),
    click.option("--test", default="", metavar="A,B,...", help="Trials to predict instead.  [default: those not fitted]"),
    click.option(
        "--delay",
        type=click.FloatRange(0),
        default=0.0,
        show_default=True,
        metavar="S",
        help="Follow a release only from so long after its declared start [s]: while a hand still touches the arm.",
    ),
)


def trial_options(command: Command) -> Command:
    """Add ``--train``, ``--test`` and ``--delay``."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def trials_from(options: dict[str, Any]) -> dict[str, Any]:
    """The keyword arguments ``train``, ``test`` and ``delay``."""
    return {"train": listed(options["train"]), "test": listed(options["test"]), "delay": options["delay"]}


def listed(text: str) -> list[str]:
    """The parts of a list with commas."""
    return [part.strip() for part in text.split(",") if part.strip()]
