"""Text from a template of this room."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, **values: Any) -> str:
    """Fill in a template; what stands in XML is escaped."""
    return _environment(not template.endswith(".py.jinja")).get_template(template).render(**values)


@lru_cache(maxsize=2)
def _environment(escape: bool) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # here: `--help` does without
    from markupsafe import Markup

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
    made.filters["comment"] = lambda text: Markup(str(text).replace("--", "- -"))  # XML ends a comment at two hyphens
    return made


def number(value: Any) -> str:
    """The shortest text that reads back as the same float."""
    value = float(value)
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
