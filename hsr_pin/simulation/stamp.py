"""A mark of the source text that compiled code was made from: part of its name in the cache, so that none is ever out of date."""

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
    "laws": (_HERE / "laws.py", _HERE.parent / "effects" / "effect.py"),
    "loops": tuple(_HERE / f"{name}.py" for name in ("kernel", "march", "rest", "compiled")),
    "sight": tuple(_HERE / f"{name}.py" for name in ("sight", "compiled")),
    "space": tuple(
        _HERE / f"{name}.py"
        for name in (
            "kernel",
            "march",
            "compiled",
            *(f"space/{each}" for each in ("elements", "kernel", "loops", "rest", "system")),
        )
    ),
}


@cache
def stamp(part: str) -> str:
    """Eight characters for what is common to the laws, or for the loops."""
    return _mark(path.read_bytes() for path in _SOURCES[part])


def law_stamp(law: Callable[..., Any]) -> str:
    """The same for one law, with the files and the numbers of everything that it calls."""
    return _mark([stamp("laws").encode(), *_parts(law)])


def _parts(function: Callable[..., Any]) -> Iterator[bytes]:
    yield Path(inspect.getfile(function)).read_bytes()
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, types.FunctionType):
            yield from _parts(value)
        elif not isinstance(value, types.ModuleType):  # an imported number, say
            yield repr(value).encode()


def _mark(parts: Iterator[bytes] | list[bytes]) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:8]
