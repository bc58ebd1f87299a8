"""Command ``hsr-import``: convert motion capture files to a dataset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.command import exit_process, run
from hsr_pin.cli.outputs import force_option

if TYPE_CHECKING:
    from hsr_pin.recordings.importers.assemble import Imported
    from hsr_pin.recordings.importers.mapping import TableMapping
    from hsr_pin.recordings.importers.settings import ImportSettings
    from hsr_pin.trajectory import Marker


@click.command(name="hsr-import")
@click.argument("files", nargs=-1, metavar="FILE...")
@click.option("-o", "--output", metavar="DATASET", help="Folder for the dataset.")
@click.option("--guess", metavar="TABLE", help="Write a draft mapping guessed from this table, to -o or the screen.")
@click.option("--list", "list_points", is_flag=True, help="Only list the points in the files, with rate, unit and gaps.")
@click.option(
    "--map",
    "mapping",
    metavar="TOML",
    help="Mapping of the columns of a table, which may also describe the arm (docs/importing.md).",
)
@click.option(
    "-m",
    "--marker",
    "markers",
    multiple=True,
    metavar="NAME[@ARC]=POINT[+POINT...]",
    help="A marker, its arc length from the base [m] (estimated from the straight pose if not given), and the points whose mean "
    "it is, or its labels if they are never seen together; patterns (Tip*) are allowed. Repeat for each marker. In space, "
    "NAME@ARC,RADIUS[,ANGLE] is a marker beside the backbone [m, rad].  [default: every named point]",
)
@click.option("--base", metavar="POINT[+POINT...]", help="Point or points at the base.  [default: a point named base, if any]")
@click.option("--origin", metavar="X,Y,Z", help="Position of the base in the laboratory [m].  [default: from the base points]")
@click.option("--up", metavar="AXIS", help="Upward axis of the laboratory: +z, -y, ...  [default: of the tracking system]")
@click.option(
    "--mount",
    metavar="MOUNT",
    help="Mount: hanging, upright, horizontal or flat (bending in a horizontal plane).  [default: from the straight pose]",
)
@click.option("--bending", metavar="WORD", help="Bending in a plane (plane) or about two axes (space).  [default: plane]")
@click.option(
    "--x",
    metavar="AXIS",
    help="Axis of the laboratory towards which positive bending moves the tip; in space also a direction X,Y,Z, or input: from "
    "the input.  [default: from the input; in space the first axis perpendicular to the arm]",
)
@click.option("--torsion", type=float, metavar="NM/RAD", help="Torsional stiffness in space.  [default: no twist]")
@click.option(
    "--pose", "poses", multiple=True, metavar="NAME", help="Marker whose orientation is imported too, in space; repeat for each."
)
@click.option("--own-plane", is_flag=True, help="Fit a bending plane to each file instead of all files together.")
@click.option("--unit", metavar="UNIT", help="Unit of length (mm, cm, m or in), in place of that in the files.")
@click.option("--length", type=float, metavar="M", help="Arc length of the arm.  [default: that of the outermost marker]")
@click.option("--mass", type=float, metavar="KG", help="Mass of the arm.  [required]")
@click.option("--diameter", type=float, metavar="M", help="Diameter of the arm.  [required]")
@click.option(
    "--keq", type=float, multiple=True, metavar="NM/RAD", help="Bending stiffness; one value, or one per file.  [required]"
)
@click.option(
    "--damping", type=float, multiple=True, metavar="NMS/RAD", help="Damping of the whole arm; one value, or one per file."
)
@click.option("--tip-mass", type=float, multiple=True, metavar="KG", help="Payload at the tip; one value, or one per file.")
@click.option("--t-start", multiple=True, metavar="S", help="Start of the used part; -: the beginning; one, or one per file.")
@click.option(
    "--cut",
    metavar="S[,S...]",
    help="Times at which new trials begin in every file; auto: where the arm rests.  [default: one trial per file]",
)
@click.option(
    "--input",
    "inputs",
    multiple=True,
    metavar="CSV",
    help="Input with columns t,P1,P2 or t,tau (in space t,tau_x,tau_y), or as given by --map; -: none; one, or one per file.",
)
@click.option(
    "--input-offset",
    "input_offset",
    multiple=True,
    metavar="S",
    help="Time added to the times of the input [s]; auto: estimated from motion and command; one value, or one per file.",
)
@click.option(
    "--gain", type=float, metavar="NM/BAR", help="In space: torque per unit of all columns of --input, evenly spaced chambers."
)
@click.option(
    "--angle", type=float, metavar="RAD", help="Angle of the first chamber, from x towards y of the base.  [default: 0]"
)
@click.option("--name", metavar="TEXT", help="Name of the dataset.  [default: that of its folder]")
@click.option("--description", default="", metavar="TEXT", help="Description of the dataset, one line.")
@force_option
def command(files: tuple[str, ...], list_points: bool, output: str | None, **options: Any) -> None:
    """Import motion capture as a dataset, one trial per FILE.

    Reads CSV files of Vicon Nexus, Vicon Tracker and OptiTrack Motive, TSV files of Qualisys, TRC and C3D files, ROS 1 and ROS 2
    bags, and any table (text, Excel, MATLAB) with a mapping. Lengths are converted to metres and positions to a frame with z up,
    the origin at the base and the bending plane in x-z. The motion of an arm in space (--bending space) is not reduced to a
    plane.

    \b
    hsr-import run1.csv run2.csv -o my-arm --mass 0.15 --diameter 0.04 --keq 1.11 \\
        --base Arm:base -m mid@0.12=Arm:m1+Arm:m2 -m tip@0.24=Arm:tip
    hsr-import take.csv -o my-arm --bending space --map my-arm.toml --input pressures.csv
    """  # noqa: D301 (the backspace is click's mark for preformatted text)
    if options["guess"] is not None:
        _guess(options["guess"], output, options["force"])
        return
    if not files:
        raise click.UsageError("Missing argument 'FILE...'.")
    if list_points:
        _list(files, options["unit"], _mapping(options["mapping"]))
        return
    if output is None:
        raise click.UsageError("Missing option '--output'.")
    options["output"] = output
    from hsr_pin.cli.folders import check_folder
    from hsr_pin.recordings.importers.assemble import import_recordings
    from hsr_pin.recordings.write import write_dataset

    read = [*files, *options["inputs"], options["mapping"]]
    check_folder(options["output"], "hsr-import", read, options["force"], [Path(file).name for file in files])
    imported = import_recordings(files, _settings(options))
    write_dataset(imported.dataset, options["output"])
    _report(imported, options["output"])
    for warning in imported.warnings:
        click.echo(f"warning: {warning}", err=True)


def _settings(options: dict[str, Any]) -> ImportSettings:
    from hsr_pin.recordings.importers.bodies import Body
    from hsr_pin.recordings.importers.declared import declared_settings
    from hsr_pin.recordings.importers.detect import NOTHING
    from hsr_pin.recordings.importers.settings import AUTO

    bodies = [Body.parse(text) for text in options["markers"]]
    if options["base"] is not None:
        bodies.insert(0, Body.parse(f"base@0={options['base']}"))
    same = ("mass", "diameter", "keq", "length", "mount", "up", "bending", "x", "unit", "own_plane", "damping", "tip_mass")
    return declared_settings(
        _mapping(options["mapping"]),
        poses=options["poses"],
        **{name: options[name] for name in (*same, "inputs", "description", "torsion", "gain", "angle")},
        name=options["name"] or _name_of(options["output"]),
        markers=bodies,
        t_start=[None if text == NOTHING else _seconds(text, "--t-start", NOTHING) for text in options["t_start"]],
        input_offset=[AUTO if text == AUTO else _seconds(text, "--input-offset", AUTO) for text in options["input_offset"]],
        origin=None if options["origin"] is None else _point(options["origin"]),
        cut=None if options["cut"] is None else _cut(options["cut"]),
    )


def _name_of(output: str) -> str:
    name = Path(output).resolve().name or "imported"
    if not name.isprintable():
        hint = "give the dataset a name with --name"
        raise click.BadParameter(f"expected a folder with a printable name, got {name!r}; {hint}", param_hint="'--output'")
    return name


def _seconds(text: str, option: str, other: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"expected a time in s, or {other}, got {text!r}", param_hint=f"'{option}'") from None


def _cut(text: str) -> tuple[float, ...] | str:
    from hsr_pin.recordings.importers.cut import parse_cut

    try:
        return parse_cut(text)
    except ValueError:
        raise click.BadParameter(f"expected times in s, as in 12.5,30, or auto, got {text!r}", param_hint="'--cut'") from None


def _point(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"expected X,Y,Z in m, got {text!r}", param_hint="'--origin'") from None


def _mapping(path: str | None) -> TableMapping | None:
    from hsr_pin.recordings.importers.mapping import read_mapping

    return None if path is None else read_mapping(path)


def _guess(table: str, output: str | None, force: bool) -> None:
    from hsr_pin.cli.console import print_text, print_written_files
    from hsr_pin.errors import OutputError
    from hsr_pin.output import check_writable, write_text
    from hsr_pin.recordings.importers.guess import guessed_mapping

    if output is None:
        print_text(guessed_mapping(Path(table)).rstrip("\n"))
        return
    if Path(output).exists() and not force:
        hint = "--force replaces it"
        expected = "a new file for the mapping"
        raise OutputError("will not replace the file", expected=expected, received="an existing file", hint=hint, file=output)
    check_writable(output)
    write_text(output, guessed_mapping(Path(table)))
    print_written_files([output])


def _list(files: tuple[str, ...], unit: str | None, mapping: TableMapping | None) -> None:
    import numpy as np

    from hsr_pin.cli.console import print_text
    from hsr_pin.recordings.importers.detect import read_capture

    for path in files:
        capture = read_capture(path, unit, mapping)
        rows, posed = [], [["yes" if name in capture.orientations else ""] for name in capture.names]
        for name, places in zip(capture.names, capture.positions.swapaxes(0, 1), strict=True):
            seen = np.isfinite(places).all(axis=1)
            edges = np.flatnonzero(np.diff(np.concatenate([[True], seen, [True]])))
            longest = max(edges[1::2] - edges[::2], default=0) / capture.rate
            middle = [f"{value:.4f}" for value in np.median(places[seen], axis=0)] if seen.any() else ["", "", ""]
            gaps = [str(len(edges) // 2), f"{longest:.3g}"] if len(edges) else ["", ""]
            rows.append([name, f"{seen.mean():.0%}", *gaps, *middle])
        up = f"{capture.up.axis} up {capture.up.reason}" if capture.up.axis else f"up unknown: {capture.up.reason}"
        timing = f"{len(capture.time)} frames, {capture.time[-1]:.3f} s, {capture.rate:.6g} Hz"
        print_text(f"{path}: {capture.system}, {timing}, in {capture.unit}, {up}")
        headings = ["point", "seen", "gaps", "longest s", "x [m]", "y [m]", "z [m]"]
        if capture.orientations:
            headings, rows = [*headings, "pose"], [[*row, *pose] for row, pose in zip(rows, posed, strict=True)]
        _table(headings, rows)


def _report(imported: Imported, output: str) -> None:
    import numpy as np

    from hsr_pin.cli.console import print_text
    from hsr_pin.recordings.noise import noise_floor

    dataset, rows = imported.dataset, []
    for trial, path, within, out in zip(dataset.trials, imported.files, imported.in_plane, imported.out_of_plane, strict=True):
        trajectory, noise = trial.trajectory, noise_floor(trial)
        quiet = f"{1e3 * np.nanmax(noise):.3f}" if np.isfinite(noise).any() else ""
        missing = f"{np.isnan(trajectory.positions).any(axis=2).mean():.1%}"
        rate = f"{1 / trajectory.step:.4g}"
        rows.append(
            [
                trial.name,
                path.name,
                str(len(trajectory.time)),
                rate,
                missing,
                quiet,
                f"{1e3 * within:.2f}",
                f"{1e3 * out:.2f}",
            ]
        )
    parts = f" in {len(dataset.sections)} sections" if dataset.sections else ""
    space = " that bends in space" if dataset.bending == "space" else ""
    print_text(f"{output}: {dataset.mount} arm of {dataset.length:.4g} m{parts}{space}")
    print_text("markers: " + ", ".join(map(_placed, dataset.markers)))
    _table(["trial", "file", "samples", "Hz", "missing", "noise mm", "in plane mm", "out of plane mm"], rows)
    for note in dataset.notes:
        print_text(f"  {note}")
    for trial in dataset.trials:
        for note in trial.trajectory.notes:
            print_text(f"  {trial.name}: {note}")


def _placed(marker: Marker) -> str:
    offset = f", {marker.radius:.4g} m beside the backbone at {marker.angle:.4g} rad" if marker.radius else ""
    return f"{marker.name} at {marker.arc_length:.4g} m{offset}"


def _table(headings: list[str], rows: list[list[str]]) -> None:
    from rich.table import Table

    from hsr_pin.cli.console import console

    table = Table()
    words = {"point", "trial", "file"}
    for heading in headings:
        table.add_column(heading, justify="left" if heading in words else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console().print(table)


def main() -> None:
    """Entry point of ``hsr-import``."""
    exit_process(run(command))
