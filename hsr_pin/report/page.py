"""Jinja environment of the report templates."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from hsr_pin.inference.estimates import number

_HERE = Path(__file__).parent


def environment(*folders: Path) -> Environment:
    """Return the environment for templates in ``folders`` and for the style sheet in this folder.

    Undefined variables raise an error, and all values are HTML-escaped.
    """
    found = Environment(
        loader=FileSystemLoader([*folders, _HERE]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    found.filters |= {"mm": lambda metres: f"{number(1e3 * metres)} mm", "number": number, "percent": _percent}
    return found


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %".replace("-0.0", "0.0")
