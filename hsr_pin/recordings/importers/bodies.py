"""Selection of the markers of an arm from the points of a tracking system, by name and by averaging."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.delimited import number
from hsr_pin.recordings.importers.capture import Capture, seen
from hsr_pin.recordings.poses import UNIT
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Body:
    """Marker to be imported, and the points whose mean it is.

    Attributes:
        name: name of the marker.
        sources: names of points or patterns of names (``"Tip*"``), with or without the part before a colon.
        arc_length: arc length from the base [m]; None: estimated.
        radius: distance from the backbone of an arm in space [m].
        angle: angle about the backbone [rad], from x towards y of the link; None: estimated.
        pose: use of the orientation of a rigid body: "straight": its axes are aligned with those of the link where the arm is
            straightest; "link": its axes are those of the link; empty: not used.
    """

    name: str
    sources: tuple[str, ...]
    arc_length: float | None = None
    radius: float = 0.0
    angle: float | None = None
    pose: str = ""

    @property
    def is_base(self) -> bool:
        """Whether the body is at the base of the arm."""
        return self.arc_length == 0 and not self.radius

    @classmethod
    def parse(cls, text: str) -> Body:
        """Return a body from its text on the command line: ``NAME[@ARC_LENGTH[,RADIUS[,ANGLE]]]=POINT[+POINT...]`` or ``POINT``.

        Raises:
            InputError: the text is not of this form.
        """
        left, _, right = text.partition("=")
        name, _, place = left.partition("@")
        name, sources = name.strip(), tuple(part.strip() for part in (right or name).split("+"))
        try:
            numbers = [number(part) for part in place.split(",")] if place.strip() else []
        except ValueError:
            numbers = [-1.0]
        good = len(numbers) <= 3 and all(value >= 0 for value in numbers[:2]) and all(np.isfinite(value) for value in numbers)
        if not name or not all(sources) or not good:
            expected = "NAME[@ARC_LENGTH[,RADIUS[,ANGLE]] in m and rad]=POINT[+POINT...]"
            raise InputError("marker", expected=expected, received=repr(text))
        arc_length, radius, angle = [*numbers, None, None, None][:3]
        return cls(name, sources, arc_length, radius or 0.0, angle)


def short(name: str) -> str:
    """Return the name of a point without its subject: ``tip`` for ``Arm:tip``."""
    return name.rsplit(":", 1)[-1]


def every_point(capture: Capture) -> tuple[Body, ...]:
    """Return a body for each named point that was seen."""
    names = [
        name
        for index, name in enumerate(capture.names)
        if name and not short(name).lower().startswith(("*", "unlabel")) and seen(capture.positions[:, index]).any()
    ]
    brief = [short(name) for name in names]
    return tuple(
        Body(mine if brief.count(mine) == 1 and mine else name, (name,)) for name, mine in zip(names, brief, strict=True)
    )


def choose(capture: Capture, bodies: Sequence[Body]) -> tuple[Array, list[str]]:
    """Return the positions (T, B, 3) [m] of bodies in the laboratory's frame, and notes.

    A body of several points is their mean where all of them were seen, and a gap elsewhere, as the mean of fewer points would
    jump. Points that are never seen together are taken as labels of one marker that reappeared under a new label.

    Raises:
        RecordingError: a source matches no point of the file; the error names the most similar point.
    """
    notes: list[str] = []
    columns = []
    for body in bodies:
        indices = sorted({index for source in body.sources for index in matches(capture, source)})
        merged = [_merged(capture, group, body, notes) for group in _labels(capture, indices)]
        points = np.stack(merged, axis=1)
        count = seen(points).sum(axis=1)
        some = int(np.sum((count > 0) & (count < len(merged))))
        if some:
            notes.append(f"{body.name}: {some} samples are gaps because not all of its {len(merged)} points were seen")
        columns.append(points.mean(axis=1))
    return np.stack(columns, axis=1), notes


def orientations(capture: Capture, bodies: Sequence[Body]) -> dict[str, Array]:
    """Return the unit quaternions (T, 4), real part first, of bodies with a pose, in the laboratory's frame; NaN where not seen.

    Raises:
        RecordingError: the file has no orientation of a body, or a quaternion is not of unit length.
    """
    found = {}
    for body in (body for body in bodies if body.pose):
        indices = sorted({index for source in body.sources for index in matches(capture, source)})
        name = capture.names[indices[0]]
        if len(indices) > 1 or name not in capture.orientations:
            known = ", ".join(capture.orientations)
            expected = f"one rigid body: {known}" if known else "a file with orientations"
            hint = "without the pose, only the position of the marker is imported"
            received = "+".join(capture.names[index] for index in indices)
            raise RecordingError(f"pose of {body.name!r}", expected=expected, received=received, hint=hint, file=capture.path)
        quaternion = capture.orientations[name]
        size = np.linalg.norm(quaternion, axis=1)
        if np.any(wrong := np.abs(size - 1) > UNIT):
            expected, received = "quaternions of length 1", f"{size[np.argmax(wrong)]:.3g}"
            raise RecordingError(f"orientation of {name!r}", expected=expected, received=received, file=capture.path)
        found[body.name] = quaternion / size[:, None]
    return found


def _labels(capture: Capture, indices: Sequence[int]) -> list[list[int]]:
    """Return points grouped by marker: points that are never seen together may be one marker, joined to the nearest candidate."""
    shown = {index: seen(capture.positions[:, index]) for index in indices}
    groups: list[list[int]] = []
    for index in sorted(indices, key=lambda one: int(np.argmax(shown[one]))):
        mine = np.flatnonzero(shown[index])
        free = [group for group in groups if len(mine) and not any((shown[index] & shown[other]).any() for other in group)]
        if not free:
            groups.append([index])
            continue
        min(free, key=lambda group: _jump_distance(capture, group[-1], index)).append(index)
    return groups


def _jump_distance(capture: Capture, before: int, after: int) -> float:
    """Return the distance [m] from the last position of one point to the next one of another; infinite if never seen."""
    places = [capture.positions[seen(capture.positions[:, index]), index] for index in (before, after)]
    return float(np.linalg.norm(places[1][0] - places[0][-1])) if all(len(each) for each in places) else np.inf


def _merged(capture: Capture, group: Sequence[int], body: Body, notes: list[str]) -> Array:
    """Return the positions (T, 3) [m] of a marker under all of its labels."""
    points = capture.positions[:, group]
    if len(group) == 1:
        return np.asarray(points[:, 0])
    which = np.where(seen(points).any(axis=1), np.argmax(seen(points), axis=1), -1)
    frames = np.flatnonzero(which >= 0)
    changes = np.flatnonzero(np.diff(which[frames]))
    before, after = frames[changes], frames[changes + 1]
    jump = np.linalg.norm(points[after, which[after]] - points[before, which[before]], axis=1).max(initial=0.0)
    names = ", ".join(capture.names[index] for index in group)
    notes.append(
        f"{body.name}: {names} are never seen together and were taken as labels of one marker, which jumps by up to "
        f"{1e3 * jump:.3g} mm where its label changes"
    )
    return np.asarray(np.where((which >= 0)[:, None], points[np.arange(len(points)), which], np.nan))


def matches(capture: Capture, source: str) -> list[int]:
    """Return the indices of the points with a given name, with that name after a colon, or matching a pattern.

    Raises:
        RecordingError: no point matches; the error names the most similar point.
    """
    names = capture.names
    for same in (
        lambda name: name == source,
        lambda name: short(name) == source,
        lambda name: fnmatchcase(name, source) or fnmatchcase(short(name), source),
    ):
        found = [index for index, name in enumerate(names) if same(name)]
        if found:
            return found
    raise RecordingError(f"the file has no point {source!r}", hint=nearest(source, names, "points"), file=capture.path)
