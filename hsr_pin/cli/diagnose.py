"""``hsr-diagnose``: where the sim-to-real gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.command import run

if TYPE_CHECKING:
    from hsr_pin.diagnosis.diagnose import Diagnosis

#: Stages beside the effects: reading, stiffness and damping, where.
_OTHER_STAGES = 3
#: What a fit leaves of a stage.
_SHARE = 0.9

_EPILOG = "Example: hsr-diagnose recordings/sample-steps --html report.html"


@click.command(name="hsr-diagnose", epilog=_EPILOG, context_settings={"max_content_width": 100})
@click.argument("dataset", metavar="DATASET")
@click.option("--effects", metavar="A,B,...", help="Candidates.  [default: the whole catalogue]")
@click.option("--max-effects", type=click.IntRange(0, 19), default=3, show_default=True, help="At most this many together.")
@click.option("--links", type=click.IntRange(1, 100), default=6, show_default=True, help="Links of the chain that is fitted.")
@click.option("--jobs", type=click.IntRange(1, 1000), metavar="N", help="Processes.  [default: one per core]")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the resampling: same seed, same answer.")
@click.option("--json", "json_file", metavar="FILE", help="Write the diagnosis for programs; - for standard output.")
@click.option("--html", "html_file", metavar="FILE", help="Write a self-contained report.")
def command(dataset: str, **options: Any) -> None:
    """Diagnose the gap between a simulated and a recorded hybrid soft robot.

    Reads the recordings in the folder DATASET, fits the model to them with and without effects that it may lack, judges each on
    trials that were not fitted, and says what the recordings support: which effects are missing, which cannot be told apart,
    that stiffness and damping explain it, or that nothing known does.
    """
    _check_outputs(options)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded: processes, not threads, share the cores
    diagnosis = _diagnosis(dataset, options)
    written = _write(diagnosis, options)
    if options["json_file"] != "-":
        from hsr_pin.cli.diagnose_report import print_report

        print_report(diagnosis, written)


def _check_outputs(options: dict[str, Any]) -> None:
    """Refuse what could not be written, before anything is computed."""
    from hsr_pin.errors import OutputError
    from hsr_pin.output import check_writable

    files = [name for name in (options["json_file"], options["html_file"]) if name not in (None, "-")]
    if len({os.path.realpath(name) for name in files}) < len(files):
        raise OutputError("--json and --html", expected="two files", received=f"{files[0]} for both")
    for name in files:
        check_writable(name)


def _diagnosis(dataset: str, options: dict[str, Any]) -> Diagnosis:
    from hsr_pin.diagnosis.diagnose import diagnose
    from hsr_pin.effects import effect_named
    from hsr_pin.recordings.read import read_dataset

    effects = None
    if options["effects"] is not None:
        effects = [name.strip() for name in options["effects"].split(",")]
        for name in effects:  # before the recordings, which take longer
            effect_named(name)
    recordings = read_dataset(dataset)
    given = {name: options[name] for name in ("max_effects", "links", "jobs", "seed")}
    with _progress(options["max_effects"]) as (tell, advance):
        return diagnose(recordings, effects=effects, **given, tell=tell, advance=advance)


@contextmanager
def _progress(max_effects: int) -> Iterator[tuple[Callable[[str], None], Callable[[], None]]]:
    """What to call at each stage and after each fit: a bar on a terminal, nothing anywhere else.

    How many fits a stage takes is not known before: each fills a fixed share of what its stage still lacks.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=max_effects + _OTHER_STAGES)
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


def _write(diagnosis: Diagnosis, options: dict[str, Any]) -> list[str]:
    written = []
    if options["json_file"] is not None:
        import json

        from hsr_pin.diagnosis.document import to_json
        from hsr_pin.output import write_text

        text = json.dumps(to_json(diagnosis), indent=2, allow_nan=False, ensure_ascii=False)
        if options["json_file"] == "-":
            click.echo(text)
        else:
            write_text(options["json_file"], text + "\n")
            written.append(options["json_file"])
    if options["html_file"] is not None:
        from hsr_pin.diagnosis.report import write_report

        write_report(diagnosis, options["html_file"])
        written.append(options["html_file"])
    return written


def main() -> None:
    """Entry point of ``hsr-diagnose``."""
    sys.exit(run(command))
