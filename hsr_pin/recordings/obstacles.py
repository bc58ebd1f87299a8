"""Obstacles beside the arm, as declared in the tables ``[[obstacle]]`` of a ``dataset.toml``."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from hsr_pin.errors import InputError
from hsr_pin.obstacles import MATERIALS, SHAPES, Obstacle, Surface
from hsr_pin.recordings.document import Section as Table
from hsr_pin.recordings.text import nearest

#: Numbers of the contact law, with their units.
_SURFACE = {"stiffness": "N/m^2", "dissipation": "s/m", "friction": "1"}
#: Units of the other keys.
_UNITS = {"point": "m", "normal": "1", "centre": "m", "axis": "1", "radius": "m", "length": "m", "size": "m", "rotation": "rad"}


def obstacles_of(top: Table) -> tuple[Obstacle, ...]:
    """Return the obstacles of the tables ``[[obstacle]]``.

    Raises:
        RecordingError: a table is invalid; the error names file, line and column.
    """
    return tuple(_obstacle(table) for table in (top.sections("obstacle") if "obstacle" in top.values else ()))


def _obstacle(table: Table) -> Obstacle:
    shape = table.text("shape")
    if shape not in SHAPES:
        raise table.fault("shape", "shape", expected=", ".join(SHAPES), received=shape, hint=nearest(shape, SHAPES, "shapes"))
    own = [field.name for field in fields(SHAPES[shape]) if field.name not in _SURFACE]
    table.only("shape", "material", *_SURFACE, *own)
    values: dict[str, Any] = {}
    if "material" in table.values:
        material = table.text("material")
        if material not in MATERIALS:
            hint = nearest(material, MATERIALS, "materials")
            raise table.fault("material", "material", expected=", ".join(MATERIALS), received=material, hint=hint)
        values.update(Surface.of(material)._asdict())
    for key, unit in _SURFACE.items():
        if key in table.values:
            values[key] = table.number(key, unit, zero=key != "stiffness")
    for key in own:
        if key not in table.values:
            continue
        given: Any = table.values[key]
        values[key] = tuple(given) if isinstance(given, list) else given
    for key in own:
        if key in ("point", "centre", "radius", "size") and key not in values:
            raise table.fault(key, expected=f"a value [{_UNITS[key]}]", received="none")
    try:
        return SHAPES[shape](**values)
    except InputError as error:
        key = error.subject.split()[0]
        raise table.fault(key, key, expected=error.expected, received=error.received) from error


def obstacle_lines(obstacle: Obstacle) -> list[str]:
    """Return the lines of a table ``[[obstacle]]``, which read back exactly."""
    lines = ["", "[[obstacle]]", f'shape = "{obstacle.shape}"']
    for field in fields(obstacle):
        value = getattr(obstacle, field.name)
        text = repr(list(value)) if isinstance(value, tuple) else repr(float(value))
        lines.append(f"{field.name} = {text}  # {(_UNITS | _SURFACE)[field.name]}")
    return lines
