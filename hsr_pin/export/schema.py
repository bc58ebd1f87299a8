"""What a result must be to be read again: a check for each part of its JSON, made before anything is taken from it.

A check takes a value and the way to it (``arm.levels[0].keq``). Fields that no check names may be anything.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from hsr_pin.errors import InputError, quoted
from hsr_pin.identification.part import ARM, SESSION
from hsr_pin.robot.specification import MAX_LINKS, RANGES
from hsr_pin.trajectory import BENDS, MOUNTS

#: Raises an InputError that names the way to the value.
Check: TypeAlias = Callable[[Any, str], None]


def number(lower: float = -sys.float_info.max, upper: float = sys.float_info.max, *, null: bool = False) -> Check:
    """A finite number within bounds, or also ``null``."""
    bounds = "" if upper == sys.float_info.max else f" from {lower:g} to {upper:g}"

    def check(value: Any, way: str) -> None:
        fits = isinstance(value, int | float) and not isinstance(value, bool) and lower <= value <= upper
        if not fits and not (null and value is None):
            raise InputError(way, expected=f"a number{bounds}", received=quoted(value))

    return check


def text(value: Any, way: str) -> None:
    """Any text."""
    if not isinstance(value, str):
        raise InputError(way, expected="a text", received=quoted(value))


def name(value: Any, way: str) -> None:
    """A text of one line, without control characters, which XML cannot hold."""
    if not (isinstance(value, str) and value.strip() and value.isprintable()):
        raise InputError(way, expected="a text of one printable line", received=quoted(value))


def word(*choices: str) -> Check:
    """One of several texts."""

    def check(value: Any, way: str) -> None:
        if not (isinstance(value, str) and value in choices):
            raise InputError(way, expected=" or ".join(choices), received=quoted(value))

    return check


def each(item: Check, *, least: int = 0) -> Check:
    """A list of so many at least."""

    def check(value: Any, way: str) -> None:
        if not isinstance(value, list) or len(value) < least:
            raise InputError(way, expected="a list" + (f" of at least {least}" if least else ""), received=quoted(value))
        for place, part in enumerate(value):
            item(part, f"{way}[{place}]")

    return check


def named(item: Check) -> Check:
    """A table of any names."""

    def check(value: Any, way: str) -> None:
        _check_table(value, way)
        for key, part in value.items():
            item(part, f"{way}.{key}")

    return check


def table(needed: Mapping[str, Check], also: Mapping[str, Check]) -> Check:
    """A table with the fields that are needed; what it may have besides is checked where it is there."""

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
    """Fitted values by name, alone or as ``value`` of a table; numbers of the arm within the bounds of a fit."""
    _check_table(value, way)
    for key, told in value.items():
        known = (ARM | SESSION).get(key.partition("@")[0])
        bounds = (known.lower, known.upper) if known else ()
        number(*bounds)(told.get("value") if isinstance(told, dict) else told, f"{way}.{key}")


def _of_arm(*names: str) -> dict[str, Check]:
    return {field: number(*RANGES[field][1:]) for field in names}


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
    },
)
_CANDIDATE = table({"effects": each(text), "parameters": _parameters}, {"options": named(text), "resized": each(text)})
_VERDICT = table({}, {"status": text, "effects": each(text), "sentence": text})
DIAGNOSIS = table({"candidates": each(_CANDIDATE, least=1)}, {"verdict": _VERDICT, "dataset": text})
FIT = table({"parameters": _parameters}, {"effects": each(text), "dataset": text, **_LINKS})
