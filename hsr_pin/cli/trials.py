"""Options that select the fitted and the predicted trials of a command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option("--train", default="", metavar="A,B,...", help="Trials to fit: names or patterns, e.g. 'trial_0[12]'."),
    click.option("--test", default="", metavar="A,B,...", help="Trials to predict.  [default: those not fitted]"),
    click.option(
        "--delay",
        type=click.FloatRange(0),
        default=0.0,
        show_default=True,
        metavar="S",
        help="Time after the declared start of a release [s] during which the arm may still be touched and is not fitted.",
    ),
)


def trial_options(command: Command) -> Command:
    """Add the options ``--train``, ``--test`` and ``--delay`` to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def trials_from(options: dict[str, Any]) -> dict[str, Any]:
    """Return the keyword arguments ``train``, ``test`` and ``delay``."""
    return {"train": listed(options["train"]), "test": listed(options["test"]), "delay": options["delay"]}


def listed(text: str) -> list[str]:
    """Return the parts of a comma-separated list."""
    return [part.strip() for part in text.split(",") if part.strip()]
