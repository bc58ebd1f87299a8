"""Extraction of the source text of an effect's laws, with everything that their functions use."""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
import types
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from hsr_pin.effects.effect import Effect, fields_of
from hsr_pin.errors import EffectError

#: Names that the generated module defines itself.
_GIVEN = {"np", "Bending", "Any"}


@dataclass(frozen=True)
class LawText:
    """Source text of one law.

    Attributes:
        name: name of the effect.
        lacks: description of what the nominal model lacks, one line.
        fields: names of the parameters and options.
        values: values of the fields; an option is given by its index.
        states: number of state variables of each joint.
        memories: number of state variables of the command.
        functions: source of its functions, indented once.
    """

    name: str
    lacks: str
    fields: tuple[str, ...]
    values: tuple[float, ...]
    states: int
    memories: int
    functions: str


def law_text(effect: Effect, hooks: Iterable[str]) -> LawText:
    """Return the source text of an effect's functions named ``hooks``."""
    kind = type(effect)
    parts = [textwrap.indent(textwrap.dedent(inspect.getsource(getattr(kind, hook))), "    ") for hook in hooks]
    values = tuple(value if isinstance(value, int) else float(value) for value in effect.p)
    return LawText(effect.name, effect.lacks, fields_of(kind), values, effect.states, effect.memories, "\n".join(parts))


def helpers(functions: Iterable[Callable[..., Any]]) -> str:
    """Return the source of all functions and constants that some laws use, each once, in order of definition.

    Raises:
        EffectError: a law uses an object that is neither a plain function nor a constant of a module.
    """
    found: dict[str, str] = {}
    for function in functions:
        _collect(function, found)
    constants = [text for text in found.values() if not text.startswith("def ")]
    defined = [text for text in found.values() if text.startswith("def ")]
    return "\n\n\n".join(["\n".join(constants), *defined]).strip()


def _collect(function: Callable[..., Any], found: dict[str, str]) -> None:
    code: types.CodeType = function.__code__
    for name in code.co_names:
        scope: dict[str, Any] = function.__globals__
        if name in _GIVEN or name in found or name not in scope:
            continue
        value = scope[name]
        if isinstance(value, types.FunctionType):
            _collect(value, found)
            found[name] = inspect.getsource(value).strip()
            continue
        number = isinstance(value, int | float | complex)
        text = f"{name} = {value!r}" if number else _assignment(name, scope["__name__"])
        if text is None:
            subject = f"{function.__module__}.{function.__qualname__}"
            raise EffectError(
                subject, expected="a law that uses functions, numbers and numpy only", received=f"a law that uses {name}"
            )
        if text not in found.values():
            found[name] = text


def _assignment(name: str, module: str) -> str | None:
    """Return the statement that assigns a constant of a module; None if there is none."""
    text = inspect.getsource(sys.modules[module])
    for statement in ast.parse(text).body:
        targets = statement.targets if isinstance(statement, ast.Assign) else []
        named = {node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)}
        if name in named:
            return ast.get_source_segment(text, statement)
    return None
