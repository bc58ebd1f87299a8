"""Parameters of a trial that are not parameters of the arm: resting position, initial pose, release instant and disturbance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

#: Standard deviations of a release beyond noise: of the pose [share of the length, at the tip], and of the instant [samples].
POSE_SIGMA, INSTANT_SIGMA = 0.002, 0.25
#: A slow release by hand ends at the last of these times [s]; the remaining holding torque until each of them has this standard
#: deviation, relative to the torque that holds the bent arm.
RELEASE_ENDS, DISTURBANCE_SIGMAS = (0.02, 0.04, 0.06), (0.5, 0.3, 0.12)


def rest_scatter(rests: Sequence[tuple[object, ArrayLike, ArrayLike]], noise: float) -> float:
    """Return the standard deviation [m], in each direction, of the resting position from trial to trial.

    Args:
        rests: for each trial its group of trials that should have the same resting position, the position of the farthest marker
            across the arm [m], and the bending [m] from which the arm came; in space (2,) each. A dependence on that bending is
            memory of the arm, not scatter.
        noise: standard deviation of a position due to noise [m].

    Returns:
        The standard deviation; 0 if it is not significantly larger than the noise, or if no trials can be compared.
    """
    squares = freedom = 0.0
    for group in dict.fromkeys(key for key, _, _ in rests):
        places, origins = (
            np.array([np.atleast_1d(each) for each in column])
            for column in zip(*((place, origin) for key, place, origin in rests if key == group), strict=True)
        )
        if len(places) < 3:
            continue
        columns = np.ones((len(places), 1))
        if np.ptp(origins, axis=0).max() > 10 * noise and len(places) > 3 + origins.shape[1]:
            columns = np.column_stack([columns, origins])
        for place in places.T:
            left = place - columns @ np.linalg.lstsq(columns, place, rcond=None)[0]
            squares, freedom = squares + float(left @ left), freedom + len(place) - columns.shape[1]
    variance = squares / freedom - noise**2 if freedom else 0.0
    return float(np.sqrt(variance)) if variance > 8 * noise**2 / np.sqrt(max(freedom, 1.0)) else 0.0
