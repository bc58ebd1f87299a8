"""Options for the dataset and the output files of a command, and checks of these files before the computation."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


def force_option(command: Command) -> Command:
    """Add the option ``--force`` to a command."""
    return click.option("--force", is_flag=True, help="Replace files that another program wrote.")(command)


def dataset_argument(command: Command) -> Command:
    """Add the argument ``DATASET`` and the option ``--list-samples`` to a command."""
    flag: dict[str, Any] = {"is_flag": True, "is_eager": True, "expose_value": False, "callback": _list_samples}
    listing = click.option("--list-samples", help="List the sample recordings.", **flag)
    return click.argument("dataset", metavar="DATASET")(listing(command))


def _list_samples(context: click.Context, option: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from hsr_pin.recordings.samples import ROBOTS, SAMPLES

        every = SAMPLES | (ROBOTS if context.command.name == "hsr-diagnose" else {})
        width = max(map(len, every))
        click.echo("\n".join(f"{name:<{width}}  {what}" for name, what in every.items()))
        context.exit()


def check_outputs(files: Mapping[str, Any], *, read: Iterable[Any] = (), force: bool = False) -> None:
    """Check that files can and may be written.

    Args:
        files: option -> name of its file; None: not requested; "-": standard output.
        read: files and folders that the command reads.
        force: allow files that another program wrote to be replaced.

    Raises:
        OutputError: a file cannot be written, is an input, was written by another program, or is named twice.
    """
    from hsr_pin.errors import OutputError
    from hsr_pin.output import check_replaceable, check_writable

    asked = {option: os.fspath(name) for option, name in files.items() if name is not None and os.fspath(name) != "-"}
    sources = [source for source in read if source is not None]
    places: dict[str, str] = {}
    for option, name in asked.items():
        check_writable(name)
        other = places.setdefault(os.path.realpath(name), option)
        if other != option:
            hint = "give different files"
            raise OutputError(f"{other} and {option}", expected="two files", received=f"{name} for both", hint=hint)
        check_replaceable(name, read=sources, force=force)


def dataset_folder(dataset: str) -> str:
    """Return the folder of a dataset, which may be given by its ``dataset.toml``."""
    return os.path.dirname(dataset) or "." if os.path.basename(dataset) == "dataset.toml" else dataset
