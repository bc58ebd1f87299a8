"""Assembly of a dataset from captured motion: markers in metres in the arm's frame, with their input."""

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
from hsr_pin.recordings.importers.cut import cut
from hsr_pin.recordings.importers.detect import read_capture, read_commands_of
from hsr_pin.recordings.importers.input_clock import on_clock_of
from hsr_pin.recordings.importers.mapped import starts_of_poses
from hsr_pin.recordings.importers.plane import Motion, fit_plane, spread
from hsr_pin.recordings.importers.settings import ImportSettings, per_trial
from hsr_pin.recordings.importers.space import (
    deflection_angle,
    pose_points,
    space_frame,
    spread_in_space,
    torque_rows,
    with_angles,
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
from hsr_pin.recordings.importers.warnings import misaligned_input, warnings
from hsr_pin.recordings.outliers import spikes
from hsr_pin.recordings.plausible import implausible_size
from hsr_pin.recordings.poses import points_of
from hsr_pin.trajectory import Array, Channel, Dataset, Marker, Trial

#: Names of points that are taken as the base.
BASE_NAMES = ("base", "root", "origin")
#: Largest relative excess of an estimated arc length over the given length of the arm; it is then set to the tip.
BEYOND = 0.03
#: Smallest sine of the slope of an upright or hanging arm.
HALFWAY = 0.5
#: Largest sine of the slope of a horizontal arm.
NEARLY_VERTICAL = 0.87


@dataclass(frozen=True, eq=False)
class Imported:
    """Result of an import.

    Attributes:
        dataset: the dataset; its notes and those of each trajectory report what was done.
        files: (trials,) the file of each trial.
        in_plane: (trials,) RMS motion [m] of the markers beyond the base in the bending plane; in space, in the plane of the
            largest motion.
        out_of_plane: (trials,) RMS motion [m] perpendicular to that plane.
        warnings: possible faults of the import, one sentence each.
    """

    dataset: Dataset
    files: tuple[Path, ...]
    in_plane: tuple[float, ...]
    out_of_plane: tuple[float, ...]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _Tracked:
    capture: Capture
    positions: Array  # (T, B, 3) [m] in the laboratory's frame
    without_spikes: Array  # (T, B, 3) [m], for fitting
    command: CommandRows | None
    notes: list[str]
    quaternions: dict[str, Array]  # (T, 4) quaternions in the laboratory's frame, by name of the body


def import_recordings(files: Sequence[str | Path], settings: ImportSettings) -> Imported:
    """Make a dataset from captured files, one trial for each file.

    All files share one laboratory frame, one base, one straight pose and (unless ``own_plane``) one bending plane.

    Raises:
        RecordingError: a file is invalid (with line and column), or the motion is not that of an arm.
        InputError: a setting cannot be used.
    """
    if not files:
        raise InputError("files", expected="at least one file to import", received="none")
    if settings.cut and settings.t_start:
        raise InputError("t_start", expected="no start time with --cut, which says where trials begin", received="both")
    if settings.mapping is not None and settings.mapping.rest and (settings.cut or settings.t_start or settings.input_offset):
        expected = "no --cut, --t-start or --input-offset with [time] rest = true"
        raise InputError("poses at rest", expected=expected, received="one of them", file=settings.mapping.path)
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
    if all(body.is_base for body in bodies):  # no markers are given, or only the base
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
        command, clock_notes = on_clock_of(command, capture, without, offset)
        notes += clock_notes
    return _Tracked(capture, positions, without, command, [*capture.notes, *notes], orientations(capture, bodies))


def _assemble(tracked: Sequence[_Tracked], bodies: Sequence[Body], settings: ImportSettings) -> Imported:
    origin = None if settings.origin is None else np.array(settings.origin, dtype=float)
    seen_points = [one.without_spikes for one in tracked]
    axes = {one.capture.up.axis for one in tracked}
    if settings.up is None and len(axes) > 1:
        received = ", ".join(sorted(axis or "unknown" for axis in axes))
        raise InputError("up", expected="files of one laboratory", received=received, hint="give the axis that is up with --up")
    chosen = choose_up(settings.up, tracked[0].capture.up, lambda: pointing(bodies, seen_points, origin), settings.mount)
    up = axis_vector(chosen.axis or "", "up")
    arm = straight_arm(bodies, seen_points, origin=origin, mount=settings.mount, up=up)
    mount = settings.mount or mount_of(arm.direction, up)
    _check_mount(mount, arm, up, chosen)
    motions = [Motion(one.capture.time, one.without_spikes[:, arm.order], one.command) for one in tracked]
    channels = channels_of_input([motion.command for motion in motions], settings)
    planes, warned = _frames(motions, channels, arm, mount, up, settings)
    worlds = [alignment.to_world(one.positions[:, arm.order]) for one, (alignment, _) in zip(tracked, planes, strict=True)]
    declared, sides = with_angles(arm, bodies, planes[0][0], mount)
    length, markers = _lengths(declared, settings.length)
    if reason := implausible_size(length, settings.mass, settings.diameter):
        raise InputError(reason.key, **reason.facts)
    posed = [(place, bodies[index]) for place, index in enumerate(arm.order) if bodies[index].pose]
    if posed:
        radius = settings.diameter / 2
        points = pose_points([one.quaternions for one in tracked], worlds, posed, arm, planes[0][0], mount, radius)
        worlds = [np.concatenate(pair, axis=1) for pair in zip(worlds, points, strict=True)]
        markers += points_of([markers[place] for place, _ in posed], radius)
        sides += [f"{body.name}: its orientation is recorded as two more points, {radius:g} m from it" for _, body in posed]
    trials: list[Trial] = []
    spreads: list[tuple[float, float]] = []
    sources: list[Path] = []
    facts = facts_of_trials(settings, len(tracked))
    for one, motion, world, (alignment, note), own in zip(tracked, motions, worlds, planes, facts, strict=True):
        moving = alignment.to_world(motion.positions[:, arm.moving])
        within, out = spread_in_space(moving, mount) if settings.in_space else spread(moving)
        plane = "the plane of its largest motion" if settings.in_space else "the bending plane"
        notes = [*one.notes, note, f"RMS motion {1e3 * within:.3g} mm in {plane}, {1e3 * out:.3g} mm out of it"]
        trajectory = trajectory_of(one.capture, world, markers, driven(one.command, channels, settings), notes)
        path, poses = one.capture.path, settings.mapping is not None and settings.mapping.rest
        begins = starts_of_poses(one.capture.time) if poses else settings.cut
        for part in cut(trajectory, begins, path) if begins else [trajectory]:
            trials.append(trial_of(f"trial_{len(trials) + 1:02d}", part, own, path, settings.interpolated))
            spreads.append((within, out))
            sources.append(path)
    dataset = Dataset(
        name=settings.name,
        length=length,
        mass=settings.mass,
        diameter=settings.diameter,
        mount=mount,
        trials=tuple(trials),
        description=settings.description,
        notes=(f"imported: {mount} arm, {chosen.axis} of the laboratory is up, {chosen.reason}", *arm.notes, *sides),
        bending=settings.bending,
        torsion=settings.torsion,
        sections=tuple(settings.sections),
        channels=channels,
    )
    return Imported(
        dataset,
        tuple(sources),
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
    """Return the arm's frame in each trial with a sentence on its x axis, and warnings."""
    if settings.in_space:
        torques = [torque_rows(motion.command, channels, settings.inputs_of_arm) for motion in motions]
        plane = space_frame(motions, torques, arm, mount, up, settings.x)
        return [plane] * len(motions), misaligned_input(*deflection_angle(motions, torques, arm, plane[0], mount))
    if settings.own_plane:
        return [fit_plane([motion], arm, mount, up, settings.x) for motion in motions], []
    return [fit_plane(motions, arm, mount, up, settings.x)] * len(motions), []


def _check_mount(mount: str, arm: StraightArm, up: Array, chosen: Up) -> None:
    slope = float(arm.direction @ up)
    fits = {"hanging": slope < -HALFWAY, "upright": slope > HALFWAY}
    if not fits.get(mount, abs(slope) < NEARLY_VERTICAL):
        raise InputError(
            "mount",
            expected=f"an arm that is {mount}",
            received=f"one that points {np.degrees(np.arcsin(np.clip(slope, -1, 1))):.0f} deg above the horizontal",
            hint=f"{chosen.axis} of the laboratory was taken as up, {chosen.reason}; if this is wrong, give --up",
        )


def _lengths(markers: tuple[Marker, ...], length: float | None) -> tuple[float, tuple[Marker, ...]]:
    """Return the length of the arm [m], and its markers with arc lengths limited to that length."""
    farthest = max(marker.arc_length for marker in markers)
    if length is None:
        return farthest, markers
    if farthest > length * (1 + BEYOND):
        raise RecordingError(
            "arc length",
            expected=f"markers within the arm's length, {length:g} m",
            received=f"{farthest:.4g} m",
            hint="check the unit (--unit), the base and the length",
        )
    return length, tuple(replace(marker, arc_length=min(marker.arc_length, length)) for marker in markers)
