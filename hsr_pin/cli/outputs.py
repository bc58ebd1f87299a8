"""What a command reads and writes: its dataset, and files that are checked before anything is computed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


def force_option(command: Command) -> Command:
    """Give a command ``--force``."""
    return click.option("--force", is_flag=True, help="Replace files that another program wrote.")(command)


def dataset_argument(command: Command) -> Command:
    """Give a command the argument ``DATASET`` and ``--list-samples``."""
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
    """Refuse what could not or must not be written.

    Args:
        files: option -> the file it names; None: not asked for; "-": standard output.
        read: files and folders that the command reads.
        force: replace what another program wrote.

    Raises:
        OutputError: a file that cannot be written, is read, is another program's, or is named twice.
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
            hint = "name different files"
            raise OutputError(f"{other} and {option}", expected="two files", received=f"{name} for both", hint=hint)
        check_replaceable(name, read=sources, force=force)


def dataset_folder(dataset: str) -> str:
    """The folder of a dataset, which may be named by its ``dataset.toml``."""
    return os.path.dirname(dataset) or "." if os.path.basename(dataset) == "dataset.toml" else dataset
