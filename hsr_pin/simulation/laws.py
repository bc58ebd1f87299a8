"""The laws of effects as machine code: each law is compiled once, separately, and called by address with whole arrays.

For each law, the text of a small loop is filled in: the numbers of parameters and of states, and the options, are constants
there. The factor 1.0 converts the zero-dimensional array that ``np.where`` returns into a number. The machine code is stored
beside the file of the law (or in the user's cache if that is not writable); a hash of all source code that contributes to it is
part of its name.
"""

from __future__ import annotations

import inspect
import threading
import types
from collections.abc import Callable
from functools import cache, partial
from math import cos, sin
from typing import Any

from hsr_pin.effects import vector
from hsr_pin.effects.effect import Bending, Effect, parameter_tuple
from hsr_pin.simulation.code_cache import cached
from hsr_pin.simulation.source_hash import law_hash

_LOCK = threading.RLock()

_HEAD = """
def {name}({arguments}):
    for b in range(B):
        p = Parameters({parameters})
"""

_MOMENT = """
        for i in range(N):
            k = b * N + i
            moment[k] += 1.0 * law(p, Bending(N * q[k], N * v[k], keq[b], profile[k], (i + 0.5) / N, ({memory})))
"""

_CONTACT_FORCE = """
        rest = 0.0
        for i in range(N):
            rest += reach[b * N + i]
        beyond = (1.0 - place(p)) * (rest + reach[b * N] - reach[b * N + N - 1])
        turned = 0.0
        aside = 0.0
        for i in range(N):
            k = b * N + i
            turned += q[k]
            aside += min(max(rest - beyond, 0.0), reach[k]) * sin(turned)
            rest -= reach[k]
        force = 1.0 * law(p, aside)
        lever = 0.0
        for j in range(N):
            k = b * N + N - 1 - j
            rest += reach[k]
            lever += min(max(rest - beyond, 0.0), reach[k]) * cos(turned)
            moment[k] -= force * lever
            turned -= q[k]
"""

_UPDATE = """
        for j in range({states}):
            for i in range(N):
                k = b * N + i
                m = j * B * N + k
                out[m] = 1.0 * law(p, j, z[m], N * start[k], N * end[k], elapsed)
"""

_ACTUATOR_RESPONSE = """
        memory = ({memory})
        for n in range(S):
            mean, memory = law(p, torque[n * B + b], memory, step, keq[b])
            out[n * B + b] = 1.0 * mean
"""

#: For each hook: its loop, its arguments (pointers, then integers, then real numbers), their counts, and where its memory begins.
_FORMS = {
    "moment": (_MOMENT, "q, v, keq, profile, reach, z, numbers, moment, B, N", 8, 2, 0),
    "contact_force": (_CONTACT_FORCE, "q, v, keq, profile, reach, z, numbers, moment, B, N", 8, 2, 0),
    "update": (_UPDATE, "z, start, end, numbers, out, B, N, elapsed", 5, 2, 1),
    "actuator_response": (_ACTUATOR_RESPONSE, "torque, keq, numbers, out, S, B, step", 4, 2, 1),
}


def address(effect: Effect, hook: str, *, space: bool = False) -> int:
    """Return the address of the machine code of a law, which is compiled or loaded from the cache at the first call.

    In ``space``, bending, torque and states are complex numbers.
    """
    with _LOCK:  # a second thread waits until the first has compiled it
        return int(_compiled(type(effect), hook, effect.options, space).address)


@cache
def _compiled(kind: type[Effect], hook: str, options: tuple[tuple[str, str], ...], space: bool) -> Any:
    from numba import cfunc, njit
    from numba import types as nb

    body, arguments, pointers, integers, reals = _FORMS[hook]
    facts, choices = kind.parameters(), kind.choices()
    numbers = [f"numbers[{n} * B + b]" for n in range(len(facts))]
    chosen = [str(choices[name].index(value)) for name, value in options]
    memory = "".join(f"z[{j} * B * N + k], " for j in range(kind.states)) if hook == "moment" else "torque[b], " * kind.memories
    text = (_HEAD + body).format(
        name=hook, arguments=arguments, parameters=", ".join([*numbers, *chosen]), memory=memory or "", states=kind.states
    )
    law: Callable[..., Any] = getattr(kind, hook)
    scope = {
        "Bending": Bending,
        "Parameters": parameter_tuple(kind),
        "law": njit(with_helpers(law)),
        "place": njit(with_helpers(kind.place)),
        "sin": sin,
        "cos": cos,
        "__name__": kind.__module__,
    }
    exec(compile(text, inspect.getfile(law), "exec"), scope)
    loop: Any = scope[hook]
    variant = "_".join(value for _, value in options)
    loop.__qualname__ = f"{kind.__name__}_{hook}_{variant}_{law_hash(law)}{'_space' * space}"
    number, vector = nb.CPointer(nb.float64), nb.CPointer(nb.complex128 if space else nb.float64)
    names = arguments.split(", ")[:pointers]
    points = [number if name in ("keq", "profile", "reach", "numbers") else vector for name in names]
    signature = nb.void(*points, *[nb.int64] * integers, *[nb.float64] * reals)
    return cached(partial(cfunc, signature), loop, error_model="numpy")[0]


def with_helpers(law: Callable[..., Any]) -> Callable[..., Any]:
    """Return a law whose helper functions are compiled too."""
    from numba import njit

    scope = dict(law.__globals__)
    for name in law.__code__.co_names:
        if scope.get(name) is vector.chosen:
            scope[name] = njit(_chosen)
        elif isinstance(scope.get(name), types.FunctionType):
            scope[name] = njit(with_helpers(scope[name]))
    return types.FunctionType(law.__code__, scope, law.__name__, law.__defaults__, law.__closure__)


def _chosen(condition: bool, one: float, other: float) -> float:
    return one if condition else other
