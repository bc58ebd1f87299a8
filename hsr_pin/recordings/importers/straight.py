"""Estimation of the base, the direction of the straight arm, and the arc lengths of the markers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.alignment import mount_of, straightest
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.capture import seen
from hsr_pin.recordings.plausible import exchanged
from hsr_pin.trajectory import Array, Marker

#: Largest relative difference between the reach of a marker and its given arc length.
DISAGREES = 0.25
#: Smallest share of its arc length that a straight arm reaches.
STRAIGHT = 0.98


@dataclass(frozen=True, eq=False)
class StraightArm:
    """Arm in its straightest pose.

    Attributes:
        origin: (3,) position of the base [m] in the laboratory's frame.
        direction: (3,) unit vector from the base to the outermost body, preferably one on the backbone.
        pose: (B, 3) positions of the bodies [m] in the laboratory's frame, from base to tip.
        markers: (B,) the bodies as markers.
        order: (B,) index of each marker among the given bodies.
        notes: notes, one sentence each.
        frames: (F,) straightest frames, counted through all captures.
    """

    origin: Array
    direction: Array
    pose: Array
    markers: tuple[Marker, ...]
    order: tuple[int, ...]
    notes: tuple[str, ...]
    frames: NDArray[np.intp]

    @property
    def moving(self) -> list[int]:
        """Indices of the markers beyond the base."""
        return [index for index, marker in enumerate(self.markers) if marker.arc_length > 0]


def straight_arm(
    bodies: Sequence[Body], captures: Sequence[Array], *, origin: Array | None, mount: str | None, up: Array
) -> StraightArm:
    """Return the straight arm of several captures.

    The base is ``origin``, or else the median position of the body with arc length 0, or else the point at the arc length of the
    first body from that body along the straight arm.

    Args:
        bodies: tracked bodies; an arc length of None is estimated from the distances along the straightest pose.
        captures: (T, B, 3) positions [m] of each capture, without spikes, in the laboratory's frame.
        origin: (3,) position of the base [m], or None.
        mount: "hanging", "upright", "horizontal"; None: determined from the pose.
        up: (3,) unit vector that points up.

    Raises:
        RecordingError: no frame shows all bodies, a reach does not fit its arc length, or there is no body beyond the base.
        InputError: the given settings do not determine the base.
    """
    base = next((index for index, body in enumerate(bodies) if body.is_base), None)
    notes = []
    if base is not None:
        places = np.concatenate([positions[:, base][seen(positions[:, base])] for positions in captures])
        if not len(places):
            raise RecordingError(f"the base, {bodies[base].name!r}, was never seen")
        origin = np.median(places, axis=0) if origin is None else origin
    if all(index == base for index in range(len(bodies))):
        raise RecordingError("no moving marker", expected="at least one marker beyond the base")
    if origin is None:
        origin, frames = _estimated_base(bodies, captures, mount, up)
        notes.append(f"the base was estimated from the straight pose and the arc length of {_first(bodies)[1].name}")
    else:
        far = _farthest(bodies, captures, origin)
        reference = [positions[:, base] if base is not None else origin for positions in captures]
        reach = [np.linalg.norm(positions[:, far] - at, axis=1) for positions, at in zip(captures, reference, strict=True)]
        shown = np.concatenate(reach)
        shown = shown[np.isfinite(shown)]
        if base is not None and len(shown):
            _check_base(places, origin, float(np.median(shown)), bodies[base].name)
        frames = straightest(captures, reach)
    pose = _pose(captures, frames)
    order = sorted(range(len(bodies)), key=lambda index: (index != base, float(np.linalg.norm(pose[index] - origin))))
    pose = pose[order]
    markers = _markers([bodies[index] for index in order], pose, origin, notes)
    far = max((k for k, marker in enumerate(markers) if marker.arc_length > 0 and not marker.radius), default=len(markers) - 1)
    direction = (pose[far] - origin) / np.linalg.norm(pose[far] - origin)
    return StraightArm(origin, direction, pose, markers, tuple(order), tuple(notes), frames)


def _pose(captures: Sequence[Array], frames: NDArray[np.intp]) -> Array:
    """Return the median positions (B, 3) [m] of the bodies over some frames."""
    return np.asarray(np.median(np.concatenate(captures)[frames], axis=0))


def _check_base(places: Array, origin: Array, reach: float, name: str) -> None:
    """Check that the base is clamped: that it moves less than the reach of the arm [m]."""
    moved = float(np.percentile(np.linalg.norm(places - origin, axis=1), 99))
    if moved > reach:
        raise RecordingError(
            f"the base, {name!r}, moves",
            expected=f"a clamped base; the arm reaches {reach:.3g} m from it",
            received=f"{moved:.3g} m of motion",
            hint="check the point (--base), or cut off the part in which the arm is carried",
        )


def pointing(bodies: Sequence[Body], captures: Sequence[Array], origin: Array | None) -> Array | None:
    """Return the unit vector (3,) from the base to the outermost body in the straightest pose; None without a base.

    Args:
        bodies: tracked bodies.
        captures: (T, B, 3) positions [m] of each capture, as in :func:`straight_arm`.
        origin: (3,) position of the base [m], or None.

    Raises:
        RecordingError: no frame shows all bodies.
    """
    base = next((index for index, body in enumerate(bodies) if body.is_base), None)
    if base is not None:
        places = np.concatenate([positions[:, base][seen(positions[:, base])] for positions in captures])
        origin = np.median(places, axis=0) if len(places) and origin is None else origin
    if origin is None:
        return None
    far = _farthest(bodies, captures, origin)
    pose = _pose(captures, straightest(captures, [np.linalg.norm(positions[:, far] - origin, axis=1) for positions in captures]))
    reach = pose[far] - origin
    return np.asarray(reach / np.linalg.norm(reach)) if np.linalg.norm(reach) > 0 else None


def _first(bodies: Sequence[Body]) -> tuple[int, Body]:
    """Return index and body with the smallest given arc length.

    Raises:
        InputError: no body has an arc length.
    """
    known = [(body.arc_length, index) for index, body in enumerate(bodies) if body.arc_length is not None and not body.radius]
    if not known:
        raise InputError(
            "base",
            expected="a marker at the base, the position of the base, or the arc length of a marker",
            hint="give --base, --origin, or NAME@ARC",
        )
    index = min(known)[1]
    return index, bodies[index]


def _farthest(bodies: Sequence[Body], captures: Sequence[Array], origin: Array) -> int:
    """Return the index of the body with the largest arc length or, if one is unknown, of the farthest body from the base."""
    if all(body.arc_length is not None for body in bodies):
        return max(range(len(bodies)), key=lambda index: (bodies[index].arc_length or 0.0, -bodies[index].radius))
    places = np.concatenate(captures)
    return int(
        np.argmax(
            [np.median(np.linalg.norm((p[seen(p)] - origin), axis=1)) if seen(p).any() else 0 for p in places.swapaxes(0, 1)]
        )
    )


def _estimated_base(
    bodies: Sequence[Body], captures: Sequence[Array], mount: str | None, up: Array
) -> tuple[Array, NDArray[np.intp]]:
    """Return the estimated position of the base (3,) [m], and the frames in which the arm is straightest."""
    first, body = _first(bodies)
    others = [index for index in range(len(bodies)) if index != first]
    if others:
        gaps = [np.linalg.norm(positions[:, others] - positions[:, [first]], axis=2).max(axis=1) for positions in captures]
        frames = straightest(captures, gaps)
        pose = _pose(captures, frames)
        last = others[int(np.argmax(np.linalg.norm(pose[others] - pose[first], axis=1)))]
        direction = (pose[last] - pose[first]) / np.linalg.norm(pose[last] - pose[first])
        mount = mount or mount_of(direction, up)
    elif mount in ("hanging", "upright"):
        direction = up if mount == "upright" else -up
        frames = straightest(captures, [positions[:, first] @ direction for positions in captures])
        pose = _pose(captures, frames)
    else:
        raise InputError("base", expected="a marker at the base, or the position of the base", hint="give --base or --origin")
    if mount in ("hanging", "upright"):  # a vertical arm at rest is aligned with gravity
        direction = up if mount == "upright" else -up
    return pose[first] - (body.arc_length or 0.0) * direction, frames


def _markers(bodies: Sequence[Body], pose: Array, origin: Array, notes: list[str]) -> tuple[Marker, ...]:
    """Return the bodies from base to tip as markers, with given arc lengths or those from distances in the straight pose."""
    markers: list[Marker] = []
    before, place = 0.0, origin
    known = [index for index, body in enumerate(bodies) if body.arc_length is not None]
    distances = [float(np.linalg.norm(pose[index] - origin)) for index in known]
    if pair := exchanged([bodies[index].arc_length or 0.0 for index in known], distances):
        near, far = (bodies[known[k]].name for k in pair)
        received = f"{distances[pair[0]]:.3g} m for {near!r} and {distances[pair[1]]:.3g} m for {far!r}"
        expected = f"{near!r} at most {bodies[known[pair[0]]].arc_length:g} m from the base, its arc length"
        raise RecordingError(
            "markers exchanged", expected=expected, received=received, hint="exchange their points or arc lengths"
        )
    for body, here in zip(bodies, pose, strict=True):
        step = float(np.linalg.norm(here - place))
        reach = float(np.linalg.norm(here - origin))
        if body.arc_length is None:
            arc = round(before + step, 6)
            notes.append(f"{body.name}: arc length {arc:g} m was estimated from the straightest pose")
        else:
            arc = body.arc_length
            reach = float(np.sqrt(max(reach**2 - body.radius**2, 0.0)))
            if arc > 0 and abs(reach - arc) > DISAGREES * arc:
                raise RecordingError(
                    f"marker {body.name!r} contradicts its arc length",
                    expected=f"a reach of about {arc:g} m in the straightest pose",
                    received=f"{reach:.4g} m",
                    hint="check the unit (--unit), the base and the point",
                )
            if arc > 0 and reach < STRAIGHT * arc:
                notes.append(f"{body.name}: the straightest pose reaches only {reach / arc:.0%} of its arc length")
        markers.append(Marker(body.name, arc, body.radius, body.angle or 0.0))
        if not body.radius:
            before, place = arc, here
    return tuple(markers)
