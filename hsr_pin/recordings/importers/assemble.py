"""Captured motion into a dataset: markers chosen, in metres, in the arm's frame, with its input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.declaration import MOST_MARKERS
from hsr_pin.recordings.importers.alignment import Alignment, mount_of
from hsr_pin.recordings.importers.bodies import Body, choose, every_point, matches, orientations
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.detect import read_capture, read_commands_of
from hsr_pin.recordings.importers.input_clock import on_clock_of
from hsr_pin.recordings.importers.plane import Motion, fit_plane, spread
from hsr_pin.recordings.importers.settings import ImportSettings, per_trial
from hsr_pin.recordings.importers.space import (
    pushed_aside,
    sided,
    space_frame,
    spread_in_space,
    torque_rows,
    turned_points,
)
from hsr_pin.recordings.importers.straight import StraightArm, pointing, straight_arm
from hsr_pin.recordings.importers.trials import (
    channels_of_input,
    check_torques,
    driven,
    facts_of_trials,
    trajectory_of,
    trial_of,
)
from hsr_pin.recordings.importers.up import Up, axis_vector, choose_up
from hsr_pin.recordings.importers.warnings import beside_its_input, warnings
from hsr_pin.recordings.outliers import spikes
from hsr_pin.recordings.plausible import size_doubt
from hsr_pin.recordings.poses import points_of
from hsr_pin.trajectory import Array, Channel, Dataset, Marker, Trial

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
        in_plane: (trials,) [m] root mean square motion in the bending plane, of the markers beyond the base; in space in the
            plane in which it is largest.
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
    turns: dict[str, Array]  # (T, 4) quaternions, by name of the body, in the laboratory's frame


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
    offsets = per_trial(settings.input_offset, len(files), "input_offset")
    captures = [read_capture(path, settings.unit, settings.mapping) for path in files]
    bodies = _bodies(settings, captures[0])
    tracked = [_track(*each, bodies, settings) for each in zip(captures, inputs, offsets, strict=True)]
    try:
        return _assemble(tracked, bodies, settings)
    except RecordingError as error:
        if error.file is not None:
            raise
        facts = {"expected": error.expected, "received": error.received, "hint": error.hint}
        raise RecordingError(error.subject, **facts, file=captures[0].path) from error


def _bodies(settings: ImportSettings, capture: Capture) -> tuple[Body, ...]:
    bodies = tuple(settings.markers)
    if all(body.is_base for body in bodies):  # none given, or the base only
        taken = {capture.names[index] for body in bodies for source in body.sources for index in matches(capture, source)}
        bodies += tuple(body for body in every_point(capture) if not taken.intersection(body.sources))
    if not bodies:
        raise RecordingError("no named marker was seen", hint="choose points with --marker", file=capture.path)
    if len(bodies) > MOST_MARKERS:
        expected, hint = f"at most {MOST_MARKERS} markers", "choose points with --marker"
        raise RecordingError("points", expected=expected, received=len(bodies), hint=hint, file=capture.path)
    if settings.origin is not None or any(body.is_base for body in bodies):
        return bodies
    return tuple(replace(body, arc_length=0.0) if body.name.lower() in BASE_NAMES else body for body in bodies)


def _track(
    capture: Capture, path: str | Path | None, offset: float | str | None, bodies: Sequence[Body], settings: ImportSettings
) -> _Tracked:
    positions, notes = choose(capture, bodies)
    without = np.where(spikes(positions)[:, :, None], np.nan, positions)
    command = read_commands_of(capture, path, settings.mapping, settings.input_columns)
    if command is not None:
        check_torques(command, settings)
        command, said = on_clock_of(command, capture, without, offset)
        notes += said
    return _Tracked(capture, positions, without, command, [*capture.notes, *notes], orientations(capture, bodies))


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
    channels = channels_of_input([motion.command for motion in motions], settings)
    planes, warned = _frames(motions, channels, arm, mount, up, settings)
    worlds = [alignment.to_world(one.positions[:, arm.order]) for one, (alignment, _) in zip(tracked, planes, strict=True)]
    declared, sides = sided(arm, bodies, planes[0][0], mount)
    length, markers = _lengths(declared, settings.length)
    if doubt := size_doubt(length, settings.mass, settings.diameter):
        raise InputError(doubt.key, **doubt.facts)
    posed = [(place, bodies[index]) for place, index in enumerate(arm.order) if bodies[index].pose]
    if posed:
        radius = settings.diameter / 2
        points = turned_points([one.turns for one in tracked], worlds, posed, arm, planes[0][0], mount, radius)
        worlds = [np.concatenate(pair, axis=1) for pair in zip(worlds, points, strict=True)]
        markers += points_of([markers[place] for place, _ in posed], radius)
        sides += [f"{body.name}: its pose is two more points, {radius:g} m from it" for _, body in posed]
    trials: list[Trial] = []
    spreads: list[tuple[float, float]] = []
    facts = facts_of_trials(settings, len(tracked))
    for one, motion, world, (alignment, note), own in zip(tracked, motions, worlds, planes, facts, strict=True):
        moving = alignment.to_world(motion.positions[:, arm.moving])
        within, out = spread_in_space(moving, mount) if settings.in_space else spread(moving)
        plane = "the plane of its largest motion" if settings.in_space else "the bending plane"
        notes = [*one.notes, note, f"motion in {plane} {1e3 * within:.3g} mm, out of it {1e3 * out:.3g} mm (RMS)"]
        trajectory = trajectory_of(one.capture, world, markers, driven(one.command, channels, settings), notes)
        trials.append(trial_of(f"trial_{len(trials) + 1:02d}", trajectory, own, one.capture.path, settings.interpolated))
        spreads.append((within, out))
    dataset = Dataset(
        name=settings.name,
        length=length,
        mass=settings.mass,
        diameter=settings.diameter,
        mount=mount,
        trials=tuple(trials),
        description=settings.description,
        notes=(f"imported: {mount} arm, {chosen.axis} of the laboratory is up, {chosen.why}", *arm.notes, *sides),
        bending=settings.bending,
        torsion=settings.torsion,
        sections=tuple(settings.sections),
        channels=channels,
    )
    return Imported(
        dataset,
        tuple(within for within, _ in spreads),
        tuple(out for _, out in spreads),
        (*warned, *warnings(dataset, spreads, settings.up is not None)),
    )


def _frames(
    motions: Sequence[Motion],
    channels: Sequence[Channel],
    arm: StraightArm,
    mount: str,
    up: Array,
    settings: ImportSettings,
) -> tuple[list[tuple[Alignment, str]], list[str]]:
    """The arm's frame in each trial with a sentence on its x, and what looks wrong with it."""
    if settings.in_space:
        torques = [torque_rows(motion.command, channels, settings.inputs_of_arm) for motion in motions]
        plane = space_frame(motions, torques, arm, mount, up, settings.x)
        return [plane] * len(motions), beside_its_input(*pushed_aside(motions, torques, arm, plane[0], mount))
    if settings.own_plane:
        return [fit_plane([motion], arm, mount, up, settings.x) for motion in motions], []
    return [fit_plane(motions, arm, mount, up, settings.x)] * len(motions), []


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


def _lengths(markers: tuple[Marker, ...], length: float | None) -> tuple[float, tuple[Marker, ...]]:
    """The arm's length, and its markers with no arc length beyond it."""
    farthest = max(marker.arc_length for marker in markers)
    if length is None:
        return farthest, markers
    if farthest > length * (1 + BEYOND):
        raise RecordingError(
            "arc length",
            expected=f"markers within the arm's length, {length:g} m",
            received=f"{farthest:.4g} m",
            hint="is it another unit (--unit), another base, or another length?",
        )
    return length, tuple(replace(marker, arc_length=min(marker.arc_length, length)) for marker in markers)
