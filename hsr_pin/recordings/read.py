"""Reading of datasets from disk into the types of :mod:`hsr_pin.trajectory` (docs/recording-format.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from hsr_pin.errors import RecordingError, quoted
from hsr_pin.recordings.declaration import FILE_NAME, Declaration, TrialDeclaration, read_declaration
from hsr_pin.recordings.files import is_inside
from hsr_pin.recordings.grid import instants_between, on_even_grid, with_commands_between
from hsr_pin.recordings.plausible import exchanged, implausible_mount
from hsr_pin.recordings.poses import points_of, seen_points
from hsr_pin.recordings.samples import FIRST, SAMPLES, sample_folder
from hsr_pin.recordings.sampling import implausible
from hsr_pin.recordings.sections import COMMAND
from hsr_pin.recordings.text import Table, nearest, read_table
from hsr_pin.trajectory import Array, Dataset, Marker, Trajectory, Trial

#: Largest accepted coordinate [m], time [s] or input.
LARGEST = 1e10
#: Smallest accepted time between two samples [s].
SHORTEST_STEP = 1e-9
#: Largest accepted ratio of a marker's distance from the base to the arm's length; more is probably not in metres.
TOO_FAR = 5.0
#: Smallest accepted ratio of a marker's median distance from the base to its arc length.
TOO_NEAR = 0.02
#: Largest displacement of a marker that counts as not moving [m].
STILL = 1e-9


def read_dataset(path: str | Path) -> Dataset:
    """Read a dataset from a folder.

    Args:
        path: the folder or its ``dataset.toml``, or the name of a sample if no such folder exists.

    Returns:
        The dataset. The ``notes`` of each trajectory report changes of its data, such as resampling.

    Raises:
        RecordingError: the dataset is invalid; the error names file, line and column of the first fault and what to try.
    """
    folder = Path(path)
    if folder.name == FILE_NAME:
        folder = folder.parent
    if not _is_true(folder.is_dir):
        known = sample_folder(str(path))
        if known is None:
            hint = f"samples can be given by name: {', '.join(SAMPLES)}"
            raise RecordingError("no such dataset", expected=f"a folder that contains {FILE_NAME}", hint=hint, file=path)
        folder = known
    if _is_true((folder / FILE_NAME).exists) and not is_inside(folder / FILE_NAME, folder):
        raise RecordingError(
            "cannot read the declaration",
            expected="a file in the folder of the dataset",
            received="a link out of the folder",
            hint="copy the file into the folder",
            file=folder / FILE_NAME,
        )
    declaration = read_declaration(folder / FILE_NAME)
    tables = [_table(folder, trial) for trial in declaration.trials]
    trials = tuple(_trial(declaration, trial, table) for trial, table in zip(declaration.trials, tables, strict=True))
    _check_markers(declaration, trials, tables)
    _check_order(declaration, trials, tables)
    return Dataset(
        name=declaration.name,
        length=declaration.length,
        mass=declaration.mass,
        diameter=declaration.diameter,
        mount=declaration.mount,
        trials=trials,
        description=declaration.description,
        path=folder,
        bending=declaration.bending,
        torsion=declaration.torsion,
        sections=declaration.sections,
        channels=declaration.channels,
        chain=declaration.chain,
        smoothed=declaration.smoothed,
        weighed=declaration.weighed,
        obstacles=declaration.obstacles,
    )


def sample(name: str = FIRST) -> Dataset:
    """Read a sample dataset that is installed with the package.

    Args:
        name: name of the sample, one of :data:`SAMPLES`; default: the first one.

    Raises:
        RecordingError: no sample has this name.
    """
    folder = sample_folder(name)
    if folder is None:
        raise RecordingError("sample", expected=f"one of {', '.join(SAMPLES)}", received=quoted(name))
    return read_dataset(folder)


def _is_true(question: Callable[[], bool]) -> bool:
    try:
        return question()
    except (OSError, ValueError):  # the name is too long or contains a null byte
        return False


def _table(folder: Path, trial: TrialDeclaration) -> Table:
    path = folder / trial.file
    if not _is_true(path.exists):
        there = sorted(other.name for other in folder.glob("*.csv"))
        hint = nearest(trial.file, there, "CSV files")
        raise trial.section.fault(f"trial file {trial.file!r} does not exist", "file", hint=hint)
    if not is_inside(path, folder):
        expected, received = "a file inside the dataset's folder", f"{trial.file!r}, a link out of the folder"
        raise trial.section.fault("file", "file", expected=expected, received=received, hint="copy the file into the folder")
    return read_table(path)


def _trial(declaration: Declaration, trial: TrialDeclaration, table: Table) -> Trial:
    _check_columns(table, declaration)
    _check_size(table, declaration)
    trajectory, origin = _on_even_grid(table, declaration)
    time, start = trajectory.time, None if trial.t_start is None else trial.t_start - origin
    if start is not None and not time[0] - 1e-9 <= start < time[-1]:
        expected = f"a time in the recording, {time[0] + origin:.10g} to {time[-1] + origin:.10g} s"
        raise trial.section.fault("t_start", "t_start", expected=expected, received=trial.t_start)
    return Trial(trial.name, trajectory, trial.keq, trial.damping, trial.tip_mass, start, trial.interpolated)


def _check_columns(table: Table, declaration: Declaration) -> None:
    wanted, possible = declaration.columns, [list(names) for names in declaration.inputs]
    every = [name for names in possible for name in names]
    inputs = [name for name in every if name in table.header]
    if inputs and inputs not in possible:
        field, every_set = table.place[inputs[-1]], [" and ".join(names) for names in possible]
        expected = ", or ".join([*every_set, "no input columns"])
        raise table.fault("input columns", None, field, expected=expected, received=" and ".join(inputs))
    commands = [f"{name}{COMMAND}" for name in inputs]
    known, there = {*wanted, *(inputs or every), *commands}, table.place
    missing = [name for name in wanted if name not in there]
    for field, name in enumerate(table.header):
        if name not in known:
            raise table.fault(f"unknown column {name!r}", None, field, hint=nearest(name, missing or sorted(known), "columns"))
    if missing:
        raise table.fault(
            f"column {missing[0]!r} is missing",
            None,
            len(table.header),
            expected=", ".join(wanted),
            hint="leave the fields empty for a marker that was never seen",
        )


def _check_size(table: Table, declaration: Declaration) -> None:
    if len(table.values) < 2:
        raise table.fault("recording", 0, 0, expected="at least two samples", received="one")
    values = table.values
    if np.fmax.reduce(values, axis=None) > LARGEST or np.fmin.reduce(values, axis=None) < -LARGEST:
        row, field = (int(place) for place in np.argwhere(np.abs(values) > LARGEST)[0])
        raise table.fault(
            f"column {table.header[field]}",
            row,
            field,
            expected=f"at most {LARGEST:g}",
            received=f"{values[row, field]:g}",
            hint="times are in seconds, positions in metres, torques in Nm, pressures in bar",
        )
    inputs = [name for names in declaration.inputs for name in names]
    for name in ("t", *inputs, *(f"{name}{COMMAND}" for name in inputs)):
        if name in table.header and np.isnan(table.column(name)).any():
            row = int(np.argmax(np.isnan(table.column(name))))
            raise table.fault(f"column {name}", row, table.place[name], expected="a number", received="no value")
    steps = np.diff(table.column("t"))
    if np.any(steps < SHORTEST_STEP):
        row = int(np.argmax(steps < SHORTEST_STEP)) + 1
        before, here = table.column("t")[row - 1 : row + 1]
        raise table.fault(
            "time", row, table.place["t"], expected=f"more than {before:.9g} s, the previous time", received=f"{here:.9g}"
        )


def _on_even_grid(table: Table, declaration: Declaration) -> tuple[Trajectory, float]:
    markers, time = declaration.markers, table.column("t")
    positions = _positions(table, markers)
    facts = implausible(time)
    if facts is not None:
        row = min(2, len(time) - 1)
        raise table.fault("time", row, table.place["t"], **asdict(facts))
    given = _input(table, declaration)
    positions, flat = _in_plane(positions, declaration)
    notes = flat + [
        f"marker {marker.name} was not seen" for marker, p in zip(markers, positions.swapaxes(0, 1), strict=True) if not _seen(p)
    ]
    if declaration.posed:
        radius = declaration.diameter / 2
        markers = markers + points_of(declaration.posed, radius)
        positions = np.concatenate([positions, seen_points(table, declaration.posed, radius)], axis=1)
    raw = Trajectory(time, markers, positions, notes=tuple(notes), **given)
    try:
        instants = instants_between(raw)
        return with_commands_between(raw, instants) if instants.any() else on_even_grid(raw)
    except ValueError:
        row = int(np.argmax(np.diff(time))) + 1
        raise table.fault(
            "time",
            row,
            table.place["t"],
            expected="nearly even sampling",
            received=f"a step of {np.diff(time).max():.3g} s where the median is {np.median(np.diff(time)):.3g} s",
            hint="times are in seconds; split the recording at long pauses",
        ) from None


def _input(table: Table, declaration: Declaration) -> dict[str, Array]:
    """Return the input as keyword arguments of a trajectory; empty if the table has no input."""
    names = next((names for names in declaration.inputs if names[0] in table.header), ())
    if not names:
        return {}
    values = np.stack([table.column(name) for name in names], axis=1)
    commands = {}
    if any(f"{name}{COMMAND}" in table.header for name in names):
        nothing = np.full(len(values), np.nan)
        each = [table.column(f"{name}{COMMAND}") if f"{name}{COMMAND}" in table.header else nothing for name in names]
        commands = {"commanded": np.stack(each, axis=1)}
    if declaration.bending == "plane":
        return {"pressures": values, **commands} if len(names) == 2 else {"torque": values[:, 0], **commands}
    if names != tuple(channel.name for channel in declaration.channels):
        return {"torque": values, **commands}
    gains = np.array([c.torque or (0.0,) * (2 * max(1, len(declaration.sections))) for c in declaration.channels])
    return {"torque": values @ gains, "channels": values, **commands}


def _positions(table: Table, markers: tuple[Marker, ...]) -> Array:
    fields = [table.place[f"{marker.name}_{axis}"] for marker in markers for axis in "xyz"]
    return table.values[:, fields].reshape(len(table.values), len(markers), 3)


def _in_plane(positions: Array, declaration: Declaration) -> tuple[Array, list[str]]:
    """Return positions in which planar markers without any y have y = 0, and a note on each of these markers."""
    some = np.asarray(np.isfinite(positions).any(axis=0))
    wanted = [True, False, True] if declaration.bending == "plane" else [False] * 4
    flat = [index for index, axes in enumerate(some.tolist()) if axes == wanted]
    positions = np.array(positions)
    for index in flat:
        positions[np.isfinite(positions[:, index, 0]), index, 1] = 0.0
    return positions, [f"{declaration.markers[index].name}: y is missing in all samples and was set to 0" for index in flat]


def _seen(positions: Array) -> bool:
    """Return whether any of the positions (..., 3) is complete."""
    return bool(np.isfinite(positions).all(axis=-1).any())


def _check_order(declaration: Declaration, trials: tuple[Trial, ...], tables: list[Table]) -> None:
    """Check that the arm points as its mount declares, and that no markers are exchanged in most samples of a trial."""
    markers = declaration.markers
    last = max(range(len(markers)), key=lambda index: markers[index].arc_length)
    tracks = [trial.trajectory.positions[:, last] for trial in trials]
    places = [np.median(track[seen], axis=0) for track in tracks if (seen := np.isfinite(track).all(axis=1)).any()]
    if reason := implausible_mount(declaration.mount, [tuple(place) for place in places], markers[last].arc_length):
        table = tables[0]
        raise table.fault("mount", None, table.place[f"{markers[last].name}_x"], **reason.facts)
    for trial, table in zip(trials, tables, strict=True):
        apart = np.linalg.norm(trial.trajectory.positions[:, : len(markers)], axis=2)
        distances = [float(np.median(each[np.isfinite(each)])) if np.isfinite(each).any() else np.nan for each in apart.T]
        if (pair := exchanged([marker.arc_length + marker.radius for marker in markers], distances)) is None:
            continue
        near, far = (markers[place] for place in pair)
        raise table.fault(
            f"markers {near.name!r} and {far.name!r} seem to be exchanged",
            None,
            table.place[f"{near.name}_x"],
            expected=f"{near.name!r} at most {near.arc_length:g} m from the base, its arc length",
            received=f"{distances[pair[0]]:.3g} m, and {distances[pair[1]]:.3g} m for {far.name!r} (medians)",
            hint="exchange the names of the two markers in the header, or their arc lengths",
        )


def _without_data(tables: list[Table], name: str, field: int) -> RecordingError:
    empty = [axis for axis in "xyz" if all(np.isnan(table.column(f"{name}_{axis}")).all() for table in tables)]
    if len(empty) in (1, 2):
        subject, expected = f"marker {name!r} has no {' and no '.join(empty)} in any trial", "x, y and z in the world frame, z up"
        return tables[0].fault(
            subject, None, field, expected=expected, hint="for a single camera use x and z, and leave y empty or 0"
        )
    return tables[0].fault(f"marker {name!r} has no data in any trial", None, field, hint="remove it from the dataset")


def _check_markers(declaration: Declaration, trials: tuple[Trial, ...], tables: list[Table]) -> None:
    still = True
    for index, marker in enumerate(declaration.markers):
        field = tables[0].place[f"{marker.name}_x"]
        if not any(_seen(trial.trajectory.positions[:, index]) for trial in trials):
            raise _without_data(tables, marker.name, field)
        places = np.concatenate([trial.trajectory.positions[:, index] for trial in trials])
        still &= marker.arc_length == 0 or float((np.nanmax(places, axis=0) - np.nanmin(places, axis=0)).max()) <= STILL
        for trial, table in zip(trials, tables, strict=True):
            seen = trial.trajectory.positions[:, index]
            seen = seen[np.isfinite(seen).all(axis=1)]
            if len(seen) == 0:
                continue
            distance = float(np.median(np.linalg.norm(seen, axis=1)))
            low = TOO_NEAR * marker.arc_length
            if not low <= distance <= TOO_FAR * declaration.length:
                row = int(np.argmax(np.isfinite(table.column(f"{marker.name}_x"))))
                raise table.fault(
                    f"position of marker {marker.name!r} is not in metres, or not relative to the base of the arm",
                    row,
                    table.place[f"{marker.name}_x"],
                    expected=f"{low:.3g} to {TOO_FAR * declaration.length:.3g} m from the origin",
                    received=f"{distance:.4g} (median)",
                    hint="divide millimetres by 1000; hsr-import converts units",
                )
    if still:
        raise tables[0].fault("no moving marker", None, 0, expected="a marker with arc_length above 0 that moves")
