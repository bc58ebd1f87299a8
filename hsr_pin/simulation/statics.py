"""Equilibrium under a constant torque: drive * u - springs - effects - G(q) = 0, by a damped Newton method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Residual torque [N m] at which a pose counts as an equilibrium.
TOLERANCE = 1e-12
#: Residual [N m] that is still accepted where rounding lets it fall no further.
ACCEPTED = 1e-8
_ITERATIONS = 60
_HALVINGS = 8


def equilibrium(columns: Columns, torque: Array, wanted: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """The poses at which the arms rest under constant torques (B,) [N m], loaded from the straight, never bent arm.

    Args:
        columns: the arms.
        torque: (B,) [N m].
        wanted: (B,) columns to solve for; the others stay straight.

    Returns:
        Joint angles (N, B) [rad], and (B,) whether an equilibrium was found.
    """
    straight = np.zeros((columns.shape.links, len(columns.scenarios)), order="F")
    virgin = columns.virgin_states()
    models = [arm.model for arm in columns.arm_models]
    data = {id(model): model.createData() for model in models}
    drive = columns.drive * torque
    tolerance = TOLERANCE * np.maximum(1.0, np.abs(torque))

    def residual(q: Array) -> Array:
        states = columns.update(virgin, straight, q, math.inf)
        gravity = [pin.computeGeneralizedGravity(m, data[id(m)], q[:, b]).copy() for b, m in enumerate(models)]
        return np.asarray(drive + columns.torque(q, straight, states) - np.column_stack(gravity))

    q, rest = straight, residual(straight)
    for _ in range(_ITERATIONS):
        moving = wanted & (np.abs(rest).max(axis=0) >= tolerance)
        if not moving.any():
            break
        local = _local_stiffness(columns, q, virgin, straight)
        direction = np.zeros_like(q)
        for b in np.flatnonzero(moving):
            slope = pin.computeGeneralizedGravityDerivatives(models[b], data[id(models[b])], q[:, b])
            direction[:, b] = _solve(np.diag(local[:, b]) + slope, rest[:, b])
        direction *= np.minimum(1.0, 0.5 / np.maximum(np.abs(direction).max(axis=0), 1e-300))
        q, rest = _line_search(residual, q, rest, direction, moving)
    return q, wanted & (np.abs(rest).max(axis=0) < ACCEPTED * np.maximum(1.0, np.abs(torque)))


def _line_search(
    residual: Callable[[Array], Array], q: Array, rest: Array, direction: Array, moving: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Halve the step of each moving column until its residual falls; near the solution, where rounding rules, take it whole."""
    size = np.linalg.norm(rest, axis=0)
    scale = np.ones(len(moving))
    for _ in range(_HALVINGS):
        trial = q + scale * direction
        new = residual(trial)
        worse = moving & (size > 1e-9) & ~(np.linalg.norm(new, axis=0) <= size * (1 - 1e-4 * scale))
        if not worse.any():
            break
        scale = np.where(worse, scale / 2, scale)
    return trial, new


def _solve(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:  # at the point of buckling: along the other directions
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def _local_stiffness(columns: Columns, q: Array, virgin: tuple[Array, ...], straight: Array) -> Array:
    """(N, B) [Nm/rad] of springs and effects; every law is local to its joint, so one difference gives the diagonal."""
    width = 1e-6 / columns.shape.links
    ends = [columns.torque(q + w, straight, columns.update(virgin, straight, q + w, math.inf)) for w in (-width, width)]
    return np.asarray((ends[0] - ends[1]) / (2 * width))
