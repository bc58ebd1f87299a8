"""The pose of an arm from its marker positions: the smoothest pose that agrees with them.

The moment along the arm is a sum of Legendre polynomials, as many as the markers can determine; a weak penalty on the higher ones
suppresses noise. Curvature is moment over stiffness, so the pose of a held arm depends on the fitted stiffness.
"""

from __future__ import annotations

import numpy as np

from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.trajectory import Array

#: Smallest standard deviation that is assumed for markers [m] ...
_SMALLEST_SIGMA = 1e-4
#: ... increased until the smoothest arm is at most this multiple of it away from them (RMS): if markers are declared at wrong
#: places, an arm through all of them would be folded.
_LARGEST_DEVIATION = 2.0
#: Ratio of the expected amplitudes of successive modes of curvature; that of the first is about 1 rad.
_SMOOTH = 3.0
#: Gauss-Newton steps with each number of modes on the way to all of them, and the longest step [rad].
_STEPS, _FARTHEST = 4, 1.0
#: Step length at which the search ends [rad], and the largest number of final steps.
_DONE, _MOST = 1e-10, 30
#: A search from a given pose restarts from the straight pose if its cost exceeds this multiple of the lowest one.
_WORSE = 10.0
#: Steps of the finite differences [rad]: one-sided at first; central in the last steps, exact to about 1e-11 m/rad, because their
#: error affects the pose.
_WIDTH, _FINE = 1e-6, 1e-5


def modes_of(batch: ArmBatch, seen: int) -> Array:
    """Return the joint angles (C, N, K) of each mode for a number of measured markers.

    In space they are (C, 3 N, 2 K) without twist, each mode towards x and then towards y.
    """
    links = batch.links
    count = min(2 * seen, 4, links)
    s = 2 * (np.arange(links) + 0.5) / links - 1
    along = np.polynomial.legendre.legvander(s, max(count, 1) - 1)[None, :, :count] / (links * batch.arrays.profile[..., None])
    if not batch.space:
        return np.asarray(along)
    modes = np.zeros((len(along), links, 3, count, 2))
    modes[:, :, 0, :, 0] = modes[:, :, 1, :, 1] = along
    return modes.reshape(len(along), 3 * links, 2 * count)


def pose_from_markers(
    batch: ArmBatch, cameras: Cameras, positions: Array, velocities: Array, noise: float, near: Array | None = None
) -> tuple[Array, Array, Array]:
    """Return the pose and its rate that agree with marker positions and velocities.

    Args:
        batch: C arms whose markers are at the same positions.
        cameras: the cameras that measure them.
        positions: (M, 3) marker positions [m]; NaN if not measured.
        velocities: (M, 3) marker velocities [m/s].
        noise: standard deviation of a coordinate [m].
        near: (K,) amplitudes of the modes for a similar arm, as initial guess.

    Returns:
        The angles (C, N) [rad] and rates (C, N) [rad/s], in space (C, 3 N), and the amplitudes (K,) of the modes for the first
        arm.
    """
    seen = np.isfinite(positions).all(axis=1)
    modes = modes_of(batch, int(seen.sum()))
    count = modes.shape[2]
    if count == 0:
        return np.zeros((2, *modes.shape[:2]))[0], np.zeros(modes.shape[:2]), np.zeros(0)
    axes, per_mode = ((0, 1, 2), 2) if batch.space else ((0, 2), 1)
    least = max(noise, _SMALLEST_SIGMA)
    sigma = np.full((len(batch), 1), least)
    penalty, limit = _SMOOTH ** (np.arange(count) // per_mode), _LARGEST_DEVIATION**2 * 2 * seen.sum()
    kappa = np.zeros((len(batch), count))
    plan = [active for active in range(per_mode, count, per_mode) for _ in range(_STEPS)] + [count] * _MOST
    if near is not None and len(near) == count:
        kappa[:], plan = near, [count] * _MOST
    jacobian, begun = np.empty(0), np.full(len(batch), np.inf)
    for active in plan:
        ways = np.eye(count)[:active]
        last = active == count
        steps = np.vstack([np.zeros(count), _FINE * ways, -_FINE * ways] if last else [np.zeros(count), _WIDTH * ways])
        poses = np.einsum("cnk,tck->tcn", modes, kappa + steps[:, None])
        shown = cameras.positions(poses)[:, :, seen][..., axes].reshape(len(steps), len(batch), -1) / sigma
        ahead, behind = shown[1 : active + 1], shown[active + 1 :] if last else shown[0]
        jacobian = np.moveaxis(ahead - behind, 0, -1) / (2 * _FINE if last else _WIDTH)  # (C, AM, active)
        miss = shown[0] - positions[seen][:, axes].ravel() / sigma
        cost = (miss**2).sum(axis=1) + ((penalty * kappa) ** 2).sum(axis=1)
        if last and near is not None and np.any(cost > _WORSE * begun):
            return pose_from_markers(batch, cameras, positions, velocities, noise)
        begun = np.minimum(begun, cost)
        normal = np.swapaxes(jacobian, 1, 2) @ jacobian + np.diag(penalty[:active] ** 2)
        slope = np.einsum("cmk,cm->ck", jacobian, miss) + penalty[:active] ** 2 * kappa[:, :active]
        change = np.clip(np.linalg.solve(normal, slope[..., None])[..., 0], -_FARTHEST, _FARTHEST)
        kappa[:, :active] -= change
        if not last:
            continue
        before, sigma = sigma, np.maximum(least, sigma * np.sqrt(cost / limit)[:, None])
        if np.abs(change).max() < _DONE and np.abs(sigma / before - 1).max() < _DONE:
            break
    pull = np.einsum("cmk,cm->ck", jacobian, velocities[seen][:, axes].ravel() / sigma)
    rate = np.linalg.solve(normal, pull[..., None])[..., 0]
    return np.einsum("cnk,ck->cn", modes, kappa), np.einsum("cnk,ck->cn", modes, rate), kappa[0]
