"""Command ``hsr-replay``: show a recording beside its simulation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import chain_from, chain_options, effect_option
from hsr_pin.cli.command import Grouped, exit_process, run
from hsr_pin.cli.outputs import check_outputs, dataset_argument, dataset_folder, force_option

if TYPE_CHECKING:
    from hsr_pin.identification.comparison import Comparison, TrialComparison
    from hsr_pin.replay.drawn import Drawn


@click.command(name="hsr-replay", cls=Grouped, context_settings={"max_content_width": 100})
@dataset_argument
@click.option("--trial", metavar="N", help="Number of the trial, from 1, or its name.  [default: the first]")
@chain_options
@effect_option
@click.option("--html", metavar="FILE.html", help="Write the animation into one self-contained file.")
@click.option("--plot", metavar="FILE.png", help="Draw tip paths, markers and error against time (.png, .pdf or .svg).")
@click.option("--json", "as_json", is_flag=True, help="Print the errors as one JSON document, for programs.")
@click.option(
    "--live/--no-live", default=None, help="Open the animation in the browser.  [default: without --html, --plot, --json]"
)
@force_option
def command(dataset: str, **options: Any) -> None:
    """Show a recording beside the simulation of the same input, mount, payload and start, and print the error.

    DATASET is a folder in the recording format, or the name of a sample (--list-samples). The error is the distance from
    simulated to measured markers.
    """
    from hsr_pin.identification.comparison import compare

    asked = _checked(dataset, options)
    comparison = compare(**asked)
    chosen = _chosen(comparison, options["trial"])
    drawn = _drawn(comparison, chosen)
    written = _print_and_write(comparison, chosen, drawn, options)
    wanted = options["live"]
    if wanted or (wanted is None and not written and not options["as_json"]):
        from hsr_pin.replay.live import show

        show([drawn])


def _print_and_write(comparison: Comparison, chosen: TrialComparison, drawn: Drawn, options: dict[str, Any]) -> list[str]:
    """Print the errors and write the files; return the names of the files. JSON is printed last, as it contains the names."""
    import json

    from hsr_pin.cli.comparison_report import comparison_facts, print_comparison
    from hsr_pin.cli.console import ignore_closed_pipe, print_written_files

    only = chosen.name if options["trial"] is not None else None
    written: list[str] = []
    try:
        if not options["as_json"]:
            with ignore_closed_pipe():
                print_comparison(comparison, only)
        for path in _write(drawn, chosen, options):
            written.append(path)
    finally:
        if options["as_json"]:
            click.echo(json.dumps({**comparison_facts(comparison, only), "written": written}, indent=2, allow_nan=False))
        else:
            print_written_files(written)
    return written


def _checked(dataset: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of the comparison, after a check of all options and files."""
    from hsr_pin.effects.catalogue import parse_effect
    from hsr_pin.recordings.read import read_dataset

    effects = [parse_effect(text) for text in options["effects"]]
    if options["plot"] is not None:
        from hsr_pin.replay.plots import picture_format

        picture_format(options["plot"])
    files = {f"--{name}": options[name] for name in ("html", "plot")}
    check_outputs(files, read=[dataset_folder(dataset)], force=options["force"])
    return {"dataset": read_dataset(dataset), **chain_from(options), "effects": effects}


def _chosen(comparison: Comparison, trial: str | None) -> TrialComparison:
    """Return the trial to draw, by its number in the dataset or by its name.

    Raises:
        InputError: the trial does not exist, or could not be used.
    """
    from hsr_pin.errors import InputError

    if trial is None:
        return comparison.trials[0]
    names = [run.name for run in comparison.experiment.dataset.trials]
    name = names[int(trial) - 1] if trial.isdecimal() and 1 <= int(trial) <= len(names) else trial
    found = [run for run in comparison.trials if run.name == name]
    if not found:
        usable = ", ".join(run.name for run in comparison.trials)
        raise InputError("--trial", expected=f"1 to {len(names)}, or one of {usable}", received=trial)
    return found[0]


def _drawn(comparison: Comparison, trial: TrialComparison) -> Drawn:
    from hsr_pin.replay.drawn import Drawn

    return Drawn(f"{comparison.experiment.dataset.name}, {trial.name}", trial.arm, trial.simulated, trial.measured)


def _write(shown: Drawn, trial: TrialComparison, options: dict[str, Any]) -> Iterator[str]:
    """Write the requested files, and yield the name of each file once it is written."""
    if options["plot"] is not None:
        from hsr_pin.replay.plots import comparison_figure, save

        save(comparison_figure(shown), options["plot"])
        yield options["plot"]
    if options["html"] is not None:
        from hsr_pin.replay.page import write_page

        whole = trial.errors[-1]
        share = 100 * whole.rms / trial.arm.length
        text = f"RMS error over all markers: {1e3 * whole.rms:.2f} mm, {share:.2f} % of the arm's length"
        write_page([shown], options["html"], shown.label, [text])
        yield options["html"]


def main() -> None:
    """Entry point of ``hsr-replay``."""
    exit_process(run(command))
