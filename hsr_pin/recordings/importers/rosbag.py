"""Bags of ROS 1 and 2 (``.bag``, ``.mcap``, ``.db3``, or the folder around them), read with rosbags (group ``ros``).

Every topic of places is a point: poses, points and transforms stamped, odometry, each frame of a transform tree, each marker of
an array. Each has times of its own; they are put on those of the topic with the most messages.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import HsrError, MissingDependencyError, RecordingError
from hsr_pin.recordings.grid import Grid, hold
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.mapping import InputMapping
from hsr_pin.recordings.importers.up import Up
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

UNIT = "m"
#: Places nearer in time than this [s] were taken together.
TOGETHER = 1e-6
#: Topics of what never moves.
STILL = ("/tf_static", "tf_static")
_MAGIC = (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0")

#: What holds places, and how they are got: of each, its name within its topic (empty: it is the only one), its point, and what is
#: stamped.
_Places = Callable[[Any], list[tuple[str, Any, Any]]]
_KINDS: dict[str, _Places] = {
    "geometry_msgs/msg/PoseStamped": lambda message: [("", message.pose.position, message)],
    "geometry_msgs/msg/PointStamped": lambda message: [("", message.point, message)],
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: [("", message.pose.pose.position, message)],
    "geometry_msgs/msg/TransformStamped": lambda message: [("", message.transform.translation, message)],
    "geometry_msgs/msg/PoseArray": lambda message: [(str(n), pose.position, message) for n, pose in enumerate(message.poses)],
    "nav_msgs/msg/Odometry": lambda message: [("", message.pose.pose.position, message)],
    "tf2_msgs/msg/TFMessage": lambda message: [
        (one.child_frame_id, one.transform.translation, one) for one in message.transforms
    ],
    "visualization_msgs/msg/Marker": lambda message: [_marker(message)],
    "visualization_msgs/msg/MarkerArray": lambda message: [_marker(one) for one in message.markers],
}


def _marker(marker: Any) -> tuple[str, Any, Any]:
    return f"{marker.ns}{marker.id}", marker.pose.position, marker


def is_bag(path: Path, head: bytes) -> bool:
    """Whether a path looks like this format."""
    return head.startswith(_MAGIC) or (not head and (path / "metadata.yaml").is_file())


def read_bag(path: Path, unit: str | None = None) -> Capture:
    """Read a bag.

    Args:
        path: the file or folder.
        unit: of length, in place of metres.

    Raises:
        RecordingError: damaged, or without places.
        MissingDependencyError: rosbags is not installed.
    """
    stamps: dict[str, list[int]] = {}
    places: dict[str, list[tuple[float, float, float]]] = {}
    with _opened(path) as reader:
        topics = [
            connection for connection in reader.connections if connection.msgtype in _KINDS and connection.topic not in STILL
        ]
        for connection, received, raw in reader.messages(connections=topics) if topics else ():
            message = reader.deserialize(raw, connection.msgtype)
            for part, point, stamped in _KINDS[connection.msgtype](message):
                name = f"{connection.topic}/{part}" if part else str(connection.topic)
                stamps.setdefault(name, []).append(_stamp(stamped, received))
                places.setdefault(name, []).append((point.x, point.y, point.z))
        known = sorted({f"{connection.topic} ({connection.msgtype})" for connection in reader.connections})
    if not stamps:
        received = ", ".join(known)[:200] or "nothing"
        expected = "topics of poses, points, transforms or markers"
        raise RecordingError("no marker in the bag", expected=expected, received=received, file=path)
    clock = np.unique(np.array(max(stamps.values(), key=len), dtype=np.int64))
    time = (clock - clock[0]) / 1e9
    tracks = [_on_clock(time, np.array(stamps[name]) - clock[0], np.array(places[name])) for name in stamps]
    notes = [f"imported from {path.name} (ROS bag, {unit or UNIT})"]
    if len(tracks) > 1:
        notes.append(f"topics were put on the times of {max(stamps, key=lambda name: len(stamps[name]))}, along their motion")
    return capture(
        path,
        "ROS bag",
        time,
        list(stamps),
        np.stack(tracks, axis=1) * metres(unit or UNIT),
        up=Up(None, "a bag does not tell (z by REP 103, but y where Motive's own axes are passed on)"),
        unit=unit or UNIT,
        start=float(clock[0] / 1e9),
        notes=notes,
    )


def read_bag_commands(path: Path, wanted: InputMapping, recording: Capture) -> CommandRows:
    """Commands in a bag, each ``topic:field`` (``/pressures:data[0]``), on the clock of a recording of the same computer.

    Raises:
        RecordingError: no such topic or field.
        MissingDependencyError: rosbags is not installed.
    """
    tracks: dict[str, tuple[list[int], list[float]]] = {name: ([], []) for name, _ in wanted.columns}
    with _opened(path) as reader:
        topics = {connection.topic for connection in reader.connections}
        ways = {name: _way(str(column), topics, path) for name, column in wanted.columns}
        used = [connection for connection in reader.connections if connection.topic in {topic for topic, _ in ways.values()}]
        for connection, received, raw in reader.messages(connections=used):
            message = reader.deserialize(raw, connection.msgtype)
            for name, (topic, field) in ways.items():
                if topic == connection.topic:
                    tracks[name][0].append(_stamp(message, received))
                    tracks[name][1].append(_field(message, field, topic, path))
    start = round(recording.start * 1e9)
    each = [_ordered((np.array(stamps) - start) / 1e9, np.array(values)[:, None]) for stamps, values in tracks.values()]
    time = np.unique(np.concatenate([stamps for stamps, _ in each]))
    held = np.concatenate([hold(stamps, values, time) for stamps, values in each], axis=1)
    return CommandRows(path, time, tuple(tracks), held * wanted.factor)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingDependencyError("rosbags", "ros") from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            yield reader
    except HsrError:
        raise
    except Exception as error:  # a damaged bag fails in many ways
        received = f"{type(error).__name__}: {error}"[:160]
        raise RecordingError(
            "not a bag that can be read", received=received, hint="is it whole? record it anew", file=path
        ) from error


def _stamp(message: Any, received: int) -> int:
    """[ns] when a message was stamped, or else received."""
    header = getattr(message, "header", None)
    stamp = 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)
    return stamp or received


def _ordered(time: Array, values: Array) -> tuple[Array, Array]:
    """In order of time, each time once."""
    kept, first = np.unique(time, return_index=True)
    return kept, values[first]


def _on_clock(time: Array, elapsed: Array, places: Array) -> Array:
    """(T, 3) places at other times: a straight line between neighbours, nothing where there are none near."""
    source, places = _ordered(elapsed / 1e9, places)
    if len(source) < 2:
        return np.full((len(time), 3), np.nan)
    inside = (time >= source[0] - TOGETHER) & (time <= source[-1] + TOGETHER)
    track = np.full((len(time), 3), np.nan)
    step = float(np.median(np.diff(source)))
    track[inside] = Grid(source, time[inside], step, 0.0, TOGETHER).positions(places)
    return track


def _way(column: str, topics: set[str], path: Path) -> tuple[str, str]:
    topic, _, field = column.partition(":")
    if topic not in topics:
        raise RecordingError(f"no topic {topic!r} in the bag", hint=nearest(topic, sorted(topics), "topics"), file=path)
    return topic, field or "data"


def _field(message: Any, field: str, topic: str, path: Path) -> float:
    value = message
    for name, index in re.findall(r"([A-Za-z_]\w*)|\[(\d+)\]", field):
        try:
            value = getattr(value, name) if name else value[int(index)]
        except (AttributeError, IndexError, TypeError):
            there = [key for key in getattr(value, "__dataclass_fields__", {}) if not key.startswith("_")]
            hint = nearest(name, there, "fields") if name else "count from 0"
            raise RecordingError(f"no field {field!r} in {topic}", hint=hint, file=path) from None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise RecordingError(
            f"field {field!r} of {topic}", expected="a number", received=type(value).__name__, file=path
        ) from None
