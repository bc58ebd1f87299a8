"""Bags of ROS 1 and 2 (``.bag``, ``.mcap``, ``.db3``, or the folder around them), read with rosbags (group ``ros``).

Every topic of places is a point: poses, points and transforms stamped, odometry, each frame of a transform tree, each marker of
an array. Each has times of its own; they are put on those of the topic with the most messages. For messages of other types a
mapping names their fields (``rosbag_fields``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import HsrError, MissingDependencyError, RecordingError
from hsr_pin.recordings.grid import Grid
from hsr_pin.recordings.importers.capture import Capture, capture, metres
from hsr_pin.recordings.importers.up import Up
from hsr_pin.recordings.poses import UNIT as UNIT_QUATERNION
from hsr_pin.trajectory import Array

UNIT = "m"
#: Places nearer in time than this [s] were taken together.
TOGETHER = 1e-6
#: Topics of what never moves.
STILL = ("/tf_static", "tf_static")
_MAGIC = (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0")

#: What holds places, and how they are got: of each, its name within its topic (empty: it is the only one), its point, its
#: orientation (None: a point has none), and what is stamped.
_Places = Callable[[Any], list[tuple[str, Any, Any, Any]]]
_KINDS: dict[str, _Places] = {
    "geometry_msgs/msg/PoseStamped": lambda message: [_pose("", message.pose, message)],
    "geometry_msgs/msg/PointStamped": lambda message: [("", message.point, None, message)],
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: [_pose("", message.pose.pose, message)],
    "geometry_msgs/msg/TransformStamped": lambda message: [_transform("", message)],
    "geometry_msgs/msg/PoseArray": lambda message: [_pose(str(n), pose, message) for n, pose in enumerate(message.poses)],
    "nav_msgs/msg/Odometry": lambda message: [_pose("", message.pose.pose, message)],
    "tf2_msgs/msg/TFMessage": lambda message: _frames(message),
    "tf/msg/tfMessage": lambda message: _frames(message),  # of the first years of ROS 1
    "visualization_msgs/msg/Marker": lambda message: [_marker(message)],
    "visualization_msgs/msg/MarkerArray": lambda message: [_marker(one) for one in message.markers],
}


def _pose(name: str, pose: Any, message: Any) -> tuple[str, Any, Any, Any]:
    return name, pose.position, pose.orientation, message


def _transform(name: str, message: Any) -> tuple[str, Any, Any, Any]:
    return name, message.transform.translation, message.transform.rotation, message


def _frames(message: Any) -> list[tuple[str, Any, Any, Any]]:
    return [_transform(one.child_frame_id, one) for one in message.transforms]


def _marker(marker: Any) -> tuple[str, Any, Any, Any]:
    return _pose(f"{marker.ns}{marker.id}", marker.pose, marker)


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
    places: dict[str, list[tuple[float, ...]]] = {}
    turns: dict[str, list[tuple[float, ...]]] = {}
    with opened_bag(path) as reader:
        topics = [
            connection for connection in reader.connections if connection.msgtype in _KINDS and connection.topic not in STILL
        ]
        for connection, received, raw in reader.messages(connections=topics) if topics else ():
            message = reader.deserialize(raw, connection.msgtype)
            for part, point, turn, stamped in _KINDS[connection.msgtype](message):
                name = f"{connection.topic}/{part}" if part else str(connection.topic)
                stamps.setdefault(name, []).append(stamped_at(stamped, received))
                places.setdefault(name, []).append((point.x, point.y, point.z))
                if turn is not None:
                    turns.setdefault(name, []).append((turn.w, turn.x, turn.y, turn.z))
        known = sorted({f"{connection.topic} ({connection.msgtype})" for connection in reader.connections})
    if not stamps:
        received = ", ".join(known)[:200] or "nothing"
        expected = "topics of poses, points, transforms or markers"
        hint = "name the fields of other messages in a mapping (--map), or record poses too"
        raise RecordingError("no marker in the bag", expected=expected, received=received, hint=hint, file=path)
    up = Up(None, "a bag does not tell (z by REP 103, but y where Motive's own axes are passed on)")
    return on_one_clock(path, stamps, places, turns, unit=unit or UNIT, factor=metres(unit or UNIT), up=up)


def on_one_clock(
    path: Path,
    stamps: Mapping[str, Sequence[int]],
    places: Mapping[str, Sequence[tuple[float, ...]]],
    turns: Mapping[str, Sequence[tuple[float, ...]]],
    *,
    unit: str,
    factor: float,
    up: Up,
) -> Capture:
    """Points that have times of their own, on those of the point with the most.

    Args:
        path: of the bag.
        stamps: of each point [ns].
        places: of each point, as many.
        turns: of some points, as many: quaternions, real part first.
        unit: of length.
        factor: metres in one of it.
        up: what is known about it.
    """
    most = max(stamps, key=lambda name: len(stamps[name]))
    clock = np.unique(np.array(stamps[most], dtype=np.int64))
    time = (clock - clock[0]) / 1e9
    elapsed = {name: np.array(stamps[name]) - clock[0] for name in stamps}
    tracks = [_on_clock(time, elapsed[name], np.array(places[name], dtype=float)) for name in stamps]
    names = list(stamps)
    turned = {names.index(name): _turned(time, elapsed[name], np.array(each, dtype=float)) for name, each in turns.items()}
    notes = [f"imported from {path.name} (ROS bag, {unit})"]
    if len(tracks) > 1:
        notes.append(f"topics were put on the times of {most}, along their motion")
    return capture(
        path,
        "ROS bag",
        time,
        names,
        np.stack(tracks, axis=1),
        up=up,
        unit=unit,
        factor=factor,
        start=float(clock[0] / 1e9),
        notes=notes,
        turns=turned,
        still_at_zero=True,
    )


@contextmanager
def opened_bag(path: Path) -> Iterator[Any]:
    """A reader of a bag.

    Raises:
        RecordingError: damaged.
        MissingDependencyError: rosbags is not installed.
    """
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
        hint = "is it whole? if so, take the topics of the arm alone out of it (rosbag filter, ros2 bag convert)"
        raise RecordingError("not a bag that can be read", received=received, hint=hint, file=path) from error


def stamped_at(message: Any, received: int) -> int:
    """[ns] when a message was stamped, or else received."""
    header = getattr(message, "header", None)
    stamp = 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)
    return stamp or received


def ordered(time: Array, values: Array) -> tuple[Array, Array]:
    """In order of time, each time once."""
    kept, first = np.unique(time, return_index=True)
    return kept, values[first]


def _on_clock(time: Array, elapsed: Array, places: Array) -> Array:
    """(T, C) places at other times: a straight line between neighbours, nothing where there are none near."""
    source, places = ordered(elapsed / 1e9, places)
    if len(source) < 2:
        return np.full((len(time), places.shape[1]), np.nan)
    inside = (time >= source[0] - TOGETHER) & (time <= source[-1] + TOGETHER)
    track = np.full((len(time), places.shape[1]), np.nan)
    step = float(np.median(np.diff(source)))
    track[inside] = Grid(source, time[inside], step, 0.0, 0.0).positions(places)
    return track


def _turned(time: Array, elapsed: Array, turns: Array) -> Array:
    """(T, 4) quaternions at other times, in the same way; all zero (a message that was never filled in) was not seen."""
    order = np.argsort(elapsed, kind="stable")
    elapsed, turns = elapsed[order], turns[order]
    size = np.linalg.norm(turns, axis=1)
    flips = np.sign(np.einsum("tc,tc->t", turns[1:], turns[:-1]))
    turns = turns * np.cumprod(np.append(1.0, np.where(flips < 0, -1.0, 1.0)))[:, None]
    turned = _on_clock(time, elapsed, np.where(size[:, None] > 0, turns, np.nan))
    between = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(turned / between if np.all(np.abs(size[size > 0] - 1) <= UNIT_QUATERNION) else turned)
