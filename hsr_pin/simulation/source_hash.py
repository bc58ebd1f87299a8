"""Hashes of the source code that machine code is compiled from; as part of its name in the cache, they keep it up to date."""

from __future__ import annotations

import hashlib
import inspect
import types
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

_HERE = Path(__file__).parent
_SOURCES = {
    "contact": (
        *(_HERE / f"{name}.py" for name in ("contact", "kernel", "laws", "space/kernel", "space/elements")),
        _HERE.parent / "obstacles.py",
    ),
    "laws": (_HERE / "laws.py", _HERE.parent / "effects" / "effect.py"),
    "loops": tuple(_HERE / f"{name}.py" for name in ("kernel", "integrate", "equilibrium", "compiled")),
    "marker_projection": tuple(_HERE / f"{name}.py" for name in ("marker_projection", "compiled")),
    "space": tuple(
        _HERE / f"{name}.py"
        for name in (
            "kernel",
            "integrate",
            "compiled",
            *(f"space/{each}" for each in ("elements", "equilibrium", "kernel", "loops", "system")),
        )
    ),
}


@cache
def source_hash(part: str) -> str:
    """Return a hash of eight characters of the sources of the loops, or of the sources that all laws share."""
    return _digest(path.read_bytes() for path in _SOURCES[part])


def law_hash(law: Callable[..., Any]) -> str:
    """Return a hash of eight characters of the sources of one law: all files and constants that it depends on."""
    return _digest([source_hash("laws").encode(), *_parts(law)])


def _parts(function: Callable[..., Any]) -> Iterator[bytes]:
    yield Path(inspect.getfile(function)).read_bytes()
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, types.FunctionType):
            yield from _parts(value)
        elif not isinstance(value, types.ModuleType):  # for example an imported number
            yield repr(value).encode()


def _digest(parts: Iterator[bytes] | list[bytes]) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:8]
