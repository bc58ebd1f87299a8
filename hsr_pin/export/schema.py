"""Validation of a result in JSON before it is read.

A check is a function of a value and its path (``arm.levels[0].keq``). Fields without a check may have any value.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from hsr_pin.errors import InputError, quoted
from hsr_pin.identification.part import ARM, SESSION
from hsr_pin.obstacles import from_dict
from hsr_pin.robot.specification import MAX_LINKS, RANGES
from hsr_pin.trajectory import BENDS, MOUNTS

#: Function of a value and its path, which raises an InputError with the path if the value is invalid.
Check: TypeAlias = Callable[[Any, str], None]


def number(lower: float = -sys.float_info.max, upper: float = sys.float_info.max, *, null: bool = False) -> Check:
    """Return a check for a finite number within bounds, or also ``null``."""
    bounds = "" if upper == sys.float_info.max else f" from {lower:g} to {upper:g}"

    def check(value: Any, way: str) -> None:
        fits = isinstance(value, int | float) and not isinstance(value, bool) and lower <= value <= upper
        if not fits and not (null and value is None):
            raise InputError(way, expected=f"a number{bounds}", received=quoted(value))

    return check


def text(value: Any, way: str) -> None:
    """Check that a value is a string."""
    if not isinstance(value, str):
        raise InputError(way, expected="a string", received=quoted(value))


def name(value: Any, way: str) -> None:
    """Check that a value is a string of one line without control characters, which XML does not allow."""
    if not (isinstance(value, str) and value.strip() and value.isprintable()):
        raise InputError(way, expected="a printable string of one line", received=quoted(value))


def word(*choices: str) -> Check:
    """Return a check for one of several strings."""

    def check(value: Any, way: str) -> None:
        if not (isinstance(value, str) and value in choices):
            raise InputError(way, expected=" or ".join(choices), received=quoted(value))

    return check


def each(item: Check, *, least: int = 0) -> Check:
    """Return a check for a list with a minimum length, whose items pass another check."""

    def check(value: Any, way: str) -> None:
        if not isinstance(value, list) or len(value) < least:
            raise InputError(way, expected="a list" + (f" of at least {least}" if least else ""), received=quoted(value))
        for place, part in enumerate(value):
            item(part, f"{way}[{place}]")

    return check


def named(item: Check) -> Check:
    """Return a check for a table with any names, whose values pass another check."""

    def check(value: Any, way: str) -> None:
        _check_table(value, way)
        for key, part in value.items():
            item(part, f"{way}.{key}")

    return check


def table(needed: Mapping[str, Check], also: Mapping[str, Check]) -> Check:
    """Return a check for a table with required fields and optional fields."""

    def check(value: Any, way: str) -> None:
        _check_table(value, way)
        for key in needed:
            if key not in value:
                raise InputError(f"{way}.{key}".lstrip("."), expected="a value", received="none")
        for key, part in {**needed, **also}.items():
            if key in value:
                part(value[key], f"{way}.{key}".lstrip("."))

    return check


def _check_table(value: Any, way: str) -> None:
    if not isinstance(value, dict):
        raise InputError(way, expected="a table", received=quoted(value))


def _parameters(value: Any, way: str) -> None:
    """Check fitted values, given by name as numbers or as ``value`` of a table; numbers of the arm have the bounds of a fit."""
    _check_table(value, way)
    for key, fitted in value.items():
        known = (ARM | SESSION).get(key.partition("@")[0])
        bounds = (known.lower, known.upper) if known else ()
        number(*bounds)(fitted.get("value") if isinstance(fitted, dict) else fitted, f"{way}.{key}")


def _of_arm(*names: str) -> dict[str, Check]:
    return {field: number(*RANGES[field][1:]) for field in names}


def _an_obstacle(value: Any, way: str) -> None:
    """Check one obstacle."""
    _check_table(value, way)
    try:
        from_dict(value)
    except InputError as error:
        raise InputError(f"{way}: {error.subject}", expected=error.expected, received=error.received) from error


_LENGTH = number(0.0, RANGES["length"][2])
_LINKS = {"links": number(1, MAX_LINKS), "placement": word("base", "mid", "shifted")}
_EFFECT = table({"name": text}, {"parameters": named(number()), "options": named(text)})
ARM_SECTION = table(
    {
        **_of_arm("length", "mass", "diameter"),
        "mount": word(*MOUNTS),
        "levels": each(table(_of_arm("keq", "damping"), _of_arm("tip_mass")), least=1),
        "markers": each(table({"name": name, "arc_length": _LENGTH}, {"radius": _LENGTH, "angle": number()}), least=1),
    },
    {
        **_LINKS,
        "bending": word(*BENDS),
        "torsion": number(0.0, RANGES["keq"][2], null=True),
        "sections": each(table(_of_arm("length", "mass", "keq", "damping"), {})),
        "inputs": each(table({"name": name, "unit": name, "torque": each(number())}, {})),
        "effects": each(_EFFECT),
        "obstacles": each(_an_obstacle),
    },
)
_CANDIDATE = table({"effects": each(text), "parameters": _parameters}, {"options": named(text), "resized": each(text)})
_VERDICT = table({}, {"status": text, "effects": each(text), "sentence": text})
DIAGNOSIS = table({"candidates": each(_CANDIDATE, least=1)}, {"verdict": _VERDICT, "dataset": text})
FIT = table({"parameters": _parameters}, {"effects": each(text), "dataset": text, **_LINKS})
