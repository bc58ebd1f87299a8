"""How an arm is bent whose markers are seen: the most smoothly held pose that shows them where they are.

The moment along the arm is a sum of Legendre polynomials, as many as the markers can tell; a weak penalty on the higher ones
keeps noise out of them. Curvature is moment over stiffness, so that the pose of a held arm follows what is fitted.
"""

from __future__ import annotations

import numpy as np

from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array

#: Markers are never trusted to better than this [m] ...
_SURE = 1e-4
#: ... nor so far that the smoothest arm is more than this many times as far from them, on the root mean square, as trust says:
#: where they are declared elsewhere than they are, an arm that showed them all would be folded.
_DISAGREE = 2.0
#: Each mode of curvature is expected to be smaller than the one before by this factor, the first to be about 1 rad.
_SMOOTH = 3.0
#: Gauss-Newton steps with each number of modes on the way to all of them, and the longest step [rad].
_STEPS, _FARTHEST = 4, 1.0
#: The last steps go on until one is shorter than this [rad], or for so many.
_DONE, _MOST = 1e-10, 30
#: A search that begins near a pose and comes to be so much worse than it was is led astray: it begins anew.
_WORSE = 10.0
#: Differences for derivatives [rad]: one-sided on the way; in the last steps central ones, exact to some 1e-11 m/rad. What these
#: are in error by belongs to the pose.
_WIDTH, _FINE = 1e-6, 1e-5


def modes_of(columns: Columns, seen: int) -> Array:
    """(C, N, K) joint angles of each mode, for so many markers that are seen.

    In space (C, 3 N, 2 K) without twist, each mode towards x and then towards y.
    """
    links = columns.links
    count = min(2 * seen, 4, links)
    s = 2 * (np.arange(links) + 0.5) / links - 1
    along = np.polynomial.legendre.legvander(s, max(count, 1) - 1)[None, :, :count] / (links * columns.arrays.profile[..., None])
    if not columns.space:
        return np.asarray(along)
    modes = np.zeros((len(along), links, 3, count, 2))
    modes[:, :, 0, :, 0] = modes[:, :, 1, :, 1] = along
    return modes.reshape(len(along), 3 * links, 2 * count)


def pose_from_markers(
    columns: Columns, cameras: Cameras, positions: Array, velocities: Array, noise: float, near: Array | None = None
) -> tuple[Array, Array, Array]:
    """The pose and its rate.

    Args:
        columns: C arms that are seen to be in the same place.
        cameras: what is seen of them.
        positions: (M, 3) [m] of the markers; NaN where not seen.
        velocities: (M, 3) [m/s].
        noise: of a coordinate [m].
        near: (K,) amplitudes of the modes, found for a similar arm.

    Returns:
        (C, N) [rad], (C, N) [rad/s], in space (C, 3 N), and the amplitudes (K,) of the modes for the first arm.
    """
    seen = np.isfinite(positions).all(axis=1)
    modes = modes_of(columns, int(seen.sum()))
    count = modes.shape[2]
    if count == 0:
        return np.zeros((2, *modes.shape[:2]))[0], np.zeros(modes.shape[:2]), np.zeros(0)
    axes, alike = ((0, 1, 2), 2) if columns.space else ((0, 2), 1)
    least = max(noise, _SURE)
    sure = np.full((len(columns), 1), least)
    penalty, limit = _SMOOTH ** (np.arange(count) // alike), _DISAGREE**2 * 2 * seen.sum()
    kappa = np.zeros((len(columns), count))
    plan = [active for active in range(alike, count, alike) for _ in range(_STEPS)] + [count] * _MOST
    if near is not None and len(near) == count:
        kappa[:], plan = near, [count] * _MOST
    jacobian, begun = np.empty(0), np.full(len(columns), np.inf)
    for active in plan:
        ways = np.eye(count)[:active]
        last = active == count
        steps = np.vstack([np.zeros(count), _FINE * ways, -_FINE * ways] if last else [np.zeros(count), _WIDTH * ways])
        poses = np.einsum("cnk,tck->tcn", modes, kappa + steps[:, None])
        shown = cameras.positions(poses)[:, :, seen][..., axes].reshape(len(steps), len(columns), -1) / sure
        ahead, behind = shown[1 : active + 1], shown[active + 1 :] if last else shown[0]
        jacobian = np.moveaxis(ahead - behind, 0, -1) / (2 * _FINE if last else _WIDTH)  # (C, AM, active)
        miss = shown[0] - positions[seen][:, axes].ravel() / sure
        cost = (miss**2).sum(axis=1) + ((penalty * kappa) ** 2).sum(axis=1)
        if last and near is not None and np.any(cost > _WORSE * begun):
            return pose_from_markers(columns, cameras, positions, velocities, noise)
        begun = np.minimum(begun, cost)
        normal = np.swapaxes(jacobian, 1, 2) @ jacobian + np.diag(penalty[:active] ** 2)
        slope = np.einsum("cmk,cm->ck", jacobian, miss) + penalty[:active] ** 2 * kappa[:, :active]
        change = np.clip(np.linalg.solve(normal, slope[..., None])[..., 0], -_FARTHEST, _FARTHEST)
        kappa[:, :active] -= change
        if not last:
            continue
        before, sure = sure, np.maximum(least, sure * np.sqrt(cost / limit)[:, None])
        if np.abs(change).max() < _DONE and np.abs(sure / before - 1).max() < _DONE:
            break
    pull = np.einsum("cmk,cm->ck", jacobian, velocities[seen][:, axes].ravel() / sure)
    rate = np.linalg.solve(normal, pull[..., None])[..., 0]
    return np.einsum("cnk,ck->cn", modes, kappa), np.einsum("cnk,ck->cn", modes, rate), kappa[0]
