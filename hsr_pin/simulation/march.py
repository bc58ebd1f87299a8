"""The loop over time: extrapolated steps as long as the motion allows, and samples in between.

The linearly implicit Euler method, extrapolated: P. Deuflhard, E. Hairer, J. Zugck, One-step and extrapolation methods for
differential-algebraic systems, Numer. Math. 51 (1987); E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section
IV.9. A step is done with 1, 2, ..., p substeps, and the p results are combined so that the first p - 1 terms of their common
error cancel: order p, p (p + 1) / 2 substeps. Without the first of them the order is p - 1: the difference of the two is the
error that steps are controlled by. Springs and dampers are implicit in a substep (a W-method: any approximate Jacobian keeps the
order), so that no step is too long to be stable.

All columns take the steps that the first one needs: what differs between them is then smooth in their parameters.

The functions here run as Python over Pinocchio, and compiled: names that they do not define (``substep``, ``resist``,
``remember``, ``add``, ``between``, ``bent``, ``alone``) come from :mod:`~hsr_pin.simulation.reference` or
:mod:`~hsr_pin.simulation.kernel`; for arms in space, whose rows hold 3 N coordinates and whose impulses are (B, C + 1, U), from
the modules of the same names in :mod:`~hsr_pin.simulation.space`.
Only what both understand is used: arrays, numbers and loops.
"""

from __future__ import annotations

from math import floor, inf, isfinite, nan
from typing import Any

import numpy as np

from hsr_pin.simulation.reference import ROWS, add, alone, bent, between, remember, resist, substep
from hsr_pin.trajectory import Array

#: Shortest step, over a cell of the command.
SHORTEST = 1.0 / 256
#: A step grows when the error that it would then have is below this share of the tolerance.
_SURE = 0.5
#: Weight of an error of the rate, over the step, beside that of the angle.
_RATE = 0.25
#: Weight of an error between the ends of a step, which does not add up from step to step.
_BETWEEN = 0.25


def mean_torque(impulse: Array, start: float, end: float, torque: Array) -> None:
    """Mean of the torque (B,) [N m] between two times in cells, from its integral (B, C + 1) in N m times cells."""
    cells = impulse.shape[1] - 1
    for b in range(impulse.shape[0]):
        first, last = min(int(start), cells - 1), min(int(end), cells - 1)
        low = impulse[b, first] + (start - first) * (impulse[b, first + 1] - impulse[b, first])
        high = impulse[b, last] + (end - last) * (impulse[b, last + 1] - impulse[b, last])
        torque[b] = (high - low) / (end - start)


def extrapolate(
    system: Any, q: Array, v: Array, z: Array, impulse: Array, t: float, step: float, cell: float, weights: Array, work: Array,
    z_now: Array, torque: Array, scratch: Array,
) -> tuple[float, float]:  # fmt: skip
    """One step of ``step`` cells from time ``t`` (in cells).

    Args:
        system: the arms.
        q: (B, N) [rad]; not changed.
        v: (B, N) [rad/s]; not changed.
        z: (states, B, N) of the laws.
        impulse: (B, C + 1) integral of the torque.
        t: in cells.
        step: in cells.
        cell: [s].
        weights: (2, p) of the p results, and of them without the first.
        work: (7, B, N): the new angles and rates are left in the first two.
        z_now: (states, B, N) for work.
        torque: (B,) for work.
        scratch: (ROWS, N) for work.

    Returns:
        Errors of the first column, in radians summed over the joints, infinite where they are no numbers: at the end of the step,
        and midway of the cubic through both ends, told by the acceleration that it begins with and the motion's own.
    """
    h = step * cell
    q_new, v_new, q_low, v_low, q_now, v_now, moment = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    work[:] = 0.0
    begin = scratch[ROWS - 1]
    begin[:] = 0.0
    laws, memory = system.laws.shape[0], z.shape[0]
    for k in range(weights.shape[1]):
        parts = k + 1
        d = h / parts
        q_now[:] = q
        v_now[:] = v
        for j in range(parts):
            mean_torque(impulse, t + step * j / parts, t + step * (j + 1) / parts, torque)
            if laws:
                if memory:
                    if j:
                        remember(system, z, q, q_now, j * d, z_now)
                    else:
                        z_now[:] = z
                moment[:] = 0.0
                resist(system, q_now, v_now, z_now, moment)
            substep(system, q_now, v_now, moment, torque, d, scratch)
            if j == 0:
                for i in range(q.shape[1]):  # not as arrays: each would be made anew
                    begin[i] += weights[0, k] * (v_now[0, i] - v[0, i]) / d
        add(q_new, weights[0, k], q_now)
        add(v_new, weights[0, k], v_now)
        add(q_low, weights[1, k], q_now)
        add(v_low, weights[1, k], v_now)
    error, bow = 0.0, 0.0
    for i in range(q.shape[1]):
        error += abs(q_new[0, i] - q_low[0, i]) + _RATE * h * abs(v_new[0, i] - v_low[0, i])
        bow += abs(6 * (q_new[0, i] - q[0, i]) - h * (4 * v[0, i] + 2 * v_new[0, i]) - h * h * begin[i]) / 32
    return error if isfinite(error) else inf, bow if isfinite(bow) else inf


def march(
    system: Any, q: Array, v: Array, z: Array, impulse: Array, cell: float, per_sample: int, until: Array, weights: Array,
    tolerance: float, first: float, longest: float, limit: Array, angles: Array, rates: Array, lost: Array, taken: Array,
    beyond: Array,
) -> int:  # fmt: skip
    """From a state to the motion at every sample.

    Args:
        system: the arms.
        q: (B, N) [rad] at the first sample; changed to that after the last step.
        v: (B, N) [rad/s] likewise.
        z: (states, B, N) likewise.
        impulse: (B, C + 1) integral of the torque, in N m times cells, at the ends of the cells.
        cell: [s] over which the torque is even.
        per_sample: cells from sample to sample.
        until: (C + 1,) for each cell the next end of a cell that no step may pass.
        weights: (2, p) as for :func:`extrapolate`.
        tolerance: [rad, summed over the joints] largest error of a step; infinite: steps of the length ``first``.
        first: length of the first step, in cells.
        longest: of any step, in cells.
        limit: (B,) [rad] largest bending angle.
        angles: (S, B, N) the samples, filled in; the first one too.
        rates: (S, B, N) likewise.
        lost: (B,) for each column the step [in cells] at whose end it went beyond its limit; infinite: never.
        taken: (A,) the lengths of the steps, as many as it holds.
        beyond: (B, N) [rad] where the columns were when they were lost.

    Returns:
        How many steps were taken.
    """
    count, links = q.shape
    work = np.zeros((7, count, links))
    z_new, z_now = np.zeros_like(z), np.zeros_like(z)
    torque, scratch = np.zeros_like(impulse[:, 0]), np.zeros((ROWS, links))
    t, h, samples, sample, steps = 0.0, first, angles.shape[0], 1, 0
    p = weights.shape[1]
    angles[0], rates[0] = q, v
    for b in range(count):
        if not abs(bent(q, b)) <= limit[b]:
            lost[b] = 0.0
            beyond[b] = q[b]
    while sample < samples and lost.max() == inf:
        step = min(h, until[floor(t)] - t)
        error, bow = extrapolate(system, q, v, z, impulse, t, step, cell, weights, work, z_now, torque, scratch)
        if sample * per_sample < t + step:  # there are samples within
            error = max(error, _BETWEEN * bow)
        good = error <= tolerance and abs(bent(work[0], 0)) <= limit[0]  # where it leaves its limit is looked for too
        if not good and tolerance < inf and lost[0] == inf and step > SHORTEST:
            h = step / 2
            continue
        q_new, v_new = work[0], work[1]
        if z.shape[0]:
            remember(system, z, q, q_new, step * cell, z_new)
        for b in range(count):
            gone = not abs(bent(q_new, b)) <= limit[b]
            if tolerance < inf and lost[0] < inf:  # without the column that leads nobody knows how long a step may be
                gone = True
            if gone and lost[b] == inf:
                lost[b] = t + step
                beyond[b] = q_new[b]
            if lost[b] < inf:
                q_new[b] = 0.0
                v_new[b] = 0.0
                z_new[:, b] = 0.0
        while sample < samples and sample * per_sample <= t + step:
            x = (sample * per_sample - t) / step
            between(q, v, q_new, v_new, step * cell, x, angles[sample], rates[sample])
            sample += 1
        if steps < taken.shape[0]:
            taken[steps] = step
        steps += 1
        t += step
        q[:] = q_new
        v[:] = v_new
        z[:] = z_new
        if tolerance < inf and t == until[min(floor(t - step), until.shape[0] - 1)]:
            h = min(h, first)
        elif tolerance < inf and step == h and error * 2.0**p < _SURE * tolerance:
            h = min(2 * h, longest)
    return steps


def march_apart(
    system: Any, begin: int, end: int, q: Array, v: Array, z: Array, impulse: Array, cell: float, per_sample: int, until: Array,
    weights: Array, tolerance: Array, first: float, longest: float, limit: Array, angles: Array, rates: Array, lost: Array,
    beyond: Array,
) -> None:  # fmt: skip
    """As :func:`march`, but every column takes steps of its own.

    Args:
        system: the arms.
        begin: the first column to move.
        end: one beyond the last.
        q: (B, N) as for :func:`march`.
        v: (B, N) likewise.
        z: (B, states, 1, N).
        impulse: (B, C + 1).
        cell: [s].
        per_sample: cells from sample to sample.
        until: (B, C + 1).
        weights: (2, p).
        tolerance: (B,).
        first: length of the first step, in cells.
        longest: of any step.
        limit: (B,) [rad].
        angles: (B, S, 1, N).
        rates: (B, S, 1, N).
        lost: (B,).
        beyond: (B, N) [rad].
    """
    taken = np.zeros(0)
    for b in range(begin, end):
        one = b + 1
        march(
            alone(system, b), q[b:one], v[b:one], z[b], impulse[b:one], cell, per_sample, until[b], weights, tolerance[b], first,
            longest, limit[b:one], angles[b], rates[b], lost[b:one], taken, beyond[b:one],
        )  # fmt: skip


def advance(system: Any, q: Array, v: Array, z: Array, impulse: Array, cell: float, weights: Array, limit: Array) -> int:
    """Steps of one cell each, in place: a march to the only sample.

    Args:
        system: the arms.
        q: (B, N) [rad].
        v: (B, N) [rad/s].
        z: (states, B, N) of the laws.
        impulse: (B, C + 1) integral of the torque, as for :func:`march`.
        cell: [s].
        weights: (2, p) as for :func:`extrapolate`.
        limit: (B,) [rad].

    Returns:
        How many columns went beyond their limits. Those have the angles where they did, and no numbers for rates.
    """
    count, links = q.shape
    cells = impulse.shape[1] - 1
    until, lost, room = np.arange(1.0, cells + 1), np.full(count, inf), np.zeros((5, count, links))
    angles, rates, beyond = room[0:2], room[2:4], room[4]
    march(
        system, q, v, z, impulse, cell, cells, until, weights, inf, 1.0, 1.0, limit, angles, rates, lost, until[:0], beyond
    )  # fmt: skip
    gone = 0
    for b in range(count):
        if lost[b] < inf:
            q[b] = beyond[b]
            v[b] = nan
            gone += 1
    return gone
