"""Command ``hsr-blind``: blind check of the diagnosis on recordings whose effect is withheld."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.command import exit_process, run
from hsr_pin.cli.outputs import check_outputs, force_option
from hsr_pin.cli.progress import counted
from hsr_pin.errors import InputError, one_line

if TYPE_CHECKING:
    from hsr_pin.blind.cases import Case
    from hsr_pin.blind.changes import ChangeScore
    from hsr_pin.blind.scoring import Score
    from hsr_pin.blind.workshop import Workshop

_EPILOG = "Example: hsr-blind make --seed 7 --cases 200 -o check && hsr-blind run check && hsr-blind score check"
_FOLDER = click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
_JOBS = click.option("--jobs", type=click.IntRange(1, 1000), default=1, show_default=True, help="Number of parallel processes.")
_CLUSTER = click.option("--cluster", metavar="ADDRESS", help="Dask scheduler whose workers need access to the folders.")
_FILE = click.Path(path_type=Path)
_PLOT = click.option("--plot", "plot_file", metavar="FILE", type=_FILE, help="Write the confusion matrix as a picture.")
_TRUST = click.option(
    "--reliability", "trust_file", metavar="FILE", type=_FILE, help="Write a picture of the reliability of stated confidences."
)


@click.group(name="hsr-blind", epilog=_EPILOG, context_settings={"max_content_width": 100})
def command() -> None:
    """Check the diagnosis on recordings whose effect is withheld.

    Cases are grouped in tiers: clean arms with one or two effects; messy arms with many small effects and recording artefacts;
    effects with other laws than those of the catalogue; recordings of hardware whose cause is withheld; pairs of recordings with
    a change between them.

    There are three steps: `make` records cases with simulators that share no code with the model, and seals the answers outside
    the folder; `run` diagnoses every recording from its folder alone; `score` opens the answers. `make` and `run` continue where
    they were interrupted.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is imported, as processes and not threads share the cores


@command.command(name="make")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed of all cases; keep it secret until the score.")
@click.option("--cases", type=click.IntRange(1, 999), help="Number of cases, divided among the tiers.  [default: 300]")
@click.option(
    "--tier", "tiers", metavar="NAME=N", multiple=True, help="Cases of a tier: clean, messy, forms or space; may be repeated."
)
@click.option("--real", metavar="DIR", type=_FILE, help="Recordings of hardware, for more cases with a withheld cause.")
@click.option("--change", metavar="N", type=click.IntRange(1, 999), help="Make N pairs of recordings with a change instead.")
@click.option("-o", "folder", metavar="DIR", type=_FILE, required=True, help="New folder for the recordings.")
@click.option("--answers", metavar="FILE", type=_FILE, help="File for the sealed answers.  [default: DIR-answers.json]")
@_JOBS
@force_option
def make_command(seed: int, folder: Path, answers: Path | None, jobs: int, real: Path | None, force: bool, **what: Any) -> None:
    """Record cases without labels, and seal their answers."""
    from hsr_pin.blind.make import check_answers, make
    from hsr_pin.blind.workshop import Workshop
    from hsr_pin.cli.console import print_text

    workshop = Workshop(recordings=real)
    cases = _planned(seed, workshop, **what)
    check_answers(folder, answers, force)
    with counted("recording", len(cases)) as advance:
        file = make(folder, seed, cases, answers, jobs=jobs, workshop=workshop, advance=advance)
    print_text(f"wrote {folder}, {file}")


def _planned(seed: int, workshop: Workshop, cases: int | None, tiers: tuple[str, ...], change: int | None) -> tuple[Case, ...]:
    """Return the cases that the options describe."""
    from hsr_pin.blind.real.build import plan_real
    from hsr_pin.blind.tiers import by_shares, plan, plan_changes, shuffled

    if change is not None:
        if cases or tiers or workshop.recordings:
            raise InputError(
                "--change", expected="no other cases in the same folder", hint="leave out --cases, --tier and --real"
            )
        return shuffled(seed, plan_changes(seed, change, workshop.programs))
    if cases and tiers:
        raise InputError("cases", expected="either --cases, or --tier for each tier", received="both")
    real = plan_real(seed, workshop.recordings) if workshop.recordings else ()
    counts = _counts(tiers) if tiers else {} if real and not cases else by_shares(cases or 300)
    chosen = (*plan(seed, counts, workshop.programs), *real)
    if not chosen:
        raise InputError("cases", expected="one or more", received="none")
    return shuffled(seed, chosen)


def _counts(tiers: tuple[str, ...]) -> dict[str, int]:
    counts = {}
    for text in tiers:
        name, _, number = text.partition("=")
        if not number.isdecimal():
            raise InputError("--tier", expected="NAME=N, such as messy=160", received=text)
        counts[name] = int(number)
    return counts


@command.command(name="run")
@_FOLDER
@_JOBS
@_CLUSTER
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the resampling.")
@click.option("-o", "verdicts", metavar="DIR", type=_FILE, help="Folder for the verdicts.  [default: DIR/verdicts]")
def run_command(folder: Path, jobs: int, cluster: str | None, seed: int, verdicts: Path | None) -> None:
    """Diagnose every recording in DIR that has no verdict yet."""
    from hsr_pin.blind.diagnoses import diagnose_all, failed, recordings
    from hsr_pin.cli.console import print_text

    target, names = verdicts or folder / "verdicts", [path.name for path in recordings(folder)]
    with counted("diagnosing", len(names)) as advance:
        diagnose_all(folder, target, jobs=jobs, cluster=cluster, seed=seed, advance=advance)
    errors = [f"{name}: {error}" for name, error in failed(target).items() if name in names]
    if len(errors) == len(names):
        hint = f"the other errors are in {target}; hsr-blind run tries the cases again"
        raise InputError("no case could be diagnosed", received=errors[0], hint=hint, file=folder)
    print_text(f"wrote {target}")
    if errors:
        click.echo(
            one_line(f"{len(errors)} of {len(names)} cases could not be diagnosed, and count as errors: {errors[0]}"), err=True
        )


@command.command(name="score")
@_FOLDER
@click.option("--answers", metavar="FILE", type=_FILE, help="File with the sealed answers.  [default: DIR-answers.json]")
@click.option("--verdicts", metavar="DIR", type=_FILE, help="Folder with the verdicts.  [default: DIR/verdicts]")
@click.option("--oracle", is_flag=True, help="Also fit the true laws, to show the possible reduction of the gap.")
@_JOBS
@_CLUSTER
@click.option("--json", "json_file", metavar="FILE", type=_FILE, help="Write the score for programs.")
@_PLOT
@_TRUST
@force_option
def score_command(folder: Path, answers: Path | None, verdicts: Path | None, jobs: int, **options: Any) -> None:
    """Open the answers and print how often the diagnosis was right."""
    from hsr_pin.blind.answers import SEAL, unseal
    from hsr_pin.blind.changes import score_changes
    from hsr_pin.blind.diagnoses import read_verdicts
    from hsr_pin.blind.make import default_answers
    from hsr_pin.blind.oracle import consult, read_oracle
    from hsr_pin.blind.scoring import score

    answers, verdicts = answers or default_answers(folder.resolve()), verdicts or folder / "verdicts"
    state = [answers, folder / SEAL, *verdicts.glob("*.json"), *folder.glob("oracle/*.json"), *folder.glob("case_*")]
    _check(options, state)
    truth = unseal(folder, answers)
    if truth and all(answer.tier == "change" for answer in truth):
        _print_and_write_changes(score_changes(truth, read_verdicts(verdicts)), options)
        return
    if options["oracle"]:
        with counted("oracle", sum(answer.kind in ("single", "pair") for answer in truth)) as advance:
            consult(folder, folder / "oracle", truth, jobs=jobs, cluster=options["cluster"], advance=advance)
    found = score(truth, read_verdicts(verdicts), read_oracle(folder / "oracle"))
    _print_and_write(found, options)


def _check(options: dict[str, Any], read: list[Path]) -> None:
    """Check that the requested files can and may be written, before anything is computed."""
    pictures = {"--plot": options["plot_file"], "--reliability": options["trust_file"]}
    if any(pictures.values()):
        from hsr_pin.replay.plots import picture_format

        for file in filter(None, pictures.values()):
            picture_format(file)
    check_outputs({"--json": options.get("json_file"), **pictures}, read=read, force=options["force"])


def _print_and_write_changes(found: ChangeScore, options: dict[str, Any]) -> None:
    from hsr_pin.cli.blind_report import report_changes
    from hsr_pin.cli.console import ignore_closed_pipe, print_text

    for option, name in (("--oracle", "oracle"), ("--plot", "plot_file"), ("--reliability", "trust_file")):
        if options.get(name):
            raise InputError("pairs of recordings", expected="only --json, without pictures and oracle", received=option)
    with ignore_closed_pipe():
        print_text(report_changes(found))
    if options.get("json_file"):
        _write(found, options["json_file"])


def _write(found: Score | ChangeScore, file: Path) -> None:
    """Write a score as JSON."""
    from hsr_pin.cli.console import print_text
    from hsr_pin.output import write_text

    write_text(file, json.dumps(found.document(), indent=1, allow_nan=False) + "\n")
    print_text(f"wrote {file}")


@command.command(name="show")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@_PLOT
@_TRUST
@force_option
def show_command(file: Path, **options: Any) -> None:
    """Print a score that was written with --json."""
    from hsr_pin.blind.changes import scored_changes
    from hsr_pin.blind.scoring import scored
    from hsr_pin.recordings.files import LARGEST_RESULT
    from hsr_pin.recordings.text import read_text

    _check(options, [file])
    try:
        document = json.loads(read_text(file, LARGEST_RESULT))
    except (ValueError, RecursionError) as error:
        received = getattr(error, "received", None) or error
        raise InputError("score", expected="a file written by hsr-blind score --json", received=received, file=file) from error
    if isinstance(document, dict) and "pairs" in document:
        _print_and_write_changes(scored_changes(document), options)
    else:
        _print_and_write(scored(document), options)


def _print_and_write(found: Score, options: dict[str, Any]) -> None:
    """Print a score and write the files."""
    from hsr_pin.cli.blind_report import report
    from hsr_pin.cli.console import ignore_closed_pipe, print_text

    trust = found.reliability() if options["trust_file"] else None
    if options["trust_file"] and trust is None:
        raise InputError("reliability", expected="verdicts that state a confidence", received="none")
    with ignore_closed_pipe():
        print_text(report(found))
    if options.get("json_file"):
        _write(found, options["json_file"])
    if options["plot_file"]:
        from hsr_pin.blind.picture import draw

        draw(found, options["plot_file"])
        print_text(f"wrote {options['plot_file']}")
    if trust and options["trust_file"]:
        from hsr_pin.blind.picture import draw_reliability

        draw_reliability(trust, options["trust_file"])
        print_text(f"wrote {options['trust_file']}")


def main() -> None:
    """Entry point of ``hsr-blind``."""
    exit_process(run(command))
