"""Arithmetic of columns, such as ``P1 - (P2 + P3) / 2``, which is evaluated without executing any code."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.recordings.text import nearest
from hsr_pin.trajectory import Array

#: Longest accepted formula [characters].
LONGEST = 500
_OPERATORS: Mapping[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_FUNCTIONS: Mapping[str, Callable[..., Any]] = {name: getattr(np, name) for name in ("abs", "sqrt", "sin", "cos", "exp", "log")}
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?!\w)"
_TOKEN = re.compile(rf"\0\d+\0|{_NUMBER}|[-+*/()]|\s+|(?P<word>[^-+*/()\0\s](?:[^-+*/()\0]*[^-+*/()\0\s])?)")
_EXAMPLE = "P1 - (P2 + P3) / 2"


class FormulaError(ValueError):
    """A formula is not valid; ``facts`` are the parts of an error message."""

    def __init__(self, subject: str, **facts: str) -> None:
        self.subject, self.facts = subject, facts
        super().__init__(subject)


@dataclass(frozen=True, eq=False)
class Formula:
    """An arithmetic expression of named values.

    Attributes:
        text: the expression as it was written.
        names: names that occur in it, in the order of their first use.
    """

    text: str
    names: tuple[str, ...]
    _tree: ast.expr

    @classmethod
    def parse(cls, text: str, known: Sequence[str], listed: Sequence[str] | None = None) -> Formula:
        """Return a formula of known names, of operators, numbers, ``pi``, and abs, sqrt, sin, cos, exp and log.

        A name may contain any characters; the longest known name that fits is used, so that a column ``a-b`` is not a difference.
        Upper and lower case are distinguished only if two names differ in nothing else.

        Args:
            text: the formula.
            known: the names that it may contain.
            listed: the names that an error lists; None: all.

        Raises:
            FormulaError: a name is not known, or the text is not an expression.
        """
        if len(text) > LONGEST:
            raise FormulaError("formula", expected=f"at most {LONGEST} characters", received=f"{len(text)}")
        text = text.strip()
        names: list[str] = []
        usable = {name for name in known if name and not re.fullmatch(_NUMBER, name)}
        lower = {name.lower(): name for name in usable}
        pattern = "|".join(map(_bounded, sorted(usable, key=len, reverse=True)))

        def code(found: re.Match[str]) -> str:
            name = found[0] if found[0] in usable else lower[found[0].lower()]
            if name not in names:
                names.append(name)
            return f"\0{names.index(name)}\0"

        coded = re.sub(pattern, code, text, flags=re.IGNORECASE if len(lower) == len(usable) else 0) if usable else text
        for token in _TOKEN.finditer(coded):
            if token["word"] and token["word"] not in ("pi", *_FUNCTIONS):
                raise _unknown(text, token["word"], known if listed is None else listed)
        if not names:
            raise FormulaError(f"formula {text!r}", expected="the name of a column in it", received="none")
        try:
            tree = ast.parse(re.sub("\0(\\d+)\0", r"_\1_", coded), mode="eval").body
            cls(text, tuple(names), tree).of(np.ones((1, len(names))))
        except (SyntaxError, TypeError, ValueError, RecursionError, MemoryError):
            raise FormulaError(
                f"formula {text!r}", expected=f"an expression such as {_EXAMPLE}", received="another form"
            ) from None
        return cls(text, tuple(names), tree)

    def of(self, values: Array) -> Array:
        """Return the value (T,) of the formula for values (T, names) of its names; what cannot be computed is not finite."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(_value(self._tree, values.T), len(values)).astype(float)


def _value(node: ast.expr, columns: Array) -> Any:
    """Return the value of a node.

    Raises:
        TypeError: the node is not arithmetic.
    """
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        return _OPERATORS[type(node.op)](_value(node.left, columns), _value(node.right, columns))
    if isinstance(node, ast.UnaryOp) and type(node.op) in _OPERATORS:
        return _OPERATORS[type(node.op)](_value(node.operand, columns))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS and len(node.args) == 1:
        return _FUNCTIONS[node.func.id](_value(node.args[0], columns))
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return np.float64(node.value)
    if isinstance(node, ast.Name) and node.id == "pi":
        return np.float64(math.pi)
    if isinstance(node, ast.Name) and node.id.strip("_").isdigit():
        return columns[int(node.id.strip("_"))]
    raise TypeError(node)


def _bounded(name: str) -> str:
    """Return a pattern of a name that is not a part of a longer word."""
    before, after = (r"(?<!\w)" if re.match(r"\w", name) else ""), (r"(?!\w)" if re.search(r"\w$", name) else "")
    return f"{before}{re.escape(name)}{after}"


def _unknown(text: str, unknown: str, known: Sequence[str]) -> FormulaError:
    names = [name for name in known if name]
    close = nearest(unknown, names[:200], "names")
    listed = f"the names are {', '.join(names)}"
    hint = f"{close} {listed}" if close.startswith("did") else listed
    return FormulaError(f"formula {text!r}", expected="known names only", received=repr(unknown), hint=hint)
