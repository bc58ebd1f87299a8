"""How arms in space are bent whose markers are seen, as :mod:`hsr_pin.identification.pose` tells it of those in a plane."""

from __future__ import annotations

import numpy as np

from hsr_pin.robot.space_kinematics import SpaceMarkerMap
from hsr_pin.trajectory import Array

#: Markers are never trusted to better than this [m].
_SURE = 1e-4
#: Modes of curvature along the arm in each direction; each is expected to be smaller than the one before by this factor.
_MODES, _SMOOTH = 4, 3.0
#: Gauss-Newton steps, at most, the longest change of an amplitude [rad], and the largest that counts as none.
_STEPS, _FARTHEST, _DONE = 60, 1.0, 1e-9


def poses_in_space(places: SpaceMarkerMap, links: int, positions: Array, velocities: Array, noise: float) -> tuple[Array, Array]:
    """The smoothest poses, without twist, that show markers where they are, and their rates.

    Args:
        places: of one arm's markers.
        links: N.
        positions: (R, M, 3) [m] of the markers of R poses; NaN where not seen.
        velocities: (R, M, 3) [m/s].
        noise: of a coordinate [m].

    Returns:
        (R, N, 3) coordinates [rad] and rates [rad/s].
    """
    count, sure = min(_MODES, links), max(noise, _SURE)
    along = np.polynomial.legendre.legvander(2 * (np.arange(links) + 0.5) / links - 1, count - 1) / links
    modes = np.zeros((2 * count, links, 3))  # towards x, then towards y
    modes[:count, :, 0], modes[count:, :, 1] = along.T, along.T
    penalty = np.tile(_SMOOTH ** np.arange(count), 2) ** 2
    seen = np.isfinite(positions) & np.isfinite(velocities)
    kappa, slopes, normal = np.zeros((len(positions), 2 * count)), np.empty(0), np.empty(0)
    for _ in range(_STEPS):
        q = np.einsum("rk,kni->rni", kappa, modes).reshape(len(kappa), -1)
        shown = [places.velocities(q, np.broadcast_to(mode.ravel(), q.shape)) for mode in modes]
        slopes = np.where(seen[..., None], np.stack(shown, axis=-1), 0.0).reshape(len(kappa), -1, 2 * count) / sure
        miss = np.where(seen, places.positions(q) - positions, 0.0).reshape(len(kappa), -1) / sure
        normal = np.swapaxes(slopes, 1, 2) @ slopes + np.diag(penalty)
        downhill = np.einsum("rmk,rm->rk", slopes, miss) + penalty * kappa
        change = np.clip(np.linalg.solve(normal, downhill[..., None])[..., 0], -_FARTHEST, _FARTHEST)
        kappa = kappa - change
        if np.abs(change).max() < _DONE:
            break
    pull = np.einsum("rmk,rm->rk", slopes, np.where(seen, velocities, 0.0).reshape(len(kappa), -1) / sure)
    rates = np.linalg.solve(normal, pull[..., None])[..., 0]
    return np.einsum("rk,kni->rni", kappa, modes), np.einsum("rk,kni->rni", rates, modes)
