"""From the points of a tracking system to the markers of an arm: chosen by name, several averaged to one."""

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
    """A marker to be, and the points that it is the mean of.

    Attributes:
        name: of the marker.
        sources: names of points, or patterns of names (``"Tip*"``); with or without what stands before a colon.
        arc_length: [m] from the base; None: to be estimated.
        radius: [m] beside the backbone, of an arm in space.
        angle: [rad] of the side on which it stands there, from x towards y of its link; None: to be estimated.
        pose: whether its orientation is taken too, from a rigid body: "straight": its axes are brought to those of its link where
            the arm is straightest; "link": they are those already; empty: not.
    """

    name: str
    sources: tuple[str, ...]
    arc_length: float | None = None
    radius: float = 0.0
    angle: float | None = None
    pose: str = ""

    @property
    def is_base(self) -> bool:
        """Whether the arm begins at it."""
        return self.arc_length == 0 and not self.radius

    @classmethod
    def parse(cls, text: str) -> Body:
        """A body as the command line has it: ``NAME[@ARC_LENGTH[,RADIUS[,ANGLE]]]=POINT[+POINT...]``, or only ``POINT``.

        Raises:
            InputError: not of this form.
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
    """The name of a point without its subject: ``Arm:tip`` is ``tip``."""
    return name.rsplit(":", 1)[-1]


def every_point(capture: Capture) -> tuple[Body, ...]:
    """A body for each point that was given a name and was seen."""
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
    """(T, B, 3) [m] positions of bodies in the laboratory's frame, and notes.

    A body of several points is their mean where all of them were seen, and a gap elsewhere: the mean of fewer would leap. Points
    that no frame shows together are labels of one marker, which was given a new one when it came back: they count as one point.

    Raises:
        RecordingError: a source matches no point of the file; the nearest is named.
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
    """(T, 4) unit quaternions, real part first, of bodies whose pose is wanted, in the laboratory's frame; NaN where not seen.

    Raises:
        RecordingError: a body is not one whose orientation the file has, or has numbers that are no rotation.
    """
    found = {}
    for body in (body for body in bodies if body.pose):
        indices = sorted({index for source in body.sources for index in matches(capture, source)})
        name = capture.names[indices[0]]
        if len(indices) > 1 or name not in capture.orientations:
            known = ", ".join(capture.orientations)
            expected = f"one rigid body: {known}" if known else "a file that has orientations"
            hint = "its x, y and z alone come without the pose"
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
    """Points grouped by marker: those that no frame shows together may be one; of several, the one nearest by."""
    shown = {index: seen(capture.positions[:, index]) for index in indices}
    groups: list[list[int]] = []
    for index in sorted(indices, key=lambda one: int(np.argmax(shown[one]))):
        mine = np.flatnonzero(shown[index])
        free = [group for group in groups if len(mine) and not any((shown[index] & shown[other]).any() for other in group)]
        if not free:
            groups.append([index])
            continue
        min(free, key=lambda group: _apart(capture, group[-1], index)).append(index)
    return groups


def _apart(capture: Capture, before: int, after: int) -> float:
    """How far one point appears [m] from where another was seen last; endless if that was never seen."""
    places = [capture.positions[seen(capture.positions[:, index]), index] for index in (before, after)]
    return float(np.linalg.norm(places[1][0] - places[0][-1])) if all(len(each) for each in places) else np.inf


def _merged(capture: Capture, group: Sequence[int], body: Body, notes: list[str]) -> Array:
    """(T, 3) [m] a marker under whichever of its labels it was seen."""
    points = capture.positions[:, group]
    if len(group) == 1:
        return np.asarray(points[:, 0])
    which = np.where(seen(points).any(axis=1), np.argmax(seen(points), axis=1), -1)
    frames = np.flatnonzero(which >= 0)
    changes = np.flatnonzero(np.diff(which[frames]))
    before, after = frames[changes], frames[changes + 1]
    leap = np.linalg.norm(points[after, which[after]] - points[before, which[before]], axis=1).max(initial=0.0)
    names = ", ".join(capture.names[index] for index in group)
    notes.append(
        f"{body.name}: {names} are never seen together and were taken for labels of one marker, which leaps by up to "
        f"{1e3 * leap:.3g} mm where its label changes"
    )
    return np.asarray(np.where((which >= 0)[:, None], points[np.arange(len(points)), which], np.nan))


def matches(capture: Capture, source: str) -> list[int]:
    """The points that a name or pattern means: of that name, or of that name after a colon, or of that pattern.

    Raises:
        RecordingError: none; the nearest is named.
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
    raise RecordingError(f"no point {source!r} in the file", hint=nearest(source, names, "points"), file=capture.path)
