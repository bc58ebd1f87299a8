"""Equilibrium under a constant torque: drive * u - springs - effects - G(q) = 0, by a damped Newton method."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Residual torque [N m] at which a pose counts as an equilibrium.
TOLERANCE = 1e-12
_ITERATIONS = 60


def equilibrium(columns: Columns, torque: Array) -> tuple[Array, tuple[Array, ...], Array]:
    """The poses at which the arms rest under constant torques (B,) [N m], loaded from the straight, never bent arm.

    Returns:
        Joint angles (N, B) [rad], the laws' internal states there, and (B,) whether an equilibrium was found.
    """
    links, count = columns.shape.links, len(columns.scenarios)
    straight = np.zeros((links, count), order="F")
    virgin = columns.virgin_states()
    models = [(arm.model, arm.model.createData()) for arm in columns.arm_models]
    drive = columns.drive * torque

    def residual(q: Array) -> Array:
        states = columns.update(virgin, straight, q, math.inf)
        gravity = np.column_stack([pin.computeGeneralizedGravity(m, d, q[:, b]) for b, (m, d) in enumerate(models)])
        return np.asarray(drive + columns.torque(q, straight, states) - gravity)

    q = straight.copy(order="F")
    rest = residual(q)
    for _ in range(_ITERATIONS):
        size = np.abs(rest).max(axis=0)
        open_columns = np.flatnonzero(~(size < TOLERANCE * np.maximum(1.0, np.abs(torque))))
        if not len(open_columns):
            break
        local = _local_stiffness(columns, q, virgin, straight)
        direction = np.zeros_like(q)
        for b in open_columns:
            model, data = models[b]
            jacobian = np.diag(local[:, b]) + pin.computeGeneralizedGravityDerivatives(model, data, q[:, b])
            direction[:, b] = np.linalg.lstsq(jacobian, rest[:, b], rcond=None)[0]
        direction *= np.minimum(1.0, 0.5 / np.maximum(np.abs(direction).max(axis=0), 1e-300))
        scale = np.ones(count)
        for _ in range(8):
            trial = np.asfortranarray(q + scale * direction)
            new = residual(trial)
            worse = ~(np.linalg.norm(new, axis=0) <= np.linalg.norm(rest, axis=0) * (1 - 1e-4 * scale)) & (size > 1e-9)
            if not worse.any():
                break
            scale = np.where(worse, scale / 2, scale)
        q, rest = trial, new
    found = np.abs(rest).max(axis=0) < 1e-8 * np.maximum(1.0, np.abs(torque))
    return q, columns.update(virgin, straight, q, math.inf), found


def _local_stiffness(columns: Columns, q: Array, virgin: tuple[Array, ...], straight: Array) -> Array:
    """(N, B) [Nm/rad] of springs and effects; every law is local to its joint, so one difference gives the diagonal."""
    width = 1e-6 / columns.shape.links
    ends = [columns.torque(q + w, straight, columns.update(virgin, straight, q + w, math.inf)) for w in (-width, width)]
    return np.asarray((ends[0] - ends[1]) / (2 * width))
