"""The loop over time: extrapolated steps as long as the motion allows, and interpolated samples.

The method is the extrapolated linearly implicit Euler method: P. Deuflhard, E. Hairer, J. Zugck, One-step and extrapolation
methods for differential-algebraic systems, Numer. Math. 51 (1987); E. Hairer, G. Wanner, Solving Ordinary Differential Equations
II, section IV.9. A step is taken with 1, 2, ..., p substeps, and the p results are combined so that the first p - 1 terms of
their common error expansion cancel: this gives order p with p (p + 1) / 2 substeps. Without the first result the order is p - 1;
the difference of the two is the error estimate that controls the steps. Springs and dampers are implicit in a substep (a
W-method: any approximate Jacobian keeps the order), so that steps of any length are stable.

All arms of a batch take the steps that the first one needs, so that the differences between them are smooth functions of their
parameters.

The functions in this module run as Python with Pinocchio, and compiled. Names that they do not define (``substep``,
``add_joint_moments``, ``update_states``, ``add``, ``interpolate``, ``bending_angle``, ``single_arm``) come from
:mod:`~hsr_pin.simulation.reference` or :mod:`~hsr_pin.simulation.kernel`; for arms in space, which have 3 N coordinates and
impulses (B, C + 1, U), from the modules of the same names in :mod:`~hsr_pin.simulation.space`.
Both need plain code: arrays, numbers and loops only.
"""

from __future__ import annotations

from math import floor, inf, isfinite, nan
from typing import Any

import numpy as np

from hsr_pin.simulation.reference import (
    ROWS,
    add,
    add_joint_moments,
    bending_angle,
    interpolate,
    single_arm,
    substep,
    update_states,
)
from hsr_pin.trajectory import Array

#: Shortest step, in cells of the command.
SHORTEST = 1.0 / 256
#: The step length doubles if the predicted error of the longer step is below this share of the tolerance.
_GROWTH_MARGIN = 0.5
#: Weight of the rate error, multiplied by the step length, relative to the angle error.
_RATE = 0.25
#: Weight of the interpolation error within a step, which does not accumulate from step to step.
_INTERPOLATION = 0.25


def mean_torque(impulse: Array, start: float, end: float, torque: Array) -> None:
    """Compute the mean torque (B,) [N m] between two times [cells] from the integral (B, C + 1) [N m times cells]."""
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
    """Take one step of ``step`` cells from time ``t`` (in cells).

    Args:
        system: the arms.
        q: (B, N) angles [rad]; not changed.
        v: (B, N) rates [rad/s]; not changed.
        z: (states, B, N) states of the laws.
        impulse: (B, C + 1) integral of the torque [N m times cells].
        t: time at the start of the step [cells].
        step: step length [cells].
        cell: length of a cell [s].
        weights: (2, p) weights of the p results: for order p, and without the first result.
        work: (7, B, N) workspace; the new angles and rates are stored in the first two rows.
        z_now: (states, B, N) workspace.
        torque: (B,) workspace.
        scratch: (ROWS, N) workspace.

    Returns:
        Two errors of the first arm, as sums over the joints [rad], infinite if they are not finite: the error at the end of the
        step, and the error of the cubic interpolation at its middle, estimated from the initial accelerations of the interpolant
        and of the motion; among obstacles, which may stop the arm within the step, from the last ones too.
    """
    h = step * cell
    q_new, v_new, q_low, v_low, q_now, v_now, moment = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    work[:] = 0.0
    begin, end = scratch[ROWS - 1], scratch[ROWS - 2]
    begin[:] = 0.0
    last, touching = weights.shape[1] - 1, system.world.shape[1] > 0
    laws, memory = system.laws.shape[0], z.shape[0]
    for k in range(weights.shape[1]):
        parts = k + 1
        d = h / parts
        q_now[:] = q
        v_now[:] = v
        for j in range(parts):
            mean_torque(impulse, t + step * j / parts, t + step * (j + 1) / parts, torque)
            if memory:
                if j:
                    update_states(system, z, q, q_now, j * d, z_now)
                else:
                    z_now[:] = z
            if laws:
                moment[:] = 0.0
                add_joint_moments(system, q_now, v_now, z_now, moment)
            if touching and k == last:
                end[:] = v_now[0]
            substep(system, q_now, v_now, z_now, moment, torque, d, scratch)
            if j == 0:
                for i in range(q.shape[1]):  # a loop, because array expressions would allocate memory
                    begin[i] += weights[0, k] * (v_now[0, i] - v[0, i]) / d
        add(q_new, weights[0, k], q_now)
        add(v_new, weights[0, k], v_now)
        add(q_low, weights[1, k], q_now)
        add(v_low, weights[1, k], v_now)
    error, bow = 0.0, 0.0
    for i in range(q.shape[1]):
        error += abs(q_new[0, i] - q_low[0, i]) + _RATE * h * abs(v_new[0, i] - v_low[0, i])
        bow += abs(6 * (q_new[0, i] - q[0, i]) - h * (4 * v[0, i] + 2 * v_new[0, i]) - h * h * begin[i]) / 32
    if touching:  # the mean acceleration of the last substep, at 1 - 1 / (2 p) of the step
        x, late = 1.0 - 0.5 / (last + 1), 0.0
        for i in range(q.shape[1]):
            bent = (12 * x - 6) * (q[0, i] - q_new[0, i]) + h * ((6 * x - 4) * v[0, i] + (6 * x - 2) * v_new[0, i])
            late += abs(bent - h * (last + 1) * (v_now[0, i] - end[i])) / 32
        bow = max(bow, late)
    return error if isfinite(error) else inf, bow if isfinite(bow) else inf


def integrate(
    system: Any, q: Array, v: Array, z: Array, impulse: Array, cell: float, per_sample: int, until: Array, weights: Array,
    tolerance: float, first: float, longest: float, limit: Array, angles: Array, rates: Array, lost: Array, taken: Array,
    beyond: Array,
) -> int:  # fmt: skip
    """Integrate the motion from a state to every sample.

    Args:
        system: the arms.
        q: (B, N) angles at the first sample [rad]; overwritten with those after the last step.
        v: (B, N) rates at the first sample [rad/s]; overwritten with those after the last step.
        z: (states, B, N) states of the laws at the first sample; overwritten with those after the last step.
        impulse: (B, C + 1) integral of the torque at the cell ends [N m times cells].
        cell: length of a cell of constant torque [s].
        per_sample: number of cells from sample to sample.
        until: (C + 1,) for each cell, the next cell end that no step may pass.
        weights: (2, p) as for :func:`extrapolate`.
        tolerance: largest error of a step [rad, summed over the joints]; infinite for steps of the constant length ``first``.
        first: length of the first step [cells].
        longest: largest step length [cells].
        limit: (B,) largest bending angles [rad].
        angles: (S, B, N) angles at the samples [rad]; overwritten, including the first one.
        rates: (S, B, N) rates at the samples [rad/s]; overwritten, including the first one.
        lost: (B,) for each arm, the end of the step [cells] in which it exceeded its limit; infinite if it never did.
        taken: (A,) lengths of the first A steps [cells]; overwritten.
        beyond: (B, N) angles of the arms when they exceeded their limits [rad].

    Returns:
        The number of steps.
    """
    count, links = q.shape
    work = np.zeros((7, count, links))
    z_new, z_now = np.zeros_like(z), np.zeros_like(z)
    torque, scratch = np.zeros_like(impulse[:, 0]), np.zeros((ROWS, links))
    t, h, samples, sample, steps = 0.0, first, angles.shape[0], 1, 0
    p = weights.shape[1]
    angles[0], rates[0] = q, v
    for b in range(count):
        if not abs(bending_angle(q, b)) <= limit[b]:
            lost[b] = 0.0
            beyond[b] = q[b]
    while sample < samples and lost.max() == inf:
        step = min(h, until[floor(t)] - t)
        error, bow = extrapolate(system, q, v, z, impulse, t, step, cell, weights, work, z_now, torque, scratch)
        if sample * per_sample < t + step:  # there are samples within the step
            error = max(error, _INTERPOLATION * bow)
        # shorter steps also locate the instant at which the arm exceeds its limit
        good = error <= tolerance and abs(bending_angle(work[0], 0)) <= limit[0]
        if not good and tolerance < inf and lost[0] == inf and step > SHORTEST:
            h = step / 2
            continue
        q_new, v_new = work[0], work[1]
        if z.shape[0]:
            update_states(system, z, q, q_new, step * cell, z_new)
        for b in range(count):
            gone = not abs(bending_angle(q_new, b)) <= limit[b]
            if tolerance < inf and lost[0] < inf:  # the first arm, which controls the steps, is lost
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
            interpolate(q, v, q_new, v_new, step * cell, x, angles[sample], rates[sample])
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
        elif tolerance < inf and step == h and error * 2.0**p < _GROWTH_MARGIN * tolerance:
            h = min(2 * h, longest)
    return steps


def integrate_separately(
    system: Any, begin: int, end: int, q: Array, v: Array, z: Array, impulse: Array, cell: float, per_sample: int, until: Array,
    weights: Array, tolerance: Array, first: float, longest: float, limit: Array, angles: Array, rates: Array, lost: Array,
    beyond: Array,
) -> None:  # fmt: skip
    """Integrate each arm with its own step lengths; otherwise as :func:`integrate`.

    Args:
        system: the arms.
        begin: index of the first arm.
        end: index after the last arm.
        q: (B, N) as for :func:`integrate`.
        v: (B, N) as for :func:`integrate`.
        z: (B, states, 1, N) states of the laws.
        impulse: (B, C + 1) integral of the torque.
        cell: length of a cell [s].
        per_sample: number of cells from sample to sample.
        until: (B, C + 1) for each cell, the next cell end that no step may pass.
        weights: (2, p) as for :func:`extrapolate`.
        tolerance: (B,) largest error of a step [rad].
        first: length of the first step [cells].
        longest: largest step length [cells].
        limit: (B,) largest bending angles [rad].
        angles: (B, S, 1, N) angles at the samples [rad]; overwritten.
        rates: (B, S, 1, N) rates at the samples [rad/s]; overwritten.
        lost: (B,) as for :func:`integrate`.
        beyond: (B, N) as for :func:`integrate` [rad].
    """
    taken = np.zeros(0)
    for b in range(begin, end):
        one = b + 1
        integrate(
            single_arm(system, b), q[b:one], v[b:one], z[b], impulse[b:one], cell, per_sample, until[b], weights, tolerance[b],
            first, longest, limit[b:one], angles[b], rates[b], lost[b:one], taken, beyond[b:one],
        )  # fmt: skip


def advance(system: Any, q: Array, v: Array, z: Array, impulse: Array, cell: float, weights: Array, limit: Array) -> int:
    """Take steps of one cell each, in place; the end of the last cell is the only sample.

    Args:
        system: the arms.
        q: (B, N) angles [rad].
        v: (B, N) rates [rad/s].
        z: (states, B, N) states of the laws.
        impulse: (B, C + 1) integral of the torque, as for :func:`integrate`.
        cell: length of a cell [s].
        weights: (2, p) as for :func:`extrapolate`.
        limit: (B,) largest bending angles [rad].

    Returns:
        The number of arms that exceeded their limits; their angles are those at that instant, and their rates are NaN.
    """
    count, links = q.shape
    cells = impulse.shape[1] - 1
    until, lost, room = np.arange(1.0, cells + 1), np.full(count, inf), np.zeros((5, count, links))
    angles, rates, beyond = room[0:2], room[2:4], room[4]
    integrate(
        system, q, v, z, impulse, cell, cells, until, weights, inf, 1.0, 1.0, limit, angles, rates, lost, until[:0], beyond,
    )  # fmt: skip
    gone = 0
    for b in range(count):
        if lost[b] < inf:
            q[b] = beyond[b]
            v[b] = nan
            gone += 1
    return gone
