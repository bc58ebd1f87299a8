"""Fields of any messages in a bag, as a mapping names them: a topic, a colon, and the way to a number.

``/pressures:data[0]`` is the first of a list, ``/poses:poses[name=tip].pose.position.x`` stands in that element of it whose name
is ``tip``, and ``markers:[ID=1].x`` in those messages alone whose ID is 1.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.grid import hold
from hsr_pin.recordings.importers.capture import Capture, metres
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.mapping import Column, InputMapping, TableMapping
from hsr_pin.recordings.importers.rosbag import on_one_clock, opened_bag, ordered, stamped_at
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

_STEP = re.compile(r"(?P<name>[A-Za-z_]\w*)|\[(?P<index>\d+)\]|\[(?P<key>\w+)=(?P<value>[^\]]*)\]|\.")


@dataclass(frozen=True)
class _Way:
    """To a number in the messages of a topic."""

    topic: str
    field: str
    sign: float = 1.0


#: Of each point or command: when it was stamped [ns], and its numbers then.
_Tracks = dict[str, tuple[list[int], list[tuple[float, ...]]]]


def read_mapped_bag(path: Path, mapping: TableMapping, unit: str | None = None) -> Capture:
    """Read points whose coordinates a mapping names.

    Args:
        path: the bag.
        mapping: three fields of one topic for each point.
        unit: of length, in place of the mapping's.

    Raises:
        RecordingError: damaged, or no such topic, field or message.
        MissingDependencyError: rosbags is not installed.
    """
    wanted: dict[str, list[_Way | None]] = {}
    turned = dict(mapping.poses)
    for name, triple in mapping.points:
        wanted[name] = [None if place.column is None else _way(place.column, path) for place in triple]
        wanted[name] += [_way(column, path) for column in turned.get(name, ())]
        topics = {way.topic for way in wanted[name] if way is not None}
        if len(topics) > 1:
            received = " and ".join(sorted(topics))
            raise RecordingError(f"point {name!r}", expected="fields of one topic", received=received, file=mapping.path)
    tracks = _tracks(path, wanted)
    stamps = {name: track[0] for name, track in tracks.items()}
    places = {name: [each[:3] for each in track[1]] for name, track in tracks.items()}
    turns = {name: [each[3:] for each in tracks[name][1]] for name in turned}
    factor = metres(unit) if unit else mapping.factor
    return on_one_clock(path, stamps, places, turns, unit=unit or mapping.unit, factor=factor, up=mapping.known_up)


def read_bag_commands(path: Path, wanted: InputMapping, recording: Capture) -> CommandRows:
    """Commands in a bag, on the clock of a recording of the same computer.

    Raises:
        RecordingError: no such topic, field or message.
        MissingDependencyError: rosbags is not installed.
    """
    tracks = _tracks(path, {name: [_way(column, path)] for name, column in wanted.columns})
    start = round(recording.start * 1e9)
    each = [ordered((np.array(stamps) - start) / 1e9, np.array(values)) for stamps, values in tracks.values()]
    time = np.unique(np.concatenate([stamps for stamps, _ in each]))
    held = np.concatenate([hold(stamps, values, time) for stamps, values in each], axis=1)
    return CommandRows(path, time, tuple(tracks), held * wanted.factor)


def read_bag_numbers(path: Path, columns: Sequence[str]) -> list[tuple[Array, Array]]:
    """(N,) times [s] and (N,) values of each of these fields of a bag.

    Raises:
        RecordingError: no such topic, field or message.
        MissingDependencyError: rosbags is not installed.
    """
    tracks = _tracks(path, {column: [_way(column, path)] for column in columns})
    found = [ordered(np.array(stamps), np.array(values)[:, 0]) for stamps, values in map(tracks.__getitem__, columns)]
    start = min(int(stamps[0]) for stamps, _ in found)
    return [((stamps - start) / 1e9, values) for stamps, values in found]


def _way(column: Column, path: Path) -> _Way:
    text = str(column).strip()
    topic, _, field = text.removeprefix("-").partition(":")
    if _STEP.sub("", field):
        expected = "topic:field, as /pressures:data[0] or markers:[ID=1].x"
        raise RecordingError("field of a bag", expected=expected, received=repr(text[:60]), file=path)
    return _Way(topic, field or "data", -1.0 if text.startswith("-") else 1.0)


def _tracks(path: Path, wanted: Mapping[str, Sequence[_Way | None]]) -> _Tracks:
    """Of everything wanted, what the messages have that hold all its numbers; None is zero.

    Raises:
        RecordingError: there is no such topic or field, or no message holds them.
    """
    tracks: _Tracks = {name: ([], []) for name in wanted}
    topics = {name: next(way.topic for way in ways if way is not None) for name, ways in wanted.items()}
    with opened_bag(path) as reader:
        there = sorted({connection.topic for connection in reader.connections})
        for topic in topics.values():
            if topic not in there:
                raise RecordingError(f"no topic {topic!r} in the bag", hint=nearest(topic, there, "topics"), file=path)
        used = [connection for connection in reader.connections if connection.topic in topics.values()]
        for connection, received, raw in reader.messages(connections=used):
            message = reader.deserialize(raw, connection.msgtype)
            for name, ways in wanted.items():
                if topics[name] != connection.topic:
                    continue
                found = [(0.0, message) if way is None else _number(message, way, path) for way in ways]
                whole = [one for one in found if one is not None]
                if len(whole) == len(ways):
                    inner = next(one for way, (_, one) in zip(ways, whole, strict=True) if way is not None)
                    tracks[name][0].append(stamped_at(inner, received))
                    tracks[name][1].append(tuple(number for number, _ in whole))
    for name, (stamps, _) in tracks.items():
        if not stamps:
            fields = ", ".join(way.field for way in wanted[name] if way is not None)
            raise RecordingError(f"{name!r} in {topics[name]}", expected=f"messages with {fields}", received="none", file=path)
    return tracks


def _number(message: Any, way: _Way, path: Path) -> tuple[float, Any] | None:
    """The number at the end of a way, and the innermost part of the message on it that is stamped; None: not in this one.

    Raises:
        RecordingError: no message of this topic can have it.
    """
    value, stamped = message, message
    for step in _STEP.finditer(way.field):
        try:
            if step["key"]:
                chosen = [one for one in _elements(value) if str(getattr(one, step["key"])) == step["value"]]
                if not chosen:
                    return None
                value = chosen[0]
            elif step["index"]:
                value = value[int(step["index"])]
            elif step["name"]:
                value = getattr(value, step["name"])
        except (AttributeError, IndexError, TypeError):
            there = [key for key in getattr(value, "__dataclass_fields__", {}) if not key.startswith("_")]
            hint = nearest(step["name"] or step["key"], there, "fields") if there else "count from 0, within the list"
            raise RecordingError(f"no field {way.field!r} in {way.topic}", hint=hint, file=path) from None
        stamped = value if hasattr(value, "header") else stamped
    try:
        return way.sign * float(value), stamped
    except (TypeError, ValueError):
        received = type(value).__name__
        raise RecordingError(f"field {way.field!r} of {way.topic}", expected="a number", received=received, file=path) from None


def _elements(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]
