"""The bending plane, and which side of it is positive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.alignment import Alignment, bending_direction, frame
from hsr_pin.recordings.importers.capture import seen
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.straight import StraightArm
from hsr_pin.recordings.importers.up import axis_vector
from hsr_pin.trajectory import Array

#: Correlation of input and tip below which the input does not tell which way is positive.
TELLS = 0.3


@dataclass(frozen=True, eq=False)
class Motion:
    """One trial as far as the plane goes.

    Attributes:
        time: (T,) [s].
        positions: (T, B, 3) [m] from base to tip, without spikes, in the laboratory's frame.
        command: its input, if it has one.
    """

    time: Array
    positions: Array
    command: CommandRows | None


def fit_plane(motions: Sequence[Motion], arm: StraightArm, mount: str, up: Array, x: str | None) -> tuple[Alignment, str]:
    """The arm's frame, and a sentence on which way x points.

    A horizontal arm points along +x and bends up and down. A vertical one bends towards x, at right angles to ``up``: the
    direction in which its markers move most.

    Raises:
        RecordingError: a vertical arm that does not move, with no ``x`` to go by.
        InputError: ``x`` is not across the arm, or not the way the arm bends.
    """
    if mount == "horizontal":
        return frame(arm.origin, arm.direction, up), _horizontal_note(motions, arm, up)
    fitted = bending_direction([motion.positions[:, arm.moving] for motion in motions], up)
    if x is not None:
        wanted = axis_vector(x, "x")
        if abs(wanted @ up) > 0.9:
            raise InputError("x", expected="an axis across the arm", received=x)
        if fitted is None:
            return frame(arm.origin, wanted, up), f"x is the laboratory's {x}: the arm hardly moves"
        agreement = float(fitted @ wanted)
        if abs(agreement) < 0.3:
            raise InputError("x", expected="an axis along the bending plane", received=f"{x}, across it")
        return frame(arm.origin, np.sign(agreement) * fitted, up), f"x is the way of the laboratory's {x}"
    if fitted is None:
        raise RecordingError("no moving marker", expected="motion that shows the bending plane", hint="say the plane with --x")
    excursions = [(motion.positions[:, -1] - arm.pose[-1]) @ fitted for motion in motions]
    correlation = _correlation(motions, excursions)
    if abs(correlation) >= TELLS:
        return frame(arm.origin, np.sign(correlation) * fitted, up), "x is the way the arm goes as its input rises"
    every = np.concatenate(excursions)
    every = every[np.isfinite(every)]
    side = np.sign(every[np.argmax(np.abs(every))]) if len(every) else 1.0
    return frame(arm.origin, (side or 1.0) * fitted, up), "x is the side of the largest excursion (no input told it)"


def _correlation(motions: Sequence[Motion], excursions: Sequence[Array]) -> float:
    """Correlation of input and excursion over all motions; 0 where there is none."""
    drives, tips = [], []
    for motion, excursion in zip(motions, excursions, strict=True):
        if motion.command is not None:
            known = np.isfinite(excursion)
            drives.append(motion.command.drive_at(motion.time)[known])
            tips.append(excursion[known])
    drive, tip = (np.concatenate(values) if values else np.empty(0) for values in (drives, tips))
    if len(drive) < 2 or np.ptp(drive) == 0 or np.ptp(tip) == 0:
        return 0.0
    return float(np.corrcoef(drive, tip)[0, 1])


def _horizontal_note(motions: Sequence[Motion], arm: StraightArm, up: Array) -> str:
    falls = [-(motion.positions[:, -1] - arm.pose[-1]) @ up for motion in motions]
    note = "x is the way the straight arm points, positive bending is down"
    return f"{note}; as its input rises, the arm goes up" if _correlation(motions, falls) <= -TELLS else note


def spread(world: Array) -> tuple[float, float]:
    """Root mean square motion in the plane and out of it [m], of (T, B, 3) positions in the arm's frame, about each median."""
    within, out = [], []
    for places in world.swapaxes(0, 1):
        known = places[seen(places)]
        if len(known):
            motion = known - np.median(known, axis=0)
            within.append(motion[:, [0, 2]])
            out.append(motion[:, 1])
    if not within:
        return 0.0, 0.0
    return float(np.sqrt(np.mean(np.sum(np.concatenate(within) ** 2, axis=1)))), float(np.sqrt(np.mean(np.concatenate(out) ** 2)))
