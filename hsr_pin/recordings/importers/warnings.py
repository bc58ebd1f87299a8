"""Warnings about an import whose settings or assumptions seem to be wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.recordings.importers.capture import seen
from hsr_pin.recordings.importers.plane import SIGNIFICANT_CORRELATION
from hsr_pin.trajectory import Dataset, Trajectory

#: Smallest suspicious motion out of the bending plane: as a share of that in the plane, and in metres.
OUT_OF_PLANE, VISIBLE = 0.3, 2e-3
#: Smallest expected share of motion out of the plane of the largest motion for an arm in space.
SPATIAL = 0.03
#: Smallest suspicious angle between the commanded and the observed bending direction [rad].
ASIDE = 0.35
#: Smallest suspicious motion of the base, as a share of the arm's length.
BASE_MOVES = 0.1


def warnings(dataset: Dataset, spreads: Sequence[tuple[float, float]], up_is_given: bool) -> tuple[str, ...]:
    """Return one sentence for each suspicious property of an imported dataset.

    Args:
        dataset: the imported dataset.
        spreads: (trials, 2) RMS motion [m] in the bending plane and out of it.
        up_is_given: whether the user gave the axis that is up.
    """
    found = []
    if dataset.bending == "space" and not dataset.sections and all(out < SPATIAL * within for within, out in spreads):
        found.append("every trial stays in one plane; if the arm moves in one plane only, leave out --bending space")
    for trial, (within, out) in zip(dataset.trials, spreads, strict=True):
        if dataset.bending == "plane" and out > max(OUT_OF_PLANE * within, VISIBLE):
            others = "the planes of the files differ (--own-plane)"
            causes = f" or {others}" if up_is_given else f", {others} or another axis is up (--up)"
            found.append(
                f"{trial.name}: {1e3 * out:.3g} mm of motion out of the plane, {1e3 * within:.3g} mm in it; "
                f"check whether the arm moves in space (--bending space){causes}"
            )
        moved = _base_motion(trial.trajectory)
        if moved > BASE_MOVES * dataset.length:
            found.append(
                f"{trial.name}: the base moves by up to {moved:.3g} m, but the model assumes a clamped base; check that it "
                f"is the right point (--base) and in the same unit as the others"
            )
    return tuple(found)


def misaligned_input(angle: float, correlation: float) -> list[str]:
    """Return a warning if an arm in space does not bend in the direction of its input, otherwise an empty list.

    Args:
        angle: angle from the torque to the deflection [rad].
        correlation: correlation of torque and deflection at that angle, from 0 to 1.
    """
    if correlation < SIGNIFICANT_CORRELATION or abs(angle) < ASIDE:
        return []
    return [
        f"the arm bends {np.degrees(angle):.0f} deg away from the direction of its input; check the x axis "
        "(--x, or --x input) and the angle of the inputs"
    ]


def _base_motion(trajectory: Trajectory) -> float:
    """Return the 99th percentile of the distance [m] of the base marker from the origin."""
    base = [index for index, marker in enumerate(trajectory.markers) if marker.arc_length == 0]
    if not base:
        return 0.0
    places = trajectory.positions[:, base[0]]
    places = places[seen(places)]
    return float(np.percentile(np.linalg.norm(places, axis=1), 99)) if len(places) else 0.0
