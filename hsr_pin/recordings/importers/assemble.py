"""Captured motion into a dataset: markers chosen, in metres, in the arm's frame, with its input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.declaration import MOST_MARKERS
from hsr_pin.recordings.grid import on_even_grid
from hsr_pin.recordings.importers.alignment import mount_of
from hsr_pin.recordings.importers.bodies import Body, choose, every_point, matches
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.detect import read_capture, read_commands_of
from hsr_pin.recordings.importers.mapping import TableMapping
from hsr_pin.recordings.importers.plane import Motion, fit_plane, spread
from hsr_pin.recordings.importers.settings import ImportSettings, per_trial
from hsr_pin.recordings.importers.straight import StraightArm, pointing, straight_arm
from hsr_pin.recordings.importers.up import Up, axis_vector, choose_up
from hsr_pin.recordings.importers.warnings import warnings
from hsr_pin.recordings.outliers import spikes
from hsr_pin.trajectory import Array, Dataset, Marker, Trajectory, Trial

#: Names that a point at the base goes by.
BASE_NAMES = ("base", "root", "origin")
#: An estimated arc length may exceed the arm's given length by this share; it is then taken to be at the tip.
BEYOND = 0.03
#: An arm is called upright or hanging if the sine of its slope is at least this.
HALFWAY = 0.5
#: And not horizontal from here on.
NEARLY_VERTICAL = 0.87


@dataclass(frozen=True, eq=False)
class Imported:
    """What came of an import.

    Attributes:
        dataset: its notes, and those of each trajectory, say what was done.
        in_plane: (trials,) [m] root mean square motion in the bending plane, of the markers beyond the base.
        out_of_plane: (trials,) [m] the same out of it.
        warnings: what may be wrong with it, one sentence each.
    """

    dataset: Dataset
    in_plane: tuple[float, ...]
    out_of_plane: tuple[float, ...]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Tracked:
    capture: Capture
    positions: Array  # (T, B, 3) [m] in the laboratory's frame
    without_spikes: Array  # the same, for fitting
    command: CommandRows | None
    notes: list[str]


def import_recordings(files: Sequence[str | Path], settings: ImportSettings) -> Imported:
    """Make a dataset of captured files, one trial each.

    All files come from one laboratory: one base, one straight pose, and (unless ``own_plane``) one bending plane.

    Raises:
        RecordingError: with file, line and column of a fault in a file; or the motion does not fit an arm.
        InputError: a setting that cannot be used.
    """
    if not files:
        raise InputError("files", expected="at least one file to import", received="none")
    inputs = per_trial(settings.inputs, len(files), "inputs")
    captures = [read_capture(path, settings.unit, settings.mapping) for path in files]
    bodies = _bodies(settings, captures[0])
    tracked = [_track(capture, bodies, path, settings.mapping) for capture, path in zip(captures, inputs, strict=True)]
    try:
        return _assemble(tracked, bodies, settings)
    except RecordingError as error:
        if error.file is not None:
            raise
        facts = {"expected": error.expected, "received": error.received, "hint": error.hint}
        raise RecordingError(error.subject, **facts, file=captures[0].path) from error


def _bodies(settings: ImportSettings, capture: Capture) -> tuple[Body, ...]:
    bodies = tuple(settings.markers)
    if all(body.arc_length == 0 for body in bodies):  # none given, or the base only
        taken = {capture.names[index] for body in bodies for source in body.sources for index in matches(capture, source)}
        bodies += tuple(body for body in every_point(capture) if not taken.intersection(body.sources))
    if not bodies:
        raise RecordingError("no named marker was seen", hint="choose points with --marker", file=capture.path)
    if len(bodies) > MOST_MARKERS:
        expected, hint = f"at most {MOST_MARKERS} markers", "choose points with --marker"
        raise RecordingError("points", expected=expected, received=len(bodies), hint=hint, file=capture.path)
    if settings.origin is not None or any(body.arc_length == 0 for body in bodies):
        return bodies
    return tuple(replace(body, arc_length=0.0) if body.name.lower() in BASE_NAMES else body for body in bodies)


def _track(capture: Capture, bodies: Sequence[Body], path: str | Path | None, mapping: TableMapping | None) -> _Tracked:
    positions, notes = choose(capture, bodies)
    without = np.where(spikes(positions)[:, :, None], np.nan, positions)
    return _Tracked(capture, positions, without, read_commands_of(capture, path, mapping), [*capture.notes, *notes])


def _assemble(tracked: Sequence[_Tracked], bodies: Sequence[Body], settings: ImportSettings) -> Imported:
    origin = None if settings.origin is None else np.array(settings.origin, dtype=float)
    seen_points = [one.without_spikes for one in tracked]
    axes = {one.capture.up.axis for one in tracked}
    if settings.up is None and len(axes) > 1:
        received = ", ".join(sorted(axis or "unknown" for axis in axes))
        raise InputError("up", expected="files of one laboratory", received=received, hint="say which axis is up with --up")
    chosen = choose_up(settings.up, tracked[0].capture.up, lambda: pointing(bodies, seen_points, origin), settings.mount)
    up = axis_vector(chosen.axis or "", "up")
    arm = straight_arm(bodies, seen_points, origin=origin, mount=settings.mount, up=up)
    mount = settings.mount or mount_of(arm.direction, up)
    _check_mount(mount, arm, up, chosen)
    motions = [Motion(one.capture.time, one.without_spikes[:, arm.order], one.command) for one in tracked]
    if settings.own_plane:
        planes = [fit_plane([motion], arm, mount, up, settings.bending) for motion in motions]
    else:
        planes = [fit_plane(motions, arm, mount, up, settings.bending)] * len(motions)
    length, markers = _lengths(arm, settings.length)
    facts = _facts(settings, len(tracked))
    trials: list[Trial] = []
    spreads: list[tuple[float, float]] = []
    for one, motion, (alignment, note), own in zip(tracked, motions, planes, facts, strict=True):
        within, out = spread(alignment.to_world(motion.positions[:, arm.moving]))
        notes = [*one.notes, note, f"motion in the bending plane {1e3 * within:.3g} mm, out of it {1e3 * out:.3g} mm (RMS)"]
        trajectory = _trajectory(one, alignment.to_world(one.positions[:, arm.order]), markers, notes)
        trials.append(_trial(f"trial_{len(trials) + 1:02d}", trajectory, own, one.capture.path))
        spreads.append((within, out))
    dataset = Dataset(
        name=settings.name,
        length=length,
        mass=settings.mass,
        diameter=settings.diameter,
        mount=mount,
        trials=tuple(trials),
        description=settings.description,
        notes=(f"imported: {mount} arm, {chosen.axis} of the laboratory is up, {chosen.why}", *arm.notes),
    )
    return Imported(
        dataset,
        tuple(within for within, _ in spreads),
        tuple(out for _, out in spreads),
        warnings(dataset, spreads, settings.up is not None),
    )


def _check_mount(mount: str, arm: StraightArm, up: Array, chosen: Up) -> None:
    slope = float(arm.direction @ up)
    fits = {"hanging": slope < -HALFWAY, "upright": slope > HALFWAY, "horizontal": abs(slope) < NEARLY_VERTICAL}[mount]
    if not fits:
        raise InputError(
            "mount",
            expected=f"an arm that is {mount}",
            received=f"one that points {np.degrees(np.arcsin(np.clip(slope, -1, 1))):.0f} deg above the horizontal",
            hint=f"is {chosen.axis} of the laboratory up, {chosen.why}? if not, say which with --up",
        )


def _lengths(arm: StraightArm, length: float | None) -> tuple[float, tuple[Marker, ...]]:
    """The arm's length, and its markers with no arc length beyond it."""
    farthest = max(marker.arc_length for marker in arm.markers)
    if length is None:
        return farthest, arm.markers
    if farthest > length * (1 + BEYOND):
        raise RecordingError(
            "arc length",
            expected=f"markers within the arm's length, {length:g} m",
            received=f"{farthest:.4g} m",
            hint="is it another unit (--unit), another base, or another length?",
        )
    return length, tuple(Marker(marker.name, min(marker.arc_length, length)) for marker in arm.markers)


def _facts(settings: ImportSettings, trials: int) -> list[dict[str, float | None]]:
    """What is declared of each trial."""
    names = ("keq", "damping", "tip_mass", "t_start")
    columns = [per_trial(getattr(settings, name), trials, name) for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _trajectory(one: _Tracked, world: Array, markers: tuple[Marker, ...], notes: Sequence[str]) -> Trajectory:
    try:
        trajectory, _ = on_even_grid(Trajectory(one.capture.time, markers, world))
    except ValueError:
        hint = "split the recording at long pauses"
        expected, received = "nearly even sampling", "almost all gap"
        raise RecordingError("time", expected=expected, received=received, hint=hint, file=one.capture.path) from None
    kept = [*notes, *trajectory.notes]
    if one.command is None:
        return replace(trajectory, notes=tuple(kept))
    time = trajectory.time
    held = one.command.held_at(time)
    if one.command.time[0] > time[0] + 1e-9:
        kept.append(f"the input begins at {one.command.time[0]:g} s; its first row was held before that")
    torque, pressures = (held[:, 0], None) if one.command.names == ("tau",) else (None, held)
    return replace(trajectory, torque=torque, pressures=pressures, notes=tuple(kept))


def _trial(name: str, trajectory: Trajectory, facts: dict[str, float | None], path: Path) -> Trial:
    t_start, time = facts["t_start"], trajectory.time
    if t_start is not None and not time[0] <= t_start < time[-1]:
        raise InputError("t_start", expected=f"a time in the recording, 0 to {time[-1]:g} s", received=f"{t_start:g}", file=path)
    return Trial(name, trajectory, facts["keq"] or 0.0, facts["damping"], facts["tip_mass"] or 0.0, t_start)
