"""What belongs to a trial of an arm: where it rests, how far it was held aside, when it was let go, and how firmly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

#: How well a release is known beyond noise: the pose [share of the length, at the tip], and the instant [samples].
HELD, INSTANT = 0.002, 0.25
#: A hand that lets go slowly does so within the last of these times [s]; what is left of its hold until each of them is known to
#: that share of what holds the bent arm.
LETS_GO, GRIP = (0.02, 0.04, 0.06), (0.5, 0.3, 0.12)


def rest_scatter(rests: Sequence[tuple[object, ArrayLike, ArrayLike]], noise: float) -> float:
    """Standard deviation [m], in each direction, with which an arm comes to rest where it should in every trial.

    Args:
        rests: for each trial the group of those that should rest in one place, the place [m] of the farthest marker across the
            arm, and the bending [m] from which it came: what goes with that is memory of the arm, and no scatter. In space (2,).
        noise: of a place [m].

    Returns:
        0 where it is not clearly more than noise, or nothing repeats.
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
