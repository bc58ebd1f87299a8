"""Frame of an arm in space, angular positions of its markers, and orientations of bodies on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.delimited import number
from hsr_pin.recordings.importers.alignment import Alignment, bending_direction, frame
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.plane import SIGNIFICANT_CORRELATION, Motion, spread
from hsr_pin.recordings.importers.straight import StraightArm
from hsr_pin.recordings.importers.up import axis_vector
from hsr_pin.recordings.poses import axes_of, offset_points
from hsr_pin.trajectory import Array, Channel, Marker

#: Value of ``x`` for a direction that is determined from the input.
INPUT = "input"
#: Axes of the links of the straight arm in the world, as columns: x (positive bending), y (sideways), z (towards the tip).
LINKS = {
    "hanging": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
    "upright": np.eye(3),
    "horizontal": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
}
LINKS["flat"] = LINKS["horizontal"]
#: Largest cosine of the angle between the vertical and an axis that counts as perpendicular to the arm.
ALONG = 0.9
#: Smallest cosine of the angle between a horizontal arm and its x axis.
HALFWAY = 0.7


def space_frame(
    motions: Sequence[Motion], torques: Sequence[Array | None], arm: StraightArm, mount: str, up: Array, x: str | None
) -> tuple[Alignment, str]:
    """Return the frame of an arm in space and a sentence on the direction of its x axis.

    Args:
        motions: motions of all trials.
        torques: (R, 2 S) torques [N m] of each motion's command; None without a command.
        arm: the straight arm.
        mount: "hanging", "upright" or "horizontal".
        up: (3,) unit vector that points up.
        x: an axis or a direction of the laboratory, "input", or None: the first axis of the laboratory perpendicular to the
            arm. For a horizontal arm, which points along x, an axis or a direction, or None: the direction of the arm.

    Raises:
        InputError: ``x`` is not perpendicular to the arm or is invalid, or the input does not determine it.
    """
    if mount == "horizontal":
        wanted, source = arm.direction, "the direction of the straight arm"
        if x is not None:
            wanted, source = _direction(x), f"{x} of the laboratory"
            if wanted @ arm.direction < HALFWAY * np.linalg.norm(wanted):
                hint = "give the position of the inputs by their angle, from down towards the side"
                raise InputError("x", expected="the direction of the horizontal arm", received=x, hint=hint)
        return frame(arm.origin, wanted, up), f"x is {source}, and positive bending is down"
    usual = "xyz"[int(np.argmin(np.abs(up)))]
    if x == INPUT:
        alignment = frame(arm.origin, axis_vector(usual), up)
        turn, correlation = deflection_angle(motions, torques, arm, alignment, mount)
        if correlation < SIGNIFICANT_CORRELATION:
            raise InputError(
                "x", expected="an input that determines x", received=f"correlation {correlation:.2f}", hint="give an axis"
            )
        turned = alignment.rotation.T @ LINKS[mount] @ np.array([math.cos(turn), math.sin(turn), 0.0])
        where = ", ".join(f"{value:.4f}" for value in turned)
        return frame(arm.origin, turned, up), f"x is ({where}) of the laboratory, where an input towards x bends the arm"
    wanted = axis_vector(usual) if x is None else _direction(x)
    if abs(wanted @ up) > ALONG * np.linalg.norm(wanted):
        raise InputError("x", expected="a direction perpendicular to the arm", received=x)
    return frame(arm.origin, wanted, up), f"x is {f'{x} of the laboratory' if x else f'+{usual} of the laboratory, the default'}"


def _direction(x: str) -> Array:
    """Return the vector (3,) of an axis or a direction given as text.

    Raises:
        InputError: the text is neither.
    """
    if "," not in x:
        try:
            return axis_vector(x, "x")
        except InputError:
            expected = "an axis of the laboratory (+x, -y, ...), a direction (0.8,0.6,0), or input"
            raise InputError("x", expected=expected, received=repr(x)) from None
    try:
        found = np.array([number(part) for part in x.split(",")])
    except ValueError:
        found = np.zeros(0)
    if found.shape != (3,) or not np.isfinite(found).all() or not found.any():
        raise InputError("x", expected="three numbers, such as 0.8,0.6,0", received=repr(x))
    return found


def torque_rows(command: CommandRows | None, channels: Sequence[Channel], sections: int) -> Array | None:
    """Return the torques (R, 2 S) [N m] of the rows of a command on S sections; None without a command.

    Args:
        command: torques, or values of channels.
        channels: channels of the input; empty: the command consists of torques.
        sections: number S of sections.
    """
    if command is None:
        return None
    if not channels:
        return command.values
    return np.asarray(command.values @ np.array([channel.torque or (0.0,) * (2 * sections) for channel in channels]))


def deflection_angle(
    motions: Sequence[Motion], torques: Sequence[Array | None], arm: StraightArm, alignment: Alignment, mount: str
) -> tuple[float, float]:
    """Return the angle [rad] from torque to deflection, from x towards y of the base, and the correlation there (0 to 1).

    The torque is the sum over the sections, and the deflection is that of the outermost marker; both are taken about their means.
    """
    products, drives, deflections = 0.0j, 0.0, 0.0
    for motion, torque in zip(motions, torques, strict=True):
        if motion.command is None or torque is None:
            continue
        held = CommandRows(motion.command.path, motion.command.time, (), torque).held_at(motion.time)
        drive = held[:, 0::2].sum(axis=1) + 1j * held[:, 1::2].sum(axis=1)
        x, y = LINKS[mount].T[:2] @ (alignment.to_world(motion.positions[:, -1]) - alignment.to_world(arm.pose[-1])).T
        known = np.isfinite(x)
        if known.any():
            drive, deflection = drive[known] - drive[known].mean(), (x + 1j * y)[known] - (x + 1j * y)[known].mean()
            products += np.vdot(drive, deflection)
            drives, deflections = drives + np.vdot(drive, drive).real, deflections + np.vdot(deflection, deflection).real
    size = math.sqrt(drives * deflections)
    return float(np.angle(products)), float(abs(products)) / size if size > 0 else 0.0


def with_angles(
    arm: StraightArm, bodies: Sequence[Body], alignment: Alignment, mount: str
) -> tuple[tuple[Marker, ...], list[str]]:
    """Return the markers with estimated angles about the backbone where none were given, and a note on each estimate."""
    straight = LINKS[mount].T @ alignment.rotation
    on_backbone = any(marker.arc_length > 0 and not marker.radius for marker in arm.markers)
    along = straight @ arm.direction if on_backbone else np.array([0.0, 0.0, 1.0])
    markers, notes = [], []
    for index, place, marker in zip(arm.order, arm.pose, arm.markers, strict=True):
        if marker.radius and bodies[index].angle is None:
            x, y, _ = straight @ (place - arm.origin) - marker.arc_length * along
            marker = replace(marker, angle=round(math.atan2(y, x), 4))
            notes.append(f"{marker.name}: angle {marker.angle:g} rad was estimated from the straightest pose")
        markers.append(marker)
    return tuple(markers), notes


def pose_points(
    quaternions: Sequence[Mapping[str, Array]],
    places: Sequence[Array],
    posed: Sequence[tuple[int, Body]],
    arm: StraightArm,
    alignment: Alignment,
    mount: str,
    radius: float,
) -> list[Array]:
    """Return the positions (T, 2 M, 3) [m] of two points for each body with a pose, along x and y of its link, for each trial.

    If the axes of a body are not those of its link, the rotation between them is estimated where the arm is straightest.

    Args:
        quaternions: unit quaternions (T, 4) of each trial, by name of the body.
        places: (T, B, 3) positions [m] of each trial, in the arm's frame.
        posed: index among the positions, and body, for M bodies.
        arm: the straight arm.
        alignment: alignment of the arm's frame.
        mount: mount of the arm.
        radius: distance of the points from the body [m].

    Raises:
        RecordingError: no frame shows the orientation of a body where the arm is straight.
    """
    found: list[list[Array]] = [[] for _ in quaternions]
    for index, body in posed:
        seen = [alignment.rotation @ axes_of(each[body.name]) for each in quaternions]
        links = np.eye(3)
        if body.pose != "link":
            straight = np.concatenate(seen)[arm.frames]
            straight = straight[np.isfinite(straight).all(axis=(1, 2))]
            if not len(straight):
                expected, hint = "an orientation where the arm is straight", "leave out this pose"
                raise RecordingError(f"pose of {body.name!r}", expected=expected, received="none", hint=hint)
            left, _, right = np.linalg.svd(straight.mean(axis=0))  # nearest rotation to the mean
            links = (left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right).T @ LINKS[mount]
        for points, axes, place in zip(found, seen, places, strict=True):
            points.append(offset_points(place[:, index], axes @ links, radius))
    return [np.concatenate(points, axis=1) for points in found]


def spread_in_space(world: Array, mount: str) -> tuple[float, float]:
    """Return the RMS motion [m] of positions (T, B, 3) in the arm's frame, in and out of the plane of the largest motion."""
    along = LINKS[mount][:, 2]
    most = bending_direction([world], along)
    if most is None:
        return 0.0, 0.0
    return spread(world @ np.stack([most, np.cross(along, most), along]).T)
