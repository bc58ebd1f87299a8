"""The march, the search for rest and the sight of markers as machine code, by numba; compiled at the first use and kept.

The functions of these modules are taken as they stand, with those of ``kernel`` in place of Pinocchio's. What was compiled lies
in the cache of numba (beside the source, or in the user's cache where the installation cannot be written to) and holds for all
processes; a process that finds it there starts in some tenths of a second.
"""

from __future__ import annotations

import sys
import threading
import types
from collections.abc import Callable, Iterable
from functools import cache, lru_cache
from typing import Any, NamedTuple

from hsr_pin.effects.effect import Effect, formless
from hsr_pin.simulation import kernel, march, rest, sight
from hsr_pin.simulation.code_cache import cached
from hsr_pin.simulation.kernel import System
from hsr_pin.simulation.march import advance
from hsr_pin.simulation.stamp import stamp
from hsr_pin.trajectory import Array

_MESSAGE = "hsr_pin: compiling its inner loops, {often}; this takes about half a minute"
_KEPT, _LOST = "once for this machine", "in every process (no folder to keep them in: NUMBA_CACHE_DIR may name one)"
_LOCK = threading.RLock()


class Loops(NamedTuple):
    """What is compiled; see :mod:`~hsr_pin.simulation.march` and :mod:`~hsr_pin.simulation.rest`."""

    march: Any
    apart: Any
    advance: Any
    rest: Any


def loops() -> Loops:
    """The compiled functions; compiling is announced on standard error."""
    with _LOCK:  # a second thread waits for the first
        return _loops()


def see() -> Any:
    """:func:`hsr_pin.simulation.sight.see`, compiled."""
    with _LOCK:
        return _see()


def ready(effects: Iterable[type[Effect]] = (), space: bool = False) -> None:
    """Compile all that a fit with these effects will call, before many processes want it."""
    if space:
        from hsr_pin.simulation.space.loops import space_loops

        space_loops()
    else:
        loops()
        see()
    ready_laws(effects, space)


def ready_laws(effects: Iterable[type[Effect]], space: bool = False) -> None:
    """Compile the laws of effects, in every variant."""
    from hsr_pin.simulation.laws import address

    for kind in effects:
        for variant in kind.variants():
            effect = kind(**variant)  # type: ignore[arg-type, unused-ignore]  # options are texts
            for hook in ("moment", "touch", "update", "respond"):
                if effect.acts_through(hook) and not formless([effect], space=space):
                    address(effect, hook, space=space)


@lru_cache(maxsize=1)
def _loops() -> Loops:
    return assembled("loops", kernel, rest, brief_advance, _arguments())


@lru_cache(maxsize=1)
def _see() -> Any:
    press = _Press("sight")
    found = press.made(sight.see)
    press.compile((found,), (_sight(),))
    return found


def assembled(part: str, kernel: Any, rest: Any, advance: Callable[..., Any], arguments: Iterable[Any]) -> Loops:
    """The loops over one kind of arms.

    Args:
        part: the name under which :mod:`~hsr_pin.simulation.stamp` has what they are made from.
        kernel: the module that has the inner loops.
        rest: the module that has the search for rest.
        advance: steps that are given from outside.
        arguments: the types of what each of the loops takes.
    """
    press = _Press(part)
    made = press.made
    plain: dict[str, Any] = {"ROWS": kernel.ROWS, "call_law": _caller()}
    for name in kernel.PARTS:
        plain[name] = made(getattr(kernel, name), inline=name not in ("resist", "remember"), **plain)
    plain["mean_torque"] = plain.get("mean_torque") or made(march.mean_torque, inline=True)
    plain["extrapolate"] = made(march.extrapolate, **plain)
    for name in rest.PARTS:
        plain[name] = made(getattr(rest, name), **plain)
    plain["march"] = made(march.march, **plain)
    plain["advance"] = made(march.advance, **plain)
    apart, steps = made(march.march_apart, **plain), made(advance, **plain)
    found = Loops(plain["march"], apart, steps, made(rest.rest, **plain))
    press.compile(found, arguments)
    return found


class _Press:
    """Makes machine code of functions that are made from the same sources, and keeps it where it can."""

    def __init__(self, part: str) -> None:
        self._stamp, self._kept = stamp(part), True

    def made(self, function: Callable[..., Any], inline: bool = False, **others: Any) -> Any:
        """A function for numba, to be compiled when it is first needed; ``others`` stand in for what it knows by these names."""
        from numba import njit

        scope = {**function.__globals__, **others}
        copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__)
        copy.__module__ = function.__module__
        copy.__qualname__ = f"{function.__name__}_{self._stamp}"
        code, is_kept = cached(njit, copy, nogil=True, error_model="numpy", fastmath={"contract"}, forceinline=inline)
        self._kept = self._kept and is_kept
        return code

    def compile(self, functions: Iterable[Any], arguments: Iterable[Any]) -> None:
        """Compile functions for these types alone: nothing is ever compiled again unawares."""
        from numba.core import event

        with event.install_listener(
            "numba:compile", _announcement(_KEPT if self._kept else _LOST)
        ):  # not heard when they are loaded
            for function, types_of in zip(functions, arguments, strict=True):
                function.compile(types_of)
                function.disable_compile()


def brief_advance(
    joints: Array, gravity: Array, keq: Array, laws: Any, numbers: Array, state: Array, impulse: Array, cell: float,
    weights: Array, limit: Array,
) -> int:  # fmt: skip
    """As :func:`hsr_pin.simulation.march.advance`, for few arrays: at a call from Python, each takes its time.

    ``state`` (2 + states, B, N) are angles, rates and what the laws remember; ``joints`` (11, B, N) are the first fields of
    :class:`~hsr_pin.simulation.kernel.System`, the others are as there.
    """
    j = joints
    arms = System(j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[7], j[8], j[9], j[10], gravity, keq, laws, numbers)
    return advance(arms, state[0], state[1], state[2:], impulse, cell, weights, limit)


def _arguments() -> tuple[Any, ...]:
    """Types of what each loop takes."""
    from numba import types as nb

    def reals(dimensions: int, kind: Any = nb.float64, readonly: bool = False) -> Any:
        return nb.Array(kind, dimensions, "C", readonly=readonly)

    fields = {name: reals(2) for name in System._fields}
    fields |= {"keq": reals(1), "laws": reals(2, nb.int64), "numbers": reals(3)}
    system = nb.NamedTuple(list(fields.values()), System)
    state, number, whole = (reals(2), reals(2), reals(3)), nb.float64, nb.int64
    weights = reals(2, readonly=True)
    steps, out = (reals(1), weights, number, number, number), (reals(1), reals(3), reals(3), reals(1), reals(1), reals(2))
    each = (reals(2), weights, reals(1), number, number), (reals(1), reals(4), reals(4), reals(1), reals(2))
    flags, few = reals(1, nb.boolean), (reals(3), reals(2), reals(1), reals(2, nb.int64), reals(3))
    return (
        nb.void(system, *state, reals(2), number, whole, *steps, *out).args,
        nb.void(system, whole, whole, *state[:2], reals(4), reals(2), number, whole, *each[0], *each[1]).args,
        nb.void(*few, reals(3), reals(2), number, weights, reals(1)).args,
        nb.void(system, system, reals(1), flags, reals(2), flags, whole).args,
    )


def _sight() -> Any:
    """Types of what the sight of markers takes."""
    from numba import types as nb

    return nb.void(*(nb.Array(nb.float64, dimensions, "C") for dimensions in (3, 2, 3, 2, 2, 4))).args


@cache
def _announcement(often: str) -> Any:
    """What says, once in a process, that something is being compiled."""
    from numba.core import event

    class Announcement(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: Any) -> None:
            if not self.said:
                print(_MESSAGE.format(often=often), file=sys.stderr, flush=True)
            self.said = True

        def on_end(self, event: Any) -> None:
            pass

    return Announcement()


def _caller() -> Any:
    """A function for compiled code that calls machine code at an address; arrays are passed as where they begin."""
    from llvmlite import ir
    from numba import types as nb
    from numba.extending import intrinsic

    @intrinsic  # type: ignore[untyped-decorator]
    def call_law(typing: Any, address: Any, *arguments: Any) -> Any:
        given = arguments[0] if len(arguments) == 1 and isinstance(arguments[0], nb.BaseTuple) else nb.Tuple(arguments)

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            passed = []
            for place, kind in enumerate(given):
                value = builder.extract_value(values[1], place)
                passed.append(context.make_array(kind)(context, builder, value).data if isinstance(kind, nb.Array) else value)
            shape = ir.FunctionType(ir.VoidType(), [value.type for value in passed])
            builder.call(builder.inttoptr(values[0], shape.as_pointer()), passed)
            return context.get_dummy_value()

        return nb.void(address, given), generate

    return call_law
