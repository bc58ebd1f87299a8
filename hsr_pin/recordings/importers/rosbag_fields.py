"""Access to fields of any messages in a bag, named in a mapping by a topic, a colon, and the path to a number.

``/pressures:data[0]`` is the first element of a list, ``/poses:poses[name=tip].pose.position.x`` is a field of the element with
the name ``tip``, and ``markers:[ID=1].x`` is a field of those messages only whose ID is 1.
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
from hsr_pin.recordings.importers.formula import Formula, FormulaError
from hsr_pin.recordings.importers.mapping import Column, InputMapping, TableMapping
from hsr_pin.recordings.importers.rosbag import on_common_clock, opened_bag, ordered, stamped_at
from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

_STEP = re.compile(r"(?P<name>[A-Za-z_]\w*)|\[(?P<index>\d+)\]|\[(?P<key>\w+)=(?P<value>[^\]]*)\]|\.")


#: A field in a formula: a topic, a colon, and a path.
_FIELD = re.compile(r"[~/]?[A-Za-z_]\w*(?:/\w+)*:(?:\w+|\[[^\]]*\]|\.)+")


@dataclass(frozen=True)
class _FieldPath:
    """Number in the messages of a topic.

    Attributes:
        topic: the topic.
        fields: paths to the numbers from which it is computed, usually one.
        formula: formula of their values; None: the value of the one field.
    """

    topic: str
    fields: tuple[str, ...]
    formula: Formula | None = None

    def __str__(self) -> str:
        return ", ".join(self.fields)


#: Time stamps [ns] and numbers of each point or command.
_Tracks = dict[str, tuple[list[int], list[tuple[float, ...]]]]


def read_mapped_bag(path: Path, mapping: TableMapping, unit: str | None = None) -> Capture:
    """Read a capture of points whose coordinates are named in a mapping.

    Args:
        path: the bag.
        mapping: mapping with three fields of one topic for each point.
        unit: unit of length, in place of that in the mapping.

    Raises:
        RecordingError: the bag is damaged, or a topic, field or message does not exist.
        MissingDependencyError: rosbags is not installed.
    """
    wanted: dict[str, list[_FieldPath | None]] = {}
    turned = dict(mapping.poses)
    for name, triple in mapping.points:
        wanted[name] = [None if column is None else _field_path(column, path) for column in triple]
        wanted[name] += [_field_path(column, path) for column in turned.get(name, ())]
        topics = {item.topic for item in wanted[name] if item is not None}
        if len(topics) > 1:
            received = " and ".join(sorted(topics))
            raise RecordingError(f"point {name!r}", expected="fields of one topic", received=received, file=mapping.path)
    tracks = _tracks(path, wanted)
    stamps = {name: track[0] for name, track in tracks.items()}
    places = {name: [each[:3] for each in track[1]] for name, track in tracks.items()}
    quaternions = {name: [each[3:] for each in tracks[name][1]] for name in turned}
    factor = metres(unit) if unit else mapping.factor
    return on_common_clock(path, stamps, places, quaternions, unit=unit or mapping.unit, factor=factor, up=mapping.known_up)


def read_bag_commands(path: Path, wanted: InputMapping, recording: Capture) -> CommandRows:
    """Read the commands in a bag, on the clock of a recording from the same computer.

    Raises:
        RecordingError: a topic, field or message does not exist.
        MissingDependencyError: rosbags is not installed.
    """
    tracks = _tracks(path, {name: [_field_path(column, path)] for name, column in wanted.columns})
    start = round(recording.start * 1e9)
    each = [ordered((np.array(stamps) - start) / 1e9, np.array(values)) for stamps, values in tracks.values()]
    time = np.unique(np.concatenate([stamps for stamps, _ in each]))
    held = np.concatenate([hold(stamps, values, time) for stamps, values in each], axis=1)
    return CommandRows.of(path, time, tuple(tracks), held * wanted.factor)


def read_bag_numbers(path: Path, columns: Sequence[str]) -> list[tuple[Array, Array]]:
    """Return times (N,) [s] and values (N,) of each of the given fields of a bag.

    Raises:
        RecordingError: a topic, field or message does not exist.
        MissingDependencyError: rosbags is not installed.
    """
    tracks = _tracks(path, {column: [_field_path(column, path)] for column in columns})
    found = [ordered(np.array(stamps), np.array(values)[:, 0]) for stamps, values in map(tracks.__getitem__, columns)]
    start = min(int(stamps[0]) for stamps, _ in found)
    return [((stamps - start) / 1e9, values) for stamps, values in found]


def _field_path(column: Column, path: Path) -> _FieldPath:
    text = str(column).strip()
    bare = text.removeprefix("-").strip()
    names = [bare] if not _STEP.sub("", bare.partition(":")[2]) else list(dict.fromkeys(_FIELD.findall(text)))
    topics, fields = [name.partition(":")[0] for name in names], tuple(name.partition(":")[2] or "data" for name in names)
    expected = "topic:field, such as /pressures:data[0] or markers:[ID=1].x, or a formula of fields of one topic"
    try:
        formula = None if text in names else Formula.parse(text, names)
    except FormulaError:
        topics = []
    if len(set(topics)) != 1 or any(_STEP.sub("", field) for field in fields):
        raise RecordingError("field of a bag", expected=expected, received=repr(text[:60]), file=path)
    return _FieldPath(topics[0], fields, formula)


def _tracks(path: Path, wanted: Mapping[str, Sequence[_FieldPath | None]]) -> _Tracks:
    """Return stamps and numbers of each wanted item, from the messages that contain all its numbers; a path of None is zero.

    Raises:
        RecordingError: a topic or field does not exist, or no message contains all numbers.
    """
    tracks: _Tracks = {name: ([], []) for name in wanted}
    topics = {name: next(item.topic for item in items if item is not None) for name, items in wanted.items()}
    with opened_bag(path) as reader:
        there = sorted({connection.topic for connection in reader.connections})
        for topic in topics.values():
            if topic not in there:
                raise RecordingError(f"the bag has no topic {topic!r}", hint=nearest(topic, there, "topics"), file=path)
        used = [connection for connection in reader.connections if connection.topic in topics.values()]
        for connection, received, raw in reader.messages(connections=used):
            message = reader.deserialize(raw, connection.msgtype)
            for name, items in wanted.items():
                if topics[name] != connection.topic:
                    continue
                found = [(0.0, message) if item is None else _number(message, item, path) for item in items]
                whole = [one for one in found if one is not None]
                if len(whole) == len(items):
                    inner = next(one for item, (_, one) in zip(items, whole, strict=True) if item is not None)
                    tracks[name][0].append(stamped_at(inner, received))
                    tracks[name][1].append(tuple(number for number, _ in whole))
    for name, (stamps, _) in tracks.items():
        if not stamps:
            fields = ", ".join(str(item) for item in wanted[name] if item is not None)
            raise RecordingError(f"{name!r} in {topics[name]}", expected=f"messages with {fields}", received="none", file=path)
    return tracks


def _number(message: Any, item: _FieldPath, path: Path) -> tuple[float, Any] | None:
    """Return the value of an item and the innermost part of the message with a time stamp; None if a field is not found.

    Raises:
        RecordingError: the messages of this topic do not have a field, or the value is not finite.
    """
    found = [_field(message, item.topic, field, path) for field in item.fields]
    whole = [one for one in found if one is not None]
    if len(whole) < len(found):
        return None
    value = whole[0][0] if item.formula is None else float(item.formula.of(np.array([[number for number, _ in whole]]))[0])
    if item.formula is not None and not np.isfinite(value):
        received = f"{value} from {', '.join(f'{number:g}' for number, _ in whole)}"
        raise RecordingError(f"formula {item.formula.text!r}", expected="a finite value", received=received, file=path)
    return value, whole[0][1]


def _field(message: Any, topic: str, field: str, path: Path) -> tuple[float, Any] | None:
    """Return the number at the end of a path and the innermost part of the message with a time stamp; None if not found."""
    value, stamped = message, message
    for step in _STEP.finditer(field):
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
            elements = "indices count from 0 and must lie within the list"
            hint = nearest(step["name"] or step["key"], there, "fields") if there else elements
            raise RecordingError(f"{topic} has no field {field!r}", hint=hint, file=path) from None
        stamped = value if hasattr(value, "header") else stamped
    try:
        return float(value), stamped
    except (TypeError, ValueError):
        received = type(value).__name__
        raise RecordingError(f"field {field!r} of {topic}", expected="a number", received=received, file=path) from None


def _elements(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]
