"""Command ``hsr-diagnose``: locate the sim-to-real gap, name the effects that cause it, and predict its reduction."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import chain_from, chain_options
from hsr_pin.cli.command import Grouped, exit_process, run
from hsr_pin.cli.judging import effects_from, loss_from, print_and_write, progress
from hsr_pin.cli.outputs import check_outputs, dataset_argument, dataset_folder, force_option
from hsr_pin.cli.trials import trial_options, trials_from
from hsr_pin.parallel import open_executor

if TYPE_CHECKING:
    from hsr_pin.diagnosis.result import Diagnosis

#: Number of progress stages in addition to the effects: reading, fit of stiffness and damping, localisation.
_OTHER_STAGES = 3

_EPILOG = "Example: hsr-diagnose sample --html report.html"


@click.command(name="hsr-diagnose", cls=Grouped, epilog=_EPILOG, context_settings={"max_content_width": 100})
@dataset_argument
@click.option(
    "--since", metavar="OLD", multiple=True, help="Report what has changed since this recording of the same arm; repeat in order."
)
@click.option("--effects", metavar="A,B,...", help="Candidate effects.  [default: the whole catalogue]")
@click.option("--max-effects", type=click.IntRange(0, 19), default=3, show_default=True, help="Most effects in one model.")
@chain_options
@trial_options
@click.option("--jobs", type=click.IntRange(1, 1000), metavar="N", help="Number of processes.  [default: one per core]")
@click.option("--cluster", metavar="ADDRESS", help="Dask scheduler whose workers run the fits, in place of local processes.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the resampling.")
@click.option("--loss", metavar="A=N,...", help="Gain or loss of each kind of report, e.g. wrong_name=-8 (docs/evidence.md).")
@click.option("--json", "json_file", metavar="FILE", help="Write the diagnosis for programs; - for standard output.")
@click.option("--html", "html_file", metavar="FILE", help="Write a self-contained report.")
@force_option
def command(dataset: str, **options: Any) -> None:
    """Diagnose the gap between a simulated and a recorded hybrid soft robot.

    DATASET is a folder of recordings, or the name of a sample (--list-samples). The model is fitted with and without effects that
    it may lack. The result is the probability of each cause: missing effects, alternatives that the recordings cannot tell apart,
    another stiffness and damping, or an unknown cause.

    With --since OLD the command reports what has changed in the arm since that recording: it compares DATASET with the prediction
    of the best model of OLD.

    DATASET may also be a folder with recordings of a rigid-link robot (robot.toml). The causes are then those of its joints.
    """
    files = {f"--{name}": options[f"{name}_file"] for name in ("json", "html")}
    check_outputs(files, read=[dataset_folder(each) for each in (dataset, *options["since"])], force=options["force"])
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is imported, as processes and not threads share the cores
    from hsr_pin.recordings.samples import ROBOTS

    if os.path.isfile(os.path.join(dataset, "robot.toml")) or dataset in ROBOTS:
        from hsr_pin.cli.robot import run_robot

        run_robot(dataset, options)
        return
    if options["since"]:
        from hsr_pin.cli.since import run_since

        run_since(dataset, options)
        return
    found = _diagnosis(dataset, options)
    from hsr_pin.cli.diagnose_report import print_report

    written = [name for name in files.values() if name not in (None, "-")]
    print_and_write(options, found.to_json, lambda: print_report(found, written), found.to_html)


def _diagnosis(dataset: str, options: dict[str, Any]) -> Diagnosis:
    from hsr_pin.recordings.read import read_dataset

    effects = effects_from(options)
    given = {name: options[name] for name in ("max_effects", "seed")} | chain_from(options) | trials_from(options)
    loss = loss_from(options)
    with open_executor(options["jobs"], options["cluster"]) as executor:
        recordings = read_dataset(dataset)
        from hsr_pin.diagnosis.diagnose import diagnose

        with progress(options["max_effects"] + _OTHER_STAGES) as (report_stage, advance):
            given |= {"tell": report_stage, "advance": advance}
            return diagnose(recordings, effects=effects, loss=loss, **given, executor=executor)


def main() -> None:
    """Entry point of ``hsr-diagnose``."""
    exit_process(run(command))
