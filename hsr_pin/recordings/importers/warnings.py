"""What in an import looks as if something given, or taken for granted, were wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.recordings.importers.capture import seen
from hsr_pin.recordings.importers.plane import TELLS
from hsr_pin.trajectory import Dataset, Trajectory

#: Motion out of the plane is suspicious from this share of that in it on, if it is more than so much [m].
OUT_OF_PLANE, VISIBLE = 0.3, 2e-3
#: In space motion out of the plane of the largest motion is to be expected, at least of this share.
SPATIAL = 0.03
#: So much [rad] beside where its input bends it, no arm goes that was declared rightly.
ASIDE = 0.35
#: And a base that moves by this share of the arm's length.
BASE_MOVES = 0.1


def warnings(dataset: Dataset, spreads: Sequence[tuple[float, float]], up_is_told: bool) -> tuple[str, ...]:
    """One sentence for each thing.

    Args:
        dataset: what was imported.
        spreads: (trials, 2) [m] root mean square motion in the plane and out of it.
        up_is_told: the user said which axis is up.
    """
    found = []
    if dataset.bending == "space" and all(out < SPATIAL * within for within, out in spreads):
        found.append("every trial stays in a plane: did the arm move to several sides? if not, leave --bending space away")
    for trial, (within, out) in zip(dataset.trials, spreads, strict=True):
        if dataset.bending == "plane" and out > max(OUT_OF_PLANE * within, VISIBLE):
            hint = "does the arm move in space (--bending space), or differ the planes of the files (--own-plane)"
            found.append(
                f"{trial.name}: {1e3 * out:.3g} mm of motion out of the plane, {1e3 * within:.3g} mm in it; "
                f"{hint}{'?' if up_is_told else ', or is another axis up (--up)?'}"
            )
        moved = _base_motion(trial.trajectory)
        if moved > BASE_MOVES * dataset.length:
            found.append(
                f"{trial.name}: the base moves by up to {moved:.3g} m; an arm that is carried about cannot be compared with one "
                f"that is clamped: is it the right point (--base), in one unit with the others?"
            )
    return tuple(found)


def beside_its_input(angle: float, sure: float) -> list[str]:
    """A sentence where an arm in space does not go where its input bends it.

    Args:
        angle: [rad] from the torque to where it goes.
        sure: how sure that is, from 0 to 1.
    """
    if sure < TELLS or abs(angle) < ASIDE:
        return []
    return [
        f"the arm goes {np.degrees(angle):.0f} deg beside where its input bends it: is x another axis (--x, or --x input), or do "
        f"inputs lie at another angle?"
    ]


def _base_motion(trajectory: Trajectory) -> float:
    """The largest distance [m] of a marker at the base from the origin, but for one sample in a hundred."""
    base = [index for index, marker in enumerate(trajectory.markers) if marker.arc_length == 0]
    if not base:
        return 0.0
    places = trajectory.positions[:, base[0]]
    places = places[seen(places)]
    return float(np.percentile(np.linalg.norm(places, axis=1), 99)) if len(places) else 0.0
