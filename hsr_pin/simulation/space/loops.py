"""The loops of arms in space as machine code, compiled at the first use, separately from those of planar arms."""

from __future__ import annotations

import threading
from functools import lru_cache
from typing import Any

from hsr_pin.simulation.compiled import Loops, compile_loops
from hsr_pin.simulation.integrate import advance
from hsr_pin.simulation.space import equilibrium, kernel
from hsr_pin.simulation.space.system import SpaceSystem

_LOCK = threading.RLock()


def space_loops() -> Loops:
    """Return the compiled loops; compilation is announced on standard error."""
    with _LOCK:  # a second thread waits until the first has compiled them
        return _loops()


@lru_cache(maxsize=1)
def _loops() -> Loops:
    return compile_loops("space", kernel, equilibrium, advance, _arguments())


def _arguments() -> tuple[Any, ...]:
    """Return the argument types of each loop."""
    from numba import types as nb

    def reals(dimensions: int, kind: Any = nb.float64, readonly: bool = False) -> Any:
        return nb.Array(kind, dimensions, "C", readonly=readonly)

    fields = {name: reals(2) for name in SpaceSystem._fields}
    fields |= {"keq": reals(1), "laws": reals(2, nb.int64), "numbers": reals(3), "link": reals(2, nb.int64)}
    fields |= {"world": reals(3), "touch": reals(1, nb.int64)}
    system = nb.NamedTuple(list(fields.values()), SpaceSystem)
    number, whole, complexes = nb.float64, nb.int64, nb.complex128
    state, weights = (reals(2), reals(2), reals(3, complexes)), reals(2, readonly=True)
    steps, out = (reals(1), weights, number, number, number), (reals(1), reals(3), reals(3), reals(1), reals(1), reals(2))
    each = (reals(2), weights, reals(1), number, number), (reals(1), reals(4), reals(4), reals(1), reals(2))
    flags = reals(1, nb.boolean)
    return (
        nb.void(system, *state, reals(3), number, whole, *steps, *out).args,
        nb.void(system, whole, whole, *state[:2], reals(4, complexes), reals(3), number, whole, *each[0], *each[1]).args,
        nb.void(system, *state, reals(3), number, weights, reals(1)).args,
        nb.void(system, system, reals(2), flags, reals(2), flags, whole).args,
    )
