"""``hsr-import``: motion capture into a dataset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hsr_pin.cli.command import leave, run
from hsr_pin.cli.outputs import force_option

if TYPE_CHECKING:
    from hsr_pin.recordings.importers.assemble import Imported
    from hsr_pin.recordings.importers.mapping import TableMapping
    from hsr_pin.recordings.importers.settings import ImportSettings
    from hsr_pin.trajectory import Marker


@click.command(name="hsr-import")
@click.argument("files", nargs=-1, metavar="FILE...")
@click.option("-o", "--output", metavar="DATASET", help="Folder to write the dataset into.")
@click.option(
    "--guess", metavar="TABLE", help="Write a mapping of this table, guessed from its names and numbers, to edit: to -o, or here."
)
@click.option("--list", "list_points", is_flag=True, help="Only list the points in the files, with rate, unit and gaps.")
@click.option(
    "--map",
    "mapping",
    metavar="TOML",
    help="What stands where in a table of no known system, and what the arm is like (docs/importing.md).",
)
@click.option(
    "-m",
    "--marker",
    "markers",
    multiple=True,
    metavar="NAME[@ARC]=POINT[+POINT...]",
    help="A marker, its arc length from the base [m] (else estimated from the straight pose), and the points it is the mean of, "
    "or its labels, if never seen together; patterns (Tip*) allowed. Again for each marker. In space NAME@ARC,RADIUS[,ANGLE] "
    "stands beside the backbone [m, rad].  [default: every named point]",
)
@click.option("--base", metavar="POINT[+POINT...]", help="The point or points at the base.  [default: one named base, if any]")
@click.option("--origin", metavar="X,Y,Z", help="Place of the base in the laboratory [m].  [default: from the base points]")
@click.option("--up", metavar="AXIS", help="Axis of the laboratory that is up: +z, -y, ...  [default: as its maker has it]")
@click.option("--mount", metavar="MOUNT", help="hanging, upright or horizontal.  [default: from the straight pose]")
@click.option("--bending", metavar="WORD", help="In a plane (plane) or about two axes (space).  [default: plane]")
@click.option(
    "--x",
    metavar="AXIS",
    help="Axis that positive bending carries the tip towards; in space also X,Y,Z, or input: as it shows.  [default: from the "
    "input; in space the first across the arm]",
)
@click.option(
    "--torsion", type=float, metavar="NM/RAD", help="Stiffness against twisting, in space.  [default: it does not twist]"
)
@click.option(
    "--pose", "poses", multiple=True, metavar="NAME", help="A marker whose orientation is taken too, in space; again for each."
)
@click.option("--own-plane", is_flag=True, help="Fit the bending plane to each file, not to all together.")
@click.option("--unit", metavar="UNIT", help="mm, cm, m or in, in place of what the files say.")
@click.option("--length", type=float, metavar="M", help="Arc length of the arm.  [default: of its farthest marker]")
@click.option("--mass", type=float, metavar="KG", help="Mass of the arm.  [needed]")
@click.option("--diameter", type=float, metavar="M", help="Diameter of the arm.  [needed]")
@click.option("--keq", type=float, multiple=True, metavar="NM/RAD", help="Bending stiffness; once, or once per file.  [needed]")
@click.option("--damping", type=float, multiple=True, metavar="NMS/RAD", help="Damping of the whole arm; likewise.")
@click.option("--tip-mass", type=float, multiple=True, metavar="KG", help="Payload at the tip; likewise.")
@click.option("--t-start", multiple=True, metavar="S", help="Use the recording from here on, - from its start; likewise.")
@click.option(
    "--input",
    "inputs",
    multiple=True,
    metavar="CSV",
    help="The input, t,P1,P2 or t,tau (in space t,tau_x,tau_y), or as --map says; - is none; likewise.",
)
@click.option(
    "--input-offset",
    "input_offset",
    multiple=True,
    metavar="S",
    help="Added to the times of the input [s]; auto: estimated from motion and command; likewise.",
)
@click.option(
    "--gain", type=float, metavar="NM/BAR", help="In space: all columns of --input are chambers evenly around the arm, of this."
)
@click.option(
    "--angle", type=float, metavar="RAD", help="Where the first of them lies, from x towards y of the base.  [default: 0]"
)
@click.option("--name", metavar="TEXT", help="Name of the dataset.  [default: of its folder]")
@click.option("--description", default="", metavar="TEXT", help="One line.")
@force_option
def command(files: tuple[str, ...], list_points: bool, output: str | None, **options: Any) -> None:
    """Import motion capture as a dataset, one trial per FILE.

    Reads CSV of Vicon Nexus and Tracker and of OptiTrack Motive, TSV of Qualisys, TRC, C3D, bags of ROS 1 and 2, and any table
    with a mapping. Units become metres, up becomes z, the base becomes the origin, and the plane in which the arm bends becomes
    x-z; of an arm in space (--bending space) nothing is put into a plane.

    \b
    hsr-import run1.csv run2.csv -o my-arm --mass 0.15 --diameter 0.04 --keq 1.11 \\
        --base Arm:base -m mid@0.12=Arm:m1+Arm:m2 -m tip@0.24=Arm:tip
    hsr-import take.csv -o my-arm --bending space --map my-arm.toml --input pressures.csv
    """  # noqa: D301 (click's mark for text as it stands is a backspace)
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
    _report(imported, files, options["output"])
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
    )


def _name_of(output: str) -> str:
    name = Path(output).resolve().name or "imported"
    if not name.isprintable():
        hint = "--name gives the dataset a name of its own"
        raise click.BadParameter(f"expected a folder whose name is a text, got {name!r}; {hint}", param_hint="'--output'")
    return name


def _seconds(text: str, option: str, other: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"expected a number of s, or {other}, got {text!r}", param_hint=f"'{option}'") from None


def _point(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"expected X,Y,Z in m, got {text!r}", param_hint="'--origin'") from None


def _mapping(path: str | None) -> TableMapping | None:
    from hsr_pin.recordings.importers.mapping import read_mapping

    return None if path is None else read_mapping(path)


def _guess(table: str, output: str | None, force: bool) -> None:
    from hsr_pin.cli.console import say, say_written
    from hsr_pin.errors import OutputError
    from hsr_pin.output import check_writable, write_text
    from hsr_pin.recordings.importers.guess import guessed_mapping

    if output is None:
        say(guessed_mapping(Path(table)).rstrip("\n"))
        return
    if Path(output).exists() and not force:
        hint = "--force replaces it"
        expected = "a new file for the mapping"
        raise OutputError("will not replace the file", expected=expected, received="one that is there", hint=hint, file=output)
    check_writable(output)
    write_text(output, guessed_mapping(Path(table)))
    say_written([output])


def _list(files: tuple[str, ...], unit: str | None, mapping: TableMapping | None) -> None:
    import numpy as np

    from hsr_pin.cli.console import say
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
        up = f"{capture.up.axis} up {capture.up.why}" if capture.up.axis else f"up unknown: {capture.up.why}"
        timing = f"{len(capture.time)} frames, {capture.time[-1]:.3f} s, {capture.rate:.6g} Hz"
        say(f"{path}: {capture.system}, {timing}, in {capture.unit}, {up}")
        headings = ["point", "seen", "gaps", "longest s", "x [m]", "y [m]", "z [m]"]
        if capture.orientations:
            headings, rows = [*headings, "pose"], [[*row, *pose] for row, pose in zip(rows, posed, strict=True)]
        _table(headings, rows)


def _report(imported: Imported, files: tuple[str, ...], output: str) -> None:
    import numpy as np

    from hsr_pin.cli.console import say
    from hsr_pin.recordings.noise import noise_floor

    dataset, rows = imported.dataset, []
    for trial, path, within, out in zip(dataset.trials, files, imported.in_plane, imported.out_of_plane, strict=True):
        trajectory, noise = trial.trajectory, noise_floor(trial)
        quiet = f"{1e3 * np.nanmax(noise):.3f}" if np.isfinite(noise).any() else ""
        missing = f"{np.isnan(trajectory.positions).any(axis=2).mean():.1%}"
        rate = f"{1 / trajectory.step:.4g}"
        rows.append(
            [
                trial.name,
                Path(path).name,
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
    say(f"{output}: {dataset.mount} arm of {dataset.length:.4g} m{parts}{space}")
    say("markers: " + ", ".join(map(_placed, dataset.markers)))
    _table(["trial", "file", "samples", "Hz", "missing", "noise mm", "in plane mm", "out of plane mm"], rows)
    for note in dataset.notes:
        say(f"  {note}")
    for trial in dataset.trials:
        for note in trial.trajectory.notes:
            say(f"  {trial.name}: {note}")


def _placed(marker: Marker) -> str:
    beside = f", {marker.radius:.4g} m beside the backbone at {marker.angle:.4g} rad" if marker.radius else ""
    return f"{marker.name} at {marker.arc_length:.4g} m{beside}"


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
    leave(run(command))
