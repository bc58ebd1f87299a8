"""Estimation of the bending plane and of its positive side."""

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

#: Smallest correlation of input and tip for which the input determines the positive side.
SIGNIFICANT_CORRELATION = 0.3


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion and command of one trial, for the estimation of the bending plane.

    Attributes:
        time: (T,) times [s].
        positions: (T, B, 3) positions [m] from base to tip, without spikes, in the laboratory's frame.
        command: the input; None if there is none.
    """

    time: Array
    positions: Array
    command: CommandRows | None


def fit_plane(motions: Sequence[Motion], arm: StraightArm, mount: str, up: Array, x: str | None) -> tuple[Alignment, str]:
    """Return the arm's frame and a sentence on the direction of its x axis.

    A horizontal arm points along +x and bends up and down. A vertical arm bends towards x, the direction perpendicular to ``up``
    in which its markers move most. A flat arm points along +x, and y is vertical.

    Raises:
        RecordingError: a vertical arm does not move, and ``x`` is not given.
        InputError: ``x`` is not perpendicular to the arm, or not in its bending plane.
    """
    if mount == "horizontal":
        return frame(arm.origin, arm.direction, up), _horizontal_note(motions, arm, up)
    if mount == "flat":
        sideways = np.cross(up, arm.direction) / np.linalg.norm(np.cross(up, arm.direction))
        sign, note = _positive_side(motions, arm, sideways, None if x is None else axis_vector(x, "x"))
        along = np.cross(sideways, up)
        return Alignment(arm.origin, np.stack([along, sign * up, -sign * sideways])), f"positive bending is {note}"
    fitted = bending_direction([motion.positions[:, arm.moving] for motion in motions], up)
    if x is not None:
        wanted = axis_vector(x, "x")
        if abs(wanted @ up) > 0.9:
            raise InputError("x", expected="an axis perpendicular to the arm", received=x)
        if fitted is None:
            return frame(arm.origin, wanted, up), f"x is {x} of the laboratory, as the arm hardly moves"
        agreement = float(fitted @ wanted)
        if abs(agreement) < 0.3:
            raise InputError("x", expected="an axis in the bending plane", received=f"{x}, which is perpendicular to it")
        return frame(arm.origin, np.sign(agreement) * fitted, up), f"x points towards {x} of the laboratory, in the bending plane"
    if fitted is None:
        raise RecordingError("no moving marker", expected="motion that shows the bending plane", hint="give the plane with --x")
    sign, note = _positive_side(motions, arm, fitted, None)
    return frame(arm.origin, sign * fitted, up), f"x is {note}"


def _positive_side(motions: Sequence[Motion], arm: StraightArm, direction: Array, x: Array | None) -> tuple[float, str]:
    """Return the sign of a direction (3,) that is the positive side of bending, and its description.

    It is the side of an axis ``x`` if there is one, or else that of the input, or of the largest excursion.
    """
    if x is not None:
        return float(np.sign(x @ direction)) or 1.0, "towards the given axis"
    excursions = [(motion.positions[:, -1] - arm.pose[-1]) @ direction for motion in motions]
    correlation = _correlation(motions, excursions)
    if abs(correlation) >= SIGNIFICANT_CORRELATION:
        return float(np.sign(correlation)), "the direction of bending as the input rises"
    every = np.concatenate(excursions)
    every = every[np.isfinite(every)]
    side = float(np.sign(every[np.argmax(np.abs(every))])) if len(every) else 1.0
    return side or 1.0, "the side of the largest excursion, as no input determines it"


def _correlation(motions: Sequence[Motion], excursions: Sequence[Array]) -> float:
    """Return the correlation of input and excursion over all motions; 0 if there is no input."""
    drives, tips = [], []
    for motion, excursion in zip(motions, excursions, strict=True):
        if motion.command is not None:
            known = np.isfinite(excursion)
            drives.append(motion.command.bending_command_at(motion.time)[known])
            tips.append(excursion[known])
    drive, tip = (np.concatenate(values) if values else np.empty(0) for values in (drives, tips))
    if len(drive) < 2 or np.ptp(drive) == 0 or np.ptp(tip) == 0:
        return 0.0
    return float(np.corrcoef(drive, tip)[0, 1])


def _horizontal_note(motions: Sequence[Motion], arm: StraightArm, up: Array) -> str:
    falls = [-(motion.positions[:, -1] - arm.pose[-1]) @ up for motion in motions]
    note = "x is the direction of the straight arm, and positive bending is down"
    return f"{note}; the arm bends up as its input rises" if _correlation(motions, falls) <= -SIGNIFICANT_CORRELATION else note


def spread(world: Array) -> tuple[float, float]:
    """Return the RMS motion [m] of positions (T, B, 3) in the arm's frame about their medians, in and out of the plane."""
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
