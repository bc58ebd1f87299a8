"""The equilibrium of arms that may touch obstacles, by pseudo-transient continuation with steps of the time integration.

The arms move without inertia while the load rises from zero, so that they come to rest on the side of an obstacle from which they
reach it. The steps become longer until they are Newton's. C. T. Kelley, D. E. Keyes, Convergence analysis of pseudo-transient
continuation, SIAM J. Numer. Anal. 35 (1998). The surfaces keep no friction at rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hsr_pin.simulation.contact import RADIUS
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from hsr_pin.simulation.motion import Engine

#: Steps over which the load rises, largest number of steps, and first and longest step [s]; with the longest, a step is Newton's.
_RISE, _STEPS, _FIRST, _LONGEST = 20, 4000, 1e-3, 1e4
#: Change of all angles of an arm in a step at which the search stops [rad].
_DONE = 1e-10


def rest_among_obstacles(
    engine: Engine, torque: Array, wanted: NDArray[np.bool_], near: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the poses in which arms rest, and which of them do.

    Args:
        engine: the loops and the arms.
        torque: (B,) torques [N m], or (B, U) torques and loads in space.
        wanted: (B,) whether to solve for each arm.
        near: (B, C) initial coordinates [rad].

    Returns:
        The coordinates (B, C) [rad], 0 where no rest was found or wanted, and (B,) whether one was found.
    """
    q, found = np.where(wanted[:, None], near, 0.0), np.zeros(len(near), dtype=bool)
    chosen = np.flatnonzero(wanted)
    if not len(chosen):
        return q, found
    some = engine if len(chosen) == len(q) else engine.of(chosen)
    rests = _rests(some, torque[chosen], q[chosen])
    if rests is None and len(chosen) > 1:  # an arm without a rest must not keep the others from theirs
        for b in chosen:
            alone = _rests(engine.of(np.array([b])), torque[[b]], q[[b]])
            found[b], q[b] = alone is not None, 0.0 if alone is None else alone[0]
        return q, found
    found[chosen], q[chosen] = rests is not None, 0.0 if rests is None else rests
    return q, found


def _rests(engine: Engine, torque: Array, q: Array) -> Array | None:
    """Return the poses (B, C) [rad] in which all arms rest; None if one of them does not come to rest."""
    # the tip moves by less than the radius of the arm, so that no obstacle is passed over
    farthest = engine.batch.world[:, 0, RADIUS] / engine.batch.arms.length
    d, last = _FIRST, np.zeros_like(q)
    for step in range(_STEPS):
        share = min(1.0, (step + 1) / _RISE)
        change = engine.step_from_rest(q, share * torque, d) - q
        moved = np.abs(change).sum(axis=1)
        if not np.all(np.isfinite(moved)):
            return None
        if np.any(moved > farthest):
            d /= 2
            continue
        swings = (moved > _DONE) & (-(change * last).sum(axis=1) > 0.25 * (last**2).sum(axis=1))  # about the rest
        d = d / 4 if swings.any() else min(2 * d, _LONGEST)
        last, q = change, q + change
        if share == 1.0 and d == _LONGEST and np.all(moved < _DONE):
            return q
    return None
