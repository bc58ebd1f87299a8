"""Settings of the arm from a mapping, in the keys of ``dataset.toml``; values from the command line take precedence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.recordings.declaration import interpolated_in
from hsr_pin.recordings.document import Section
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.mapping import CLOCK, TableMapping
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.sections import channels_of, declared_whole, sections_of, torque_columns

_NUMBERS = {"length": "m", "mass": "kg", "diameter": "m", "torsion": "Nm/rad"}
_EACH = {"keq": "Nm/rad", "damping": "Nm s/rad"}
_WORDS = ("mount", "bending")


def declared_settings(mapping: TableMapping | None, *, poses: Sequence[str] = (), **given: Any) -> ImportSettings:
    """Return import settings from the arm described in a mapping and from values given directly, which take precedence.

    Args:
        mapping: mapping that may have the tables ``[robot]``, ``[[section]]``, ``[[input]]``, ``[[measured]]`` and
            ``[[marker]]`` of the recording format, also with the ``points`` of markers; None: no mapping.
        poses: names of markers whose orientation is used too.
        given: fields of :class:`ImportSettings`; None and empty values count as not given.

    Raises:
        InputError: mass, diameter or stiffness is missing, or a setting cannot be used.
        RecordingError: the mapping is invalid; the error names file, line and column.
    """
    said = {name: value for name, value in given.items() if value is not None and np.shape(value) != (0,)}
    facts = said if mapping is None or mapping.arm is None else _declared(mapping, mapping.arm, said)
    if poses:
        facts["markers"] = _posed(facts.get("markers", ()), poses)
    for name in ("mass", "diameter", "keq"):
        if name not in facts:
            raise InputError(name, expected=f"--{name}, or {name} under [robot] in --map", received="none")
    return ImportSettings(**facts, mapping=mapping)


def _declared(mapping: TableMapping, top: Section, said: dict[str, Any]) -> dict[str, Any]:
    robot = top.section("robot") if "robot" in top.values else Section(top.path, ("robot",), {}, top.places)
    robot.only(*_NUMBERS, *_EACH, *_WORDS, "input")
    facts: dict[str, Any] = {
        name: robot.number(name, unit, zero=name == "torsion") for name, unit in _NUMBERS.items() if name in robot.values
    }
    facts |= {name: [robot.number(name, unit, zero=name == "damping")] for name, unit in _EACH.items() if name in robot.values}
    facts |= {name: robot.text(name) for name in _WORDS if name in robot.values}
    known = {"x": mapping.x, "origin": mapping.origin, "up": None if mapping.points else mapping.up}
    facts |= {name: value for name, value in known.items() if value is not None}
    facts["interpolated"] = interpolated_in(robot)
    facts |= said
    in_space = facts.get("bending") == "space"
    for key in ("section", "measured", "input"):
        if key in top.values and not in_space and not (key == "input" and isinstance(top.values[key], dict)):
            expected, hint = 'bending = "space" under [robot], or --bending space', "in a plane there is one table [input]"
            raise top.fault(key, key, expected=expected, received="neither", hint=hint if key == "input" else "")
    if "section" in top.values:
        facts |= _sections(top, robot, facts, said)
    if mapping.input is not None and isinstance(top.values["input"], list):
        count = max(1, len(facts.get("sections", ())))
        facts["channels"] = channels_of(top, count, {"t", *torque_columns(count)}, ("from", "command", *CLOCK))
    elif "measured" in top.values:
        raise top.fault(
            "measured", "measured", expected="also tables [[input]] that declare what drives the arm", received="none"
        )
    if "marker" in top.values and "markers" not in said:
        facts["markers"] = _markers(top)
    return facts


def _sections(top: Section, robot: Section, facts: Mapping[str, Any], said: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sections, and numbers of the whole arm that follow from them if they are not given."""
    tables = top.sections("section")
    length = facts.get("length") or _together(tables, "length")
    if "mass" not in facts and not any("mass" in table.values for table in tables):
        raise InputError("mass", expected="--mass, or mass under [robot] in --map, or in each [[section]]", received="none")
    mass = facts.get("mass") or _together(tables, "mass")
    kept = {key: value for key, value in robot.values.items() if key not in said}
    kept |= {key: facts[key][0] for key in _EACH if key in said and not any(key in table.values for table in tables)}
    whole = Section(robot.path, robot.key_path, {**kept, "length": length, "mass": mass}, robot.places)
    sections = sections_of(top, whole, length, mass)
    from_sections = {key: [value] for key, value in declared_whole(top, sections).items() if key not in facts}
    return {"length": length, "mass": mass, "sections": sections, **from_sections}


def _together(tables: Sequence[Section], key: str) -> float:
    """Return the sum of a number over several tables; invalid values count as zero and are reported when they are read."""
    return sum(value for table in tables if isinstance(value := table.values.get(key), int | float)) or 1.0


def _markers(top: Section) -> list[Body]:
    bodies = []
    for table in top.sections("marker"):
        table.only("name", "arc_length", "radius", "angle", "orientation", "points")
        name, points = table.text("name"), table.values.get("points", [table.values["name"]])
        if not isinstance(points, list) or not points or not all(isinstance(point, str) and point for point in points):
            raise table.fault(
                "points", "points", expected='point names, such as ["Arm:m1", "Arm:m2"]', received=repr(points)[:60]
            )
        pose = table.values.get("orientation", False)
        if pose not in (True, False, "link") or (isinstance(pose, int) and not isinstance(pose, bool)):
            expected = 'true, false, or "link" if the axes of the body are those of its link'
            raise table.fault("orientation", "orientation", expected=expected, received=repr(pose)[:60])
        bodies.append(
            Body(
                name,
                tuple(points),
                table.number("arc_length", "m", zero=True) if "arc_length" in table.values else None,
                table.number("radius", "m", zero=True) if "radius" in table.values else 0.0,
                table.angle("angle") if "angle" in table.values else None,
                pose if isinstance(pose, str) else "straight" if pose else "",
            )
        )
    return bodies


def _posed(bodies: Sequence[Body], poses: Sequence[str]) -> list[Body]:
    names = [body.name for body in bodies]
    for name in poses:
        if name not in names:
            hint = "" if names else "name the marker with --marker too"
            raise InputError("pose", expected=" or ".join(names) or "the name of a marker", received=repr(name), hint=hint)
    return [replace(body, pose=body.pose or "straight") if body.name in poses else body for body in bodies]
