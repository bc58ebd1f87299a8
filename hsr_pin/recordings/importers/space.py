"""An arm in space: where its x points, on which side of it a marker stands, and how a body on it is turned."""

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
from hsr_pin.recordings.importers.plane import TELLS, Motion, spread
from hsr_pin.recordings.importers.straight import StraightArm
from hsr_pin.recordings.importers.up import axis_vector
from hsr_pin.recordings.poses import axes_of, beside
from hsr_pin.trajectory import Array, Channel, Marker

#: x as the input shows it.
INPUT = "input"
#: Columns are where x, y and z of the straight arm's links point in the world: towards positive bending, to the side, to the tip.
LINKS = {
    "hanging": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
    "upright": np.eye(3),
    "horizontal": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
}
#: An axis is across the arm if it is no nearer to the vertical than the cosine of this.
ALONG = 0.9
#: A horizontal arm points along its x within the cosine of this.
HALFWAY = 0.7


def space_frame(
    motions: Sequence[Motion], torques: Sequence[Array | None], arm: StraightArm, mount: str, up: Array, x: str | None
) -> tuple[Alignment, str]:
    """The arm's frame, and a sentence on which way x points.

    Args:
        motions: of all trials.
        torques: (R, 2 S) [N m] at the rows of each motion's command; None without one.
        arm: at its straightest.
        mount: "hanging", "upright" or "horizontal".
        up: (3,) unit vector.
        x: an axis of the laboratory, a direction there, "input", or None: its first axis across the arm; of a horizontal arm,
            which points along it, an axis or a direction, or None: as it points.

    Raises:
        InputError: ``x`` is not across the arm, or cannot be what it is said to be; or the input does not tell.
    """
    if mount == "horizontal":
        wanted, said = arm.direction, "the way the straight arm points"
        if x is not None:
            wanted, said = _direction(x), f"the laboratory's {x}"
            if wanted @ arm.direction < HALFWAY * np.linalg.norm(wanted):
                hint = "where its inputs lie is said by angle, from down to its side"
                raise InputError("x", expected="the way the horizontal arm points", received=x, hint=hint)
        return frame(arm.origin, wanted, up), f"x is {said}, positive bending is down"
    usual = "xyz"[int(np.argmin(np.abs(up)))]
    if x == INPUT:
        alignment = frame(arm.origin, axis_vector(usual), up)
        turn, sure = pushed_aside(motions, torques, arm, alignment, mount)
        if sure < TELLS:
            raise InputError(
                "x", expected="an input that tells where x is", received=f"correlation {sure:.2f}", hint="say an axis"
            )
        turned = alignment.rotation.T @ LINKS[mount] @ np.array([math.cos(turn), math.sin(turn), 0.0])
        where = ", ".join(f"{value:.4f}" for value in turned)
        return frame(arm.origin, turned, up), f"x is ({where}) of the laboratory, the way the arm goes under an input towards x"
    wanted = axis_vector(usual) if x is None else _direction(x)
    if abs(wanted @ up) > ALONG * np.linalg.norm(wanted):
        raise InputError("x", expected="a direction across the arm", received=x)
    return frame(arm.origin, wanted, up), f"x is the laboratory's {x or f'+{usual}, as nothing else was said'}"


def _direction(x: str) -> Array:
    """(3,) an axis, or a direction.

    Raises:
        InputError: neither.
    """
    if "," not in x:
        try:
            return axis_vector(x, "x")
        except InputError:
            expected = "an axis of the laboratory (+x, -y, ...), a direction there (0.8,0.6,0), or input"
            raise InputError("x", expected=expected, received=repr(x)) from None
    try:
        found = np.array([number(part) for part in x.split(",")])
    except ValueError:
        found = np.zeros(0)
    if found.shape != (3,) or not np.isfinite(found).all() or not found.any():
        raise InputError("x", expected="three numbers, as 0.8,0.6,0", received=repr(x))
    return found


def torque_rows(command: CommandRows | None, channels: Sequence[Channel], sections: int) -> Array | None:
    """(R, 2 S) [N m] what the rows of a command give to S sections; None without a command.

    Args:
        command: torques, or values of the channels.
        channels: of the input; none: the command is torques.
        sections: S.
    """
    if command is None:
        return None
    if not channels:
        return command.values
    return np.asarray(command.values @ np.array([channel.torque or (0.0,) * (2 * sections) for channel in channels]))


def pushed_aside(
    motions: Sequence[Motion], torques: Sequence[Array | None], arm: StraightArm, alignment: Alignment, mount: str
) -> tuple[float, float]:
    """The angle [rad] from the torque to where the arm goes, from x towards y of the base; and how sure that is, from 0 to 1.

    The torque is the sum over the sections, and the arm's way that of its farthest marker; both about their means.
    """
    products, drives, ways = 0.0j, 0.0, 0.0
    for motion, torque in zip(motions, torques, strict=True):
        if motion.command is None or torque is None:
            continue
        held = CommandRows(motion.command.path, motion.command.time, (), torque).held_at(motion.time)
        drive = held[:, 0::2].sum(axis=1) + 1j * held[:, 1::2].sum(axis=1)
        x, y = LINKS[mount].T[:2] @ (alignment.to_world(motion.positions[:, -1]) - alignment.to_world(arm.pose[-1])).T
        known = np.isfinite(x)
        if known.any():
            drive, way = drive[known] - drive[known].mean(), (x + 1j * y)[known] - (x + 1j * y)[known].mean()
            products += np.vdot(drive, way)
            drives, ways = drives + np.vdot(drive, drive).real, ways + np.vdot(way, way).real
    size = math.sqrt(drives * ways)
    return float(np.angle(products)), float(abs(products)) / size if size > 0 else 0.0


def sided(arm: StraightArm, bodies: Sequence[Body], alignment: Alignment, mount: str) -> tuple[tuple[Marker, ...], list[str]]:
    """The markers, the side of one beside the backbone estimated where it was not said; and a sentence for each of those."""
    straight = LINKS[mount].T @ alignment.rotation
    on_backbone = any(marker.arc_length > 0 and not marker.radius for marker in arm.markers)
    along = straight @ arm.direction if on_backbone else np.array([0.0, 0.0, 1.0])
    markers, notes = [], []
    for index, place, marker in zip(arm.order, arm.pose, arm.markers, strict=True):
        if marker.radius and bodies[index].angle is None:
            x, y, _ = straight @ (place - arm.origin) - marker.arc_length * along
            marker = replace(marker, angle=round(math.atan2(y, x), 4))
            notes.append(f"{marker.name}: angle {marker.angle:g} rad estimated from the straightest pose")
        markers.append(marker)
    return tuple(markers), notes


def turned_points(
    turns: Sequence[Mapping[str, Array]],
    places: Sequence[Array],
    posed: Sequence[tuple[int, Body]],
    arm: StraightArm,
    alignment: Alignment,
    mount: str,
    radius: float,
) -> list[Array]:
    """(T, 2 M, 3) [m] of each trial: two points of each body with a pose, towards x and towards y of its link.

    Where a body's axes are not those of its link, they are brought to them by what they are where the arm is straightest.

    Args:
        turns: quaternions of each trial, by name of the body.
        places: (T, B, 3) [m] of each trial, in the arm's frame.
        posed: place among these, and body, of M bodies.
        arm: at its straightest.
        alignment: of the arm's frame.
        mount: of the arm.
        radius: [m] of the points from the body.

    Raises:
        RecordingError: no frame shows a body's orientation where the arm is straight.
    """
    found: list[list[Array]] = [[] for _ in turns]
    for index, body in posed:
        seen = [alignment.rotation @ axes_of(each[body.name]) for each in turns]
        links = np.eye(3)
        if body.pose != "link":
            straight = np.concatenate(seen)[arm.frames]
            straight = straight[np.isfinite(straight).all(axis=(1, 2))]
            if not len(straight):
                expected, hint = "its orientation where the arm is straight", "leave its pose away"
                raise RecordingError(f"pose of {body.name!r}", expected=expected, received="none", hint=hint)
            left, _, right = np.linalg.svd(straight.mean(axis=0))  # the rotation nearest to the mean
            links = (left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right).T @ LINKS[mount]
        for points, axes, place in zip(found, seen, places, strict=True):
            points.append(beside(place[:, index], axes @ links, radius))
    return [np.concatenate(points, axis=1) for points in found]


def spread_in_space(world: Array, mount: str) -> tuple[float, float]:
    """Root mean square motion [m] of (T, B, 3) positions in the arm's frame: in the plane of the largest motion, and out."""
    along = LINKS[mount][:, 2]
    most = bending_direction([world], along)
    if most is None:
        return 0.0, 0.0
    return spread(world @ np.stack([most, np.cross(along, most), along]).T)
