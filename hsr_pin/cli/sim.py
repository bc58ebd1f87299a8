"""Command ``hsr-sim``: simulate an arm and print, show or save its motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import arm_options, effect_option
from hsr_pin.cli.command import Grouped, exit_process, run
from hsr_pin.cli.outputs import check_outputs, force_option

if TYPE_CHECKING:
    from hsr_pin.cli.sim_runs import Run

_EPILOG = "Example: hsr-sim --links 4 --keq 1.11 runs the three pressure combinations that the paper tabulates for 1.11 Nm/rad."


@click.command(name="hsr-sim", cls=Grouped, epilog=_EPILOG, context_settings={"max_content_width": 100})
@arm_options
@click.option(
    "--pressures",
    type=(float, float),
    multiple=True,
    metavar="P1 P2",
    help="Step to these pressures [bar]; may be repeated. Without --keq, Eq. (1) gives the stiffness.",
)
@click.option("--torque", type=float, multiple=True, metavar="TAU", help="Step to this torque [N m]; may be repeated.")
@click.option(
    "--direction", type=float, metavar="X", help="Direction of the torques in space, from x towards y [rad].  [default: 0]"
)
@click.option(
    "--input",
    "input_file",
    metavar="FILE.csv",
    help="Use the input of a file with columns t,P1,P2 or t,tau or, in space, t,tau_x,tau_y [s, bar, N m].",
)
@click.option("--duration", type=float, metavar="T", help="Length of a run [s].  [default: 3, or the length of --input]")
@click.option(
    "--dynamics",
    type=click.Choice(["aba", "rnea", "compiled"]),
    help="Dynamics: Pinocchio's articulated-body algorithm (aba) or recursive Newton-Euler algorithm (rnea), or compiled loops "
    "(compiled).  [default: aba, in space rnea; compiled beyond 64 links]",
)
@effect_option
@click.option("--ground", type=float, multiple=True, metavar="Z", help="Add a floor at this height [m]; the base is at 0.")
@click.option("--wall", type=float, multiple=True, metavar="X", help="Add a wall across x at this place [m], facing the base.")
@click.option(
    "--post",
    type=(float, float, float),
    multiple=True,
    metavar="X Z R",
    help="Add a post across the plane of the arm, with its centre and its radius [m]; may be repeated.",
)
@click.option(
    "--material",
    metavar="WORD",
    default="silicone",
    show_default=True,
    help="Softer surface of arm and obstacles: foam, silicone, rubber, plastic or metal.",
)
@click.option(
    "--against",
    metavar="DATASET",
    help="Simulate the trials of a recording and print the error. The recording determines the arm; --links, --placement and "
    "--effect determine the model.",
)
@click.option("--csv", "csv_folder", metavar="DIR", help="Write a dataset in the recording format.")
@click.option("--plot", metavar="FILE.png", help="Draw the tip trajectories (.png, .pdf or .svg).")
@click.option("--html", metavar="FILE.html", help="Write a self-contained animation.")
@click.option("--replay", is_flag=True, help="Open the animation in the browser.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document, for programs (SI units).")
@force_option
def command(**options: Any) -> None:
    """Simulate a hybrid soft robot as a chain of rigid links.

    The arm starts at rest and steps to one or several pressure pairs or torques. The command prints the settled position of the
    tip, the settling time, and the distance of its path from a circle. A stiffness other than 1.11 and 2.33 Nm/rad needs
    --pressures or --torque.
    """
    if options["against"] is not None:
        _compare(options)
        return
    from hsr_pin.cli.sim_runs import common_dynamics, planned, simulated

    runs = planned(options)
    _check(options)
    options["dynamics"] = options["dynamics"] or common_dynamics(runs)
    _print_and_write(simulated(runs, options["dynamics"]), options)


def _print_and_write(runs: list[Run], options: dict[str, Any]) -> None:
    """Print the results, write the files and show the animation. JSON is printed last, as it contains the file names."""
    from hsr_pin.cli.console import ignore_closed_pipe, print_written_files
    from hsr_pin.cli.sim_report import print_json, print_table

    written: list[str] = []
    try:
        if not options["as_json"]:
            with ignore_closed_pipe():
                print_table(runs, options["dynamics"])
        for path in _write(runs, options):
            written.append(path)
    finally:
        if options["as_json"]:
            print_json(runs, options["dynamics"], written)
        else:
            print_written_files(written)
    if options["replay"]:
        from hsr_pin.replay.live import show

        show([run.drawn for run in runs])


#: Options that may be combined with ``--against``, as the recording does not determine them.
_WITH_AGAINST = ("material", "against", "links", "placement", "effects", "as_json", "dynamics")


def _compare(options: dict[str, Any]) -> None:
    import json

    from hsr_pin.cli.arm import arm_from
    from hsr_pin.cli.comparison_report import comparison_facts, print_comparison
    from hsr_pin.effects.catalogue import parse_effect
    from hsr_pin.errors import InputError
    from hsr_pin.identification.comparison import compare
    from hsr_pin.recordings.read import read_dataset

    more = [name for name, value in options.items() if value and name not in _WITH_AGAINST]
    if more:
        hint = "the recording determines arm and input; hsr-replay draws it"
        raise InputError(
            "--against", expected="only --links, --placement, --effect and --json with this option", received=more[0], hint=hint
        )
    arm = arm_from({name: options[name] for name in ("links", "placement")})
    effects = [parse_effect(text) for text in options["effects"]]
    dataset = read_dataset(options["against"])
    comparison = compare(dataset, links=arm.links, placement=arm.placement, effects=effects)
    if options["as_json"]:
        click.echo(json.dumps(comparison_facts(comparison), indent=2, allow_nan=False))
    else:
        print_comparison(comparison)


def _check(options: dict[str, Any]) -> None:
    """Check that the requested files can and may be written, before anything is computed."""
    if options["plot"] is not None:
        from hsr_pin.replay.plots import picture_format

        picture_format(options["plot"])
    files = {f"--{name}": options[name] for name in ("plot", "html")}
    check_outputs(files, read=[options["input_file"]], force=options["force"])
    if options["csv_folder"] is not None:
        from hsr_pin.cli.folders import check_folder

        check_folder(options["csv_folder"], "hsr-sim", [options["input_file"]], options["force"])


def _write(runs: list[Run], options: dict[str, Any]) -> Iterator[str]:
    """Write the requested files, and yield the name of each file once it is written."""
    if options["csv_folder"] is not None:
        from hsr_pin.cli.sim_runs import dataset
        from hsr_pin.recordings.write import write_dataset

        write_dataset(dataset(runs, options["dynamics"]), options["csv_folder"])
        yield options["csv_folder"]
    if options["plot"] is not None:
        from hsr_pin.replay.plots import save, tip_figure

        save(tip_figure([run.drawn for run in runs]), options["plot"])
        yield options["plot"]
    if options["html"] is not None:
        from hsr_pin.cli.sim_report import title
        from hsr_pin.replay.page import write_page

        write_page([run.drawn for run in runs], options["html"], text=[title(runs, options["dynamics"])])
        yield options["html"]


def main() -> None:
    """Entry point of ``hsr-sim``."""
    exit_process(run(command))


if __name__ == "__main__":
    main()
