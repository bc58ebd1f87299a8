"""The largest plausible distance of a marker from the base: the backbone is inextensible, but an arc length may be wrong."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array, Dataset

#: A marker may be at most this multiple of its arc length plus this distance [m] away from the base.
_LONGER, _OFF = 1.1, 0.05


def farthest(dataset: Dataset, markers: list[int]) -> tuple[Array, tuple[str, ...]]:
    """Return the largest plausible distances (M,) [m] from the base, and notes on markers beyond their declared arc lengths.

    Markers with such notes may be up to the arm's length away, because their arc length is doubtful, not the trial.
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
        f"marker {marker.name} is {1e3 * seen:.0f} mm from the base in most samples, but is declared "
        f"{1e3 * marker.arc_length:.0f} mm along the arm; check its arc_length"
        for marker, seen, wrong in zip(chosen, usual, misplaced, strict=True)
        if wrong
    )
    return np.where(misplaced, whole, own), notes
