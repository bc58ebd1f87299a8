"""Rendering of the templates of this package."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hsr_pin.errors import one_line

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup


def render(template: str, **values: Any) -> str:
    """Render a template; values in XML are escaped."""
    return _environment(not template.endswith(".py.jinja")).get_template(template).render(**values)


@lru_cache(maxsize=2)
def _environment(escape: bool) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # imported here, as `--help` does not need it

    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=StrictUndefined,
        autoescape=escape,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters["number"] = number
    made.filters["row"] = lambda values: " ".join(map(number, values))
    made.filters["comment"] = comment
    return made


def comment(text: object) -> Markup:
    """Return a text for an XML comment, without double hyphens and control characters, which are not allowed there."""
    from markupsafe import Markup

    return Markup(re.sub("-(?=-)", "- ", one_line(text)))


def number(value: Any) -> str:
    """Return the shortest text that reads back as the same float."""
    value = float(value)
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
