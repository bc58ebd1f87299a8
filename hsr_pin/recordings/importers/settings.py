"""What a capture does not say about the arm, and how to read it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from hsr_pin.errors import InputError
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.mapping import TableMapping
from hsr_pin.trajectory import MOUNTS

_Value = TypeVar("_Value")


@dataclass(frozen=True)
class ImportSettings:
    """What a capture does not say about the arm, and how to read it.

    What belongs to a trial (``keq``, ``damping``, ``tip_mass``, ``t_start``, ``inputs``) is a sequence: one value for all files,
    or one for each; an empty one leaves it undeclared.

    Attributes:
        mass: [kg].
        diameter: [m].
        keq: [Nm/rad].
        length: [m]; None: the arc length of the farthest marker.
        name: of the dataset.
        description: one line.
        mount: "hanging", "upright", "horizontal"; None: told from the straight pose.
        markers: which points are what; none: every named point is a marker.
        origin: (3,) [m] the base in the laboratory's frame; None: a marker with arc length 0, or estimated.
        up: the laboratory's axis that points up (``"+z"``); None: as the tracking system has it.
        bending: the laboratory's axis that positive bending carries the tip towards; None: told from the input, or else the
            side of the largest excursion. A horizontal arm needs none: positive is down.
        unit: of length, in place of what the files say.
        own_plane: fit the bending plane to each file, not to all together (arms pulled aside by hand).
        damping: [Nm s/rad].
        tip_mass: [kg].
        t_start: [s] on the capture's clock, 0 at its first frame.
        inputs: CSV files ``t,P1,P2`` or ``t,tau`` on the same clock; with a mapping, files as it says.
        mapping: what stands where in tables that are not of a known system, and in those of the input.
    """

    mass: float
    diameter: float
    keq: Sequence[float]
    length: float | None = None
    name: str = "imported"
    description: str = ""
    mount: str | None = None
    markers: Sequence[Body] = ()
    origin: Sequence[float] | None = None
    up: str | None = None
    bending: str | None = None
    unit: str | None = None
    own_plane: bool = False
    damping: Sequence[float] = ()
    tip_mass: Sequence[float] = ()
    t_start: Sequence[float] = ()
    inputs: Sequence[str | Path] = ()
    mapping: TableMapping | None = None

    def __post_init__(self) -> None:
        if self.mount is not None and self.mount not in MOUNTS:
            raise InputError("mount", expected=" or ".join(MOUNTS), received=repr(self.mount))
        names = [body.name for body in self.markers]
        for name in names:
            if names.count(name) > 1:
                raise InputError("markers", expected="each name once", received=f"{name!r} twice")
        if self.origin is not None and (len(self.origin) != 3 or not all(math.isfinite(value) for value in self.origin)):
            raise InputError("origin", expected="three numbers [m]", received=repr(self.origin))
        self._check_numbers("mass", [self.mass], zero=False)
        self._check_numbers("diameter", [self.diameter], zero=False)
        self._check_numbers("length", [] if self.length is None else [self.length], zero=False)
        self._check_numbers("keq", self.keq, zero=False)
        self._check_numbers("damping", self.damping, zero=True)
        self._check_numbers("tip_mass", self.tip_mass, zero=True)
        if not self.keq:
            raise InputError("keq", expected="a stiffness [Nm/rad]", received="none")

    @staticmethod
    def _check_numbers(name: str, values: Sequence[float], *, zero: bool) -> None:
        for value in values:
            if not math.isfinite(value) or value < 0 or (value == 0 and not zero):
                raise InputError(
                    name, expected=f"a number, {'zero or more' if zero else 'more than zero'}", received=f"{value:g}"
                )


def per_trial(values: Sequence[_Value], trials: int, name: str) -> list[_Value | None]:
    """One value for each trial: of none, one, or as many as there are trials.

    Raises:
        InputError: of any other number.
    """
    if len(values) not in (0, 1, trials):
        raise InputError(name, expected=f"one for all files, or one for each of {trials}", received=len(values))
    return list(values) if len(values) == trials else [values[0] if values else None] * trials
