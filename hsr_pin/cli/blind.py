"""``hsr-blind``: a check of the diagnosis on recordings whose effect is withheld."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.command import run
from hsr_pin.cli.progress import counted
from hsr_pin.errors import InputError

if TYPE_CHECKING:
    from hsr_pin.blind.scoring import Score

_EPILOG = "Example: hsr-blind make --seed 7 --cases 200 -o check && hsr-blind run check && hsr-blind score check"
_FOLDER = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
_JOBS = click.option("--jobs", type=click.IntRange(1, 1000), default=1, show_default=True, help="Cases at a time.")
_FILE = click.Path(path_type=Path)
_PLOT = click.option("--plot", "plot_file", metavar="FILE", type=_FILE, help="Write the confusion matrix as a picture.")


@click.group(name="hsr-blind", epilog=_EPILOG, context_settings={"max_content_width": 100})
def command() -> None:
    """Check the diagnosis on recordings whose effect is withheld.

    Three steps: `make` records cases with engines that share nothing with the model, and seals their answers outside of the
    folder; `run` diagnoses every recording from its folder alone; `score` opens the answers. The first two go on where they were
    interrupted.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded: processes, not threads, share the cores


@command.command(name="make")
@click.option("--seed", type=click.IntRange(0), required=True, help="All follows from it: keep it apart until the score.")
@click.option("--cases", type=click.IntRange(1, 999), default=200, show_default=True, help="How many.")
@click.option("-o", "folder", metavar="DIR", type=_FILE, required=True, help="A new folder for the recordings.")
@click.option("--answers", metavar="FILE", type=_FILE, help="Where to seal the answers.  [default: DIR-answers.json]")
@_JOBS
def make_command(seed: int, cases: int, folder: Path, answers: Path | None, jobs: int) -> None:
    """Record cases without labels, and seal their answers."""
    from hsr_pin.blind.make import make

    with counted("recording", cases) as advance:
        file = make(folder, seed, cases, answers, jobs=jobs, advance=advance)
    click.echo(f"wrote {folder}, {file}")


@command.command(name="run")
@_FOLDER
@_JOBS
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the resampling.")
@click.option("-o", "verdicts", metavar="DIR", type=_FILE, help="Where to write the verdicts.  [default: DIR/verdicts]")
def run_command(folder: Path, jobs: int, seed: int, verdicts: Path | None) -> None:
    """Diagnose every recording in DIR that has no verdict yet."""
    from hsr_pin.blind.diagnoses import diagnose_all, recordings

    target = verdicts or folder / "verdicts"
    with counted("diagnosing", len(recordings(folder))) as advance:
        diagnose_all(folder, target, jobs=jobs, seed=seed, advance=advance)
    click.echo(f"wrote {target}")


@command.command(name="score")
@_FOLDER
@click.option("--answers", metavar="FILE", type=_FILE, help="The sealed answers.  [default: DIR-answers.json]")
@click.option("--verdicts", metavar="DIR", type=_FILE, help="[default: DIR/verdicts]")
@click.option("--oracle", is_flag=True, help="Fit the true laws too, to know how far the gap could shrink (kept in DIR/oracle).")
@_JOBS
@click.option("--json", "json_file", metavar="FILE", type=_FILE, help="Write the score for programs.")
@_PLOT
def score_command(folder: Path, answers: Path | None, verdicts: Path | None, jobs: int, **options: Any) -> None:
    """Open the answers, and say how often the diagnosis was right."""
    from hsr_pin.blind.answers import unseal
    from hsr_pin.blind.diagnoses import read_verdicts
    from hsr_pin.blind.make import default_answers
    from hsr_pin.blind.oracle import consult, read_oracle
    from hsr_pin.blind.scoring import score
    from hsr_pin.output import check_writable, write_text

    for file in filter(None, (options["json_file"], options["plot_file"])):
        check_writable(file)
    truth = unseal(folder, answers or default_answers(folder.resolve()))
    if options["oracle"]:
        with counted("oracle", sum(answer.kind in ("single", "pair") for answer in truth)) as advance:
            consult(folder, folder / "oracle", truth, jobs=jobs, advance=advance)
    found = score(truth, read_verdicts(verdicts or folder / "verdicts"), read_oracle(folder / "oracle"))
    if options["json_file"]:
        write_text(options["json_file"], json.dumps(found.document(), indent=1, allow_nan=False) + "\n")
    _tell(found, options["plot_file"])
    if options["json_file"]:
        click.echo(f"wrote {options['json_file']}")


@command.command(name="show")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@_PLOT
def show_command(file: Path, plot_file: Path | None) -> None:
    """Print a score that was written with --json."""
    from hsr_pin.blind.scoring import scored
    from hsr_pin.output import check_writable

    if plot_file:
        check_writable(plot_file)
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError("score", expected="a file that hsr-blind score --json wrote", received=error, file=file) from error
    _tell(scored(document), plot_file)


def _tell(found: Score, plot_file: Path | None) -> None:
    from hsr_pin.cli.blind_report import report

    click.echo(report(found))
    if plot_file:
        from hsr_pin.blind.picture import draw

        draw(found, plot_file)
        click.echo(f"wrote {plot_file}")


def main() -> None:
    """Entry point of ``hsr-blind``."""
    sys.exit(run(command))
