"""Reader of ROS 1 and ROS 2 bags (``.bag``, ``.mcap``, ``.db3``, or their folder), with rosbags (dependency group ``ros``).

Every topic with positions becomes a point: stamped poses, points and transforms, odometry, each frame of a transform tree, each
marker of an array. Topics have their own times and are interpolated to those of the topic with the most messages. A mapping names
the fields of other message types (``rosbag_fields``).
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
#: Positions closer in time than this [s] count as simultaneous.
TOGETHER = 1e-6
#: Topics of static transforms.
STILL = ("/tf_static", "tf_static")
_MAGIC = (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0")

#: Message types with positions, and functions that return for each position its name within the topic (empty if it is the only
#: one), its point, its orientation (None if it has none), and the part with the time stamp.
_Places = Callable[[Any], list[tuple[str, Any, Any, Any]]]
_KINDS: dict[str, _Places] = {
    "geometry_msgs/msg/PoseStamped": lambda message: [_pose("", message.pose, message)],
    "geometry_msgs/msg/PointStamped": lambda message: [("", message.point, None, message)],
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: [_pose("", message.pose.pose, message)],
    "geometry_msgs/msg/TransformStamped": lambda message: [_transform("", message)],
    "geometry_msgs/msg/PoseArray": lambda message: [_pose(str(n), pose, message) for n, pose in enumerate(message.poses)],
    "nav_msgs/msg/Odometry": lambda message: [_pose("", message.pose.pose, message)],
    "tf2_msgs/msg/TFMessage": lambda message: _frames(message),
    "tf/msg/tfMessage": lambda message: _frames(message),  # used in early versions of ROS 1
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
    """Return whether a path looks like a ROS bag."""
    return head.startswith(_MAGIC) or (not head and (path / "metadata.yaml").is_file())


def read_bag(path: Path, unit: str | None = None) -> Capture:
    """Read a capture from a ROS bag.

    Args:
        path: the file or folder of the bag.
        unit: unit of length; None: metres.

    Raises:
        RecordingError: the bag is damaged, or contains no positions.
        MissingDependencyError: rosbags is not installed.
    """
    stamps: dict[str, list[int]] = {}
    places: dict[str, list[tuple[float, ...]]] = {}
    quaternions: dict[str, list[tuple[float, ...]]] = {}
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
                    quaternions.setdefault(name, []).append((turn.w, turn.x, turn.y, turn.z))
        known = sorted({f"{connection.topic} ({connection.msgtype})" for connection in reader.connections})
    if not stamps:
        received = ", ".join(known)[:200] or "nothing"
        expected = "topics of poses, points, transforms or markers"
        hint = "name the fields of other messages in a mapping (--map), or record poses too"
        raise RecordingError("no marker in the bag", expected=expected, received=received, hint=hint, file=path)
    up = Up(None, "bags do not record it (z by REP 103, but y with the axes of Motive)")
    return on_common_clock(path, stamps, places, quaternions, unit=unit or UNIT, factor=metres(unit or UNIT), up=up)


def on_common_clock(
    path: Path,
    stamps: Mapping[str, Sequence[int]],
    places: Mapping[str, Sequence[tuple[float, ...]]],
    quaternions: Mapping[str, Sequence[tuple[float, ...]]],
    *,
    unit: str,
    factor: float,
    up: Up,
) -> Capture:
    """Return a capture of points with different times, interpolated to the times of the point with the most messages.

    Args:
        path: path of the bag.
        stamps: time stamps of each point [ns].
        places: positions of each point, one for each stamp.
        quaternions: unit quaternions of some points, real part first, one for each stamp.
        unit: unit of length.
        factor: metres per unit.
        up: known upward axis.
    """
    most = max(stamps, key=lambda name: len(stamps[name]))
    clock = np.unique(np.array(stamps[most], dtype=np.int64))
    time = (clock - clock[0]) / 1e9
    elapsed = {name: np.array(stamps[name]) - clock[0] for name in stamps}
    tracks = [_interpolated(time, elapsed[name], np.array(places[name], dtype=float)) for name in stamps]
    names = list(stamps)
    turned = {
        names.index(name): _interpolated_quaternions(time, elapsed[name], np.array(each, dtype=float))
        for name, each in quaternions.items()
    }
    notes = [f"imported from {path.name} (ROS bag, {unit})"]
    if len(tracks) > 1:
        notes.append(f"topics were interpolated to the times of {most}")
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
        quaternions=turned,
        still_at_zero=True,
    )


@contextmanager
def opened_bag(path: Path) -> Iterator[Any]:
    """Yield a reader of a bag.

    Raises:
        RecordingError: the bag is damaged.
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
    except Exception as error:  # rosbags raises many kinds of errors for a damaged bag
        received = f"{type(error).__name__}: {error}"[:160]
        hint = "if it is complete, extract the topics of the arm (rosbag filter, ros2 bag convert)"
        raise RecordingError("the bag cannot be read", received=received, hint=hint, file=path) from error


def stamped_at(message: Any, received: int) -> int:
    """Return the time stamp of a message [ns], or its time of reception if it has no stamp."""
    header = getattr(message, "header", None)
    stamp = 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)
    return stamp or received


def ordered(time: Array, values: Array) -> tuple[Array, Array]:
    """Return times and values sorted by time, each time once."""
    kept, first = np.unique(time, return_index=True)
    return kept, values[first]


def _interpolated(time: Array, elapsed: Array, places: Array) -> Array:
    """Return positions (T, C) interpolated linearly at other times; NaN where no sample is near."""
    source, places = ordered(elapsed / 1e9, places)
    if len(source) < 2:
        return np.full((len(time), places.shape[1]), np.nan)
    inside = (time >= source[0] - TOGETHER) & (time <= source[-1] + TOGETHER)
    track = np.full((len(time), places.shape[1]), np.nan)
    step = float(np.median(np.diff(source)))
    track[inside] = Grid(source, time[inside], step, 0.0, 0.0).positions(places)
    return track


def _interpolated_quaternions(time: Array, elapsed: Array, quaternions: Array) -> Array:
    """Return quaternions (T, 4) interpolated at other times; NaN where no sample is near or the quaternion is zero."""
    order = np.argsort(elapsed, kind="stable")
    elapsed, quaternions = elapsed[order], quaternions[order]
    size = np.linalg.norm(quaternions, axis=1)
    flips = np.sign(np.einsum("tc,tc->t", quaternions[1:], quaternions[:-1]))
    quaternions = quaternions * np.cumprod(np.append(1.0, np.where(flips < 0, -1.0, 1.0)))[:, None]
    turned = _interpolated(time, elapsed, np.where(size[:, None] > 0, quaternions, np.nan))
    between = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(turned / between if np.all(np.abs(size[size > 0] - 1) <= UNIT_QUATERNION) else turned)
