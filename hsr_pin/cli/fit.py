"""Command ``hsr-fit``: identify the parameters of an arm from its recordings."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.arm import chain_from, chain_options
from hsr_pin.cli.command import Grouped, exit_process, run
from hsr_pin.cli.judging import progress
from hsr_pin.cli.outputs import check_outputs, dataset_argument, dataset_folder, force_option
from hsr_pin.cli.trials import listed, trial_options, trials_from

if TYPE_CHECKING:
    from hsr_pin.effects.effect import Effect
    from hsr_pin.identification.identify import Identification
    from hsr_pin.identification.links_study import LinksStudy
    from hsr_pin.identification.paper_procedure import PaperProcedure
    from hsr_pin.identification.profile import Profile

_EPILOG = "Example: hsr-fit valve-arm --free keq,damping --by-level --urdf fitted.urdf"
#: Number of progress stages of the fit itself.
_STAGES = 4


@click.command(name="hsr-fit", cls=Grouped, epilog=_EPILOG, context_settings={"max_content_width": 100})
@dataset_argument
@click.option(
    "--free",
    default="keq,damping",
    show_default=True,
    metavar="A,B,...",
    help="Parameters to fit: keq, damping, mass, gain (factors on the declared values), drift (of the stiffness over the "
    "session), an effect, or effect.parameter; with the suffix @each, one for each declared Keq.",
)
@click.option("--by-level", is_flag=True, help="Fit stiffness and damping for each declared Keq instead of one factor for all.")
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="NAME[:PARAM=VALUE]",
    help="Add an effect and fit all its parameters, starting from these values; may be repeated.",
)
@chain_options
@trial_options
@click.option("--profile", is_flag=True, help="Also compute intervals by profile likelihood.")
@click.option("--paper", is_flag=True, help="Also run the procedure of the paper (its chain, C by brute force).")
@click.option("--links-study", "study", is_flag=True, help="Compare numbers of links and recommend one.")
@click.option("--json", "json_file", metavar="FILE", help="Write the result for programs; - for standard output.")
@click.option("--plot", "plot_file", metavar="FILE.png", help="Draw measured, declared and fitted motion (.png, .pdf or .svg).")
@click.option("--urdf", "urdf_file", metavar="FILE.urdf", help="Write the fitted arm; one file for each stiffness level.")
@force_option
def command(dataset: str, **options: Any) -> None:
    """Fit the parameters of a hybrid soft robot to its recordings, with 95 % intervals.

    Prints every value with its interval, the error before and after the fit, and the error on held-out trials: those given by
    --test, or else each trial predicted by a fit to the others.
    """
    _check(dataset, options)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is imported, as its threads slow down these small problems
    with progress(_STAGES + sum(bool(options[name]) for name in ("profile", "paper", "study"))) as (report_stage, _):
        found = _identified(dataset, options, report_stage)
        profiles, paper, study = _more(found, options, report_stage)
    _print_and_write(found, profiles, paper, study, options)


def _identified(dataset: str, options: dict[str, Any], report_stage: Callable[[str], None]) -> Identification:
    from hsr_pin.identification.choice import choose
    from hsr_pin.identification.identify import identify
    from hsr_pin.recordings.read import read_dataset

    free, effects = listed(options["free"]), [_effect(text) for text in options["effects"]]
    # refuses unknown names before the recordings are read, which takes longer
    choose([name.partition("@")[0] for name in free], effects, ())
    return identify(
        read_dataset(dataset),
        free=free,
        effects=effects,
        by_level=options["by_level"],
        **chain_from(options),
        **trials_from(options),
        tell=report_stage,
    )


def _more(
    found: Identification, options: dict[str, Any], report_stage: Callable[[str], None]
) -> tuple[list[Profile], PaperProcedure | None, LinksStudy | None]:
    """Return the profiles, the procedure of the paper and the study of links as requested; None or empty otherwise."""
    profiles, paper, study = [], None, None
    if options["profile"]:
        from hsr_pin.identification.profile import profile_likelihood

        report_stage("profile likelihood")
        profiles = [profile_likelihood(found.experiment, found.fit, name) for name in found.fit.hypothesis.free]
    if options["paper"]:
        from hsr_pin.identification.paper_procedure import paper_procedure

        report_stage("procedure of the paper")
        paper = paper_procedure(found.experiment)
    if options["study"]:
        from hsr_pin.identification.links_study import links_study

        report_stage("comparison of numbers of links")
        study = links_study(found.experiment, found.fit.hypothesis, found.fit.values)
    return profiles, paper, study


def _effect(text: str) -> Effect:
    from hsr_pin.effects.catalogue import effect_named, parse_effect
    from hsr_pin.effects.effect import neutral

    return parse_effect(text) if ":" in text else neutral(effect_named(text.strip()))


def _check(dataset: str, options: dict[str, Any]) -> None:
    """Check that the requested files can and may be written, before anything is computed."""
    files = {f"--{name}": options[f"{name}_file"] for name in ("json", "plot", "urdf")}
    if options["plot_file"] is not None:
        from hsr_pin.replay.plots import picture_format

        picture_format(options["plot_file"])
    check_outputs(files, read=[dataset_folder(dataset)], force=options["force"])


def _print_and_write(
    found: Identification,
    profiles: list[Profile],
    paper: PaperProcedure | None,
    study: LinksStudy | None,
    options: dict[str, Any],
) -> None:
    """Print the results of the fit and write the files."""
    import json

    from hsr_pin.cli.console import ignore_closed_pipe, print_written_files
    from hsr_pin.cli.fit_report import print_fit
    from hsr_pin.identification.document import to_json

    document = to_json(found, profiles=profiles, paper=paper, study=study)
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False)
    with ignore_closed_pipe():
        if options["json_file"] == "-":
            click.echo(text)
        else:
            print_fit(found, profiles, paper, study)
    written: list[str] = []
    try:
        for path in _write(found, text, options):
            written.append(path)
    finally:
        if options["json_file"] != "-":
            print_written_files(written)


def _write(found: Identification, document: str, options: dict[str, Any]) -> Iterator[str]:
    """Write the requested files, and yield the name of each file once it is written."""
    if options["urdf_file"] is not None:  # first, as it fails for an arm of sections, and then nothing is written
        yield from _write_arms(found, options)
    if options["json_file"] not in (None, "-"):
        from hsr_pin.output import write_text

        write_text(options["json_file"], document + "\n")
        yield options["json_file"]
    if options["plot_file"] is not None:
        from hsr_pin.identification.figure import fit_figure
        from hsr_pin.replay.plots import save

        save(fit_figure(found), options["plot_file"])
        yield options["plot_file"]


def _write_arms(found: Identification, options: dict[str, Any]) -> Iterator[str]:
    from hsr_pin.identification.fitted_arms import fitted_arms
    from hsr_pin.robot.urdf import save_urdf

    arms = fitted_arms(found.experiment, found.fit)
    stem, ending = os.path.splitext(options["urdf_file"])
    for keq, arm in arms.items():
        name = options["urdf_file"] if len(arms) == 1 else f"{stem}_keq{keq:g}{ending}"
        check_outputs({"--urdf": name}, force=options["force"])  # checked now, as the files depend on the fitted stiffness levels
        save_urdf(arm, name)
        yield name


def main() -> None:
    """Entry point of ``hsr-fit``."""
    exit_process(run(command))
