"""How far from the base a marker may be: the backbone does not stretch, but a place on it may be declared wrongly."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array, Dataset

#: A marker farther from the base than this times its arc length plus this [m] is no marker of this arm.
_LONGER, _OFF = 1.1, 0.05


def farthest(dataset: Dataset, markers: list[int]) -> tuple[Array, tuple[str, ...]]:
    """(M,) [m] from the base, by marker, and what is to be said of those that are farther than their arc lengths in most samples.

    They may be as far as the arm is long: it is their place that is in doubt, not the trial.
    """
    chosen = [dataset.markers[i] for i in markers]
    own, whole = (
        _LONGER * np.array(lengths) + np.array([marker.radius for marker in chosen]) + _OFF
        for lengths in ([marker.arc_length for marker in chosen], [dataset.length] * len(chosen))
    )
    distances = np.concatenate([np.linalg.norm(trial.trajectory.positions[:, markers], axis=2) for trial in dataset.trials])
    usual = np.array([np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else 0.0 for column in distances.T])
    surface = np.array([marker.radius or dataset.diameter / 2 for marker in chosen])
    misplaced = usual > _LONGER * np.array([marker.arc_length for marker in chosen]) + surface
    notes = tuple(
        f"marker {marker.name} is {1e3 * seen:.0f} mm from the base in most samples, though declared "
        f"{1e3 * marker.arc_length:.0f} mm along the arm: check its arc_length"
        for marker, seen, wrong in zip(chosen, usual, misplaced, strict=True)
        if wrong
    )
    return np.where(misplaced, whole, own), notes
