"""The time integration, the search for equilibria and the marker projection as machine code, compiled by numba at the first use.

The functions of the modules :mod:`~hsr_pin.simulation.integrate`, :mod:`~hsr_pin.simulation.equilibrium` and
:mod:`~hsr_pin.simulation.marker_projection` are compiled unchanged, with the functions of ``kernel`` instead of Pinocchio's. The
machine code is stored in numba's cache (beside the source, or in the user's cache if the installation is not writable) and serves
all processes; a process that finds it there starts within a second.
"""

from __future__ import annotations

import sys
import threading
import types
from collections.abc import Callable, Iterable
from functools import cache, lru_cache
from typing import Any, NamedTuple

from hsr_pin.effects.effect import Effect, unsupported_laws
from hsr_pin.simulation import equilibrium, integrate, kernel, marker_projection
from hsr_pin.simulation.code_cache import cached
from hsr_pin.simulation.integrate import advance
from hsr_pin.simulation.kernel import System
from hsr_pin.simulation.source_hash import source_hash
from hsr_pin.trajectory import Array

_MESSAGE = "hsr_pin: compiling the inner loops, {often}; this takes about half a minute"
_KEPT = "once on this machine"
_LOST = "in every process (no writable folder to store them; set NUMBA_CACHE_DIR to one)"
#: Functions of the inner loops that are called instead of copied to where they are needed.
_CALLED = ("add_contacts", "add_joint_moments", "update_contacts", "update_states")
_LOCK = threading.RLock()


class Loops(NamedTuple):
    """The compiled functions; see :mod:`~hsr_pin.simulation.integrate` and :mod:`~hsr_pin.simulation.equilibrium`."""

    integrate: Any
    integrate_separately: Any
    advance: Any
    equilibrium: Any


def loops() -> Loops:
    """Return the compiled loops; compilation is announced on standard error."""
    with _LOCK:  # a second thread waits until the first has compiled them
        return _loops()


def marker_projector() -> Any:
    """Return the compiled :func:`hsr_pin.simulation.marker_projection.project_markers`."""
    with _LOCK:
        return _marker_projector()


def precompile(effects: Iterable[type[Effect]] = (), space: bool = False) -> None:
    """Compile everything that a fit with these effects calls, before many processes need it."""
    if space:
        from hsr_pin.simulation.space.loops import space_loops

        space_loops()
    else:
        loops()
        marker_projector()
    precompile_laws(effects, space)


def precompile_laws(effects: Iterable[type[Effect]], space: bool = False) -> None:
    """Compile the laws of effects, in all variants."""
    from hsr_pin.simulation.laws import address

    for kind in effects:
        for variant in kind.variants():
            effect = kind(**variant)  # type: ignore[arg-type, unused-ignore]  # options are texts
            for hook in ("moment", "contact_force", "update", "actuator_response"):
                if effect.acts_through(hook) and not unsupported_laws([effect], space=space):
                    address(effect, hook, space=space)


@lru_cache(maxsize=1)
def _loops() -> Loops:
    return compile_loops("loops", kernel, equilibrium, advance_packed, _arguments())


@lru_cache(maxsize=1)
def _marker_projector() -> Any:
    compiler = _Compiler("marker_projection")
    found = compiler.jit(marker_projection.project_markers)
    compiler.compile((found,), (_projection_types(),))
    return found


def compile_loops(part: str, kernel: Any, equilibrium: Any, advance: Callable[..., Any], arguments: Iterable[Any]) -> Loops:
    """Compile the loops for one kind of arms.

    Args:
        part: key of the sources in :mod:`~hsr_pin.simulation.source_hash`.
        kernel: the module with the inner loops.
        equilibrium: the module with the search for equilibria.
        advance: the function that takes steps given from outside.
        arguments: the argument types of each loop.
    """
    compiler = _Compiler(part)
    jit = compiler.jit
    plain: dict[str, Any] = {"ROWS": kernel.ROWS, "call_law": _caller()}
    for name in kernel.PARTS:
        plain[name] = jit(getattr(kernel, name), inline=name not in _CALLED, **plain)
    plain["mean_torque"] = plain.get("mean_torque") or jit(integrate.mean_torque, inline=True)
    plain["extrapolate"] = jit(integrate.extrapolate, **plain)
    for name in equilibrium.PARTS:
        plain[name] = jit(getattr(equilibrium, name), **plain)
    plain["integrate"] = jit(integrate.integrate, **plain)
    plain["advance"] = jit(integrate.advance, **plain)
    separately, steps = jit(integrate.integrate_separately, **plain), jit(advance, **plain)
    found = Loops(plain["integrate"], separately, steps, jit(equilibrium.equilibrium, **plain))
    compiler.compile(found, arguments)
    return found


class _Compiler:
    """Compiles functions that depend on the same sources, and caches the machine code if possible."""

    def __init__(self, part: str) -> None:
        self._hash, self._kept = source_hash(part), True

    def jit(self, function: Callable[..., Any], inline: bool = False, **others: Any) -> Any:
        """Prepare a function for compilation; ``others`` replace the globals of the same names."""
        from numba import njit

        scope = {**function.__globals__, **others}
        copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__)
        copy.__module__ = function.__module__
        copy.__qualname__ = f"{function.__name__}_{self._hash}"
        code, is_kept = cached(njit, copy, nogil=True, error_model="numpy", fastmath={"contract"}, forceinline=inline)
        self._kept = self._kept and is_kept
        return code

    def compile(self, functions: Iterable[Any], arguments: Iterable[Any]) -> None:
        """Compile functions for the given argument types only, so that no later call compiles them again."""
        from numba.core import event

        message = _announcement(_KEPT if self._kept else _LOST)
        with event.install_listener("numba:compile", message):  # the event does not occur if cached code is loaded
            for function, types_of in zip(functions, arguments, strict=True):
                function.compile(types_of)
                function.disable_compile()


def advance_packed(
    joints: Array, gravity: Array, keq: Array, laws: Any, numbers: Array, world: Array, touch: Any, state: Array, impulse: Array,
    cell: float, weights: Array, limit: Array,
) -> int:  # fmt: skip
    """Take steps of one cell each, as :func:`hsr_pin.simulation.integrate.advance`, with fewer arguments to save time per call.

    ``state`` (2 + states, B, N) contains the angles, the rates and the states of the laws; ``joints`` (11, B, N) contains the
    first fields of :class:`~hsr_pin.simulation.kernel.System`; the other arguments are as there.
    """
    j = joints
    arms = System(
        j[0], j[1], j[2], j[3], j[4], j[5], j[6], j[7], j[8], j[9], j[10], gravity, keq, laws, numbers, world, touch
    )  # fmt: skip
    return advance(arms, state[0], state[1], state[2:], impulse, cell, weights, limit)


def _arguments() -> tuple[Any, ...]:
    """Return the argument types of each loop."""
    from numba import types as nb

    def reals(dimensions: int, kind: Any = nb.float64, readonly: bool = False) -> Any:
        return nb.Array(kind, dimensions, "C", readonly=readonly)

    fields = {name: reals(2) for name in System._fields}
    fields |= {"keq": reals(1), "laws": reals(2, nb.int64), "numbers": reals(3), "world": reals(3), "touch": reals(1, nb.int64)}
    system = nb.NamedTuple(list(fields.values()), System)
    state, number, whole = (reals(2), reals(2), reals(3)), nb.float64, nb.int64
    weights = reals(2, readonly=True)
    steps, out = (reals(1), weights, number, number, number), (reals(1), reals(3), reals(3), reals(1), reals(1), reals(2))
    each = (reals(2), weights, reals(1), number, number), (reals(1), reals(4), reals(4), reals(1), reals(2))
    flags, few = reals(1, nb.boolean), (reals(3), reals(2), reals(1), reals(2, nb.int64), reals(3), reals(3), reals(1, nb.int64))
    return (
        nb.void(system, *state, reals(2), number, whole, *steps, *out).args,
        nb.void(system, whole, whole, *state[:2], reals(4), reals(2), number, whole, *each[0], *each[1]).args,
        nb.void(*few, reals(3), reals(2), number, weights, reals(1)).args,
        nb.void(system, system, reals(1), flags, reals(2), flags, whole).args,
    )


def _projection_types() -> Any:
    """Return the argument types of the marker projection."""
    from numba import types as nb

    return nb.void(*(nb.Array(nb.float64, dimensions, "C") for dimensions in (3, 2, 3, 2, 2, 4))).args


@cache
def _announcement(often: str) -> Any:
    """Return a listener that announces the compilation, once per process."""
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
    """Return a function with which compiled code calls machine code at an address; arrays are passed as pointers."""
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
