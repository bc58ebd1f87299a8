"""What a capture does not say about the arm, and how to read it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from hsr_pin.errors import InputError
from hsr_pin.recordings.declaration import LONGEST
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.command_rows import IN_PLANE
from hsr_pin.recordings.importers.mapping import FARTHEST, TableMapping
from hsr_pin.recordings.plausible import angle_doubt
from hsr_pin.recordings.sections import torque_columns
from hsr_pin.trajectory import BENDS, MOUNTS, Channel, Section

_Value = TypeVar("_Value")

#: The offset of an input that is to be estimated.
AUTO = "auto"


@dataclass(frozen=True)
class ImportSettings:
    """What a capture does not say about the arm, and how to read it.

    What belongs to a trial (``keq``, ``damping``, ``tip_mass``, ``t_start``, ``inputs``, ``input_offset``) is a sequence: one for
    all files, or one for each; an empty one leaves it undeclared.

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
        bending: "plane", or "space" where the arm bends about two axes.
        x: where x of the arm points, to which positive bending carries the tip: an axis of the laboratory (``"+x"``), or in space
            a direction there (``"0.8,0.6,0"``), or "input": as the input shows it. None: in a plane told from the input, or else
            the side of the largest excursion; in space the first axis across the arm. A horizontal arm needs none: positive is
            down.
        unit: of length, in place of what the files say.
        own_plane: fit the bending plane to each file, not to all together (arms pulled aside by hand).
        damping: [Nm s/rad].
        tip_mass: [kg].
        t_start: [s] on the capture's clock, 0 at its first frame; None: from there on.
        inputs: CSV files ``t,P1,P2`` or ``t,tau`` on the same clock, in space ``t,tau_x,tau_y`` (of sections ``tau_x_1``, ...)
            or, with a gain, chambers; with a mapping, files as it says; ``"-"``: none.
        input_offset: [s] added to the times of the input, or "auto": as motion and command show it.
        mapping: what stands where in tables that are not of a known system, and in those of the input.
        torsion: stiffness against twisting, in space [Nm/rad]; infinite: it does not twist.
        sections: that the arm is made of, in space, from the base on; none: a uniform arm.
        channels: of the input and what was measured beside it, in space, in the order of the mapping's; none: torques.
        gain: [N m per unit] of each column of the inputs, which are chambers evenly around an arm in space; in place of channels.
        angle: [rad] of the first of them, from x towards y of the base.
        interpolated: whether the input was measured, and goes straight from sample to sample; None: nobody says.
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
    bending: str = BENDS[0]
    x: str | None = None
    unit: str | None = None
    own_plane: bool = False
    damping: Sequence[float] = ()
    tip_mass: Sequence[float] = ()
    t_start: Sequence[float | None] = ()
    inputs: Sequence[str | Path] = ()
    input_offset: Sequence[float | str] = ()
    mapping: TableMapping | None = None
    torsion: float = math.inf
    sections: Sequence[Section] = ()
    channels: Sequence[Channel] = ()
    gain: float | None = None
    angle: float = 0.0
    interpolated: bool | None = None

    @property
    def in_space(self) -> bool:
        """Whether the arm bends about two axes."""
        return self.bending == "space"

    @property
    def inputs_of_arm(self) -> int:
        """Torques of an arm in space, of two components each: one for each section."""
        return max(1, len(self.sections))

    @property
    def input_columns(self) -> tuple[tuple[str, ...], ...]:
        """The sets of columns that a file of commands may have beside ``t``; none: whatever it has."""
        if self.gain is not None:
            return ()
        return (torque_columns(len(self.sections)),) if self.in_space else IN_PLANE

    def __post_init__(self) -> None:
        if self.mount is not None and self.mount not in MOUNTS:
            raise InputError("mount", expected=" or ".join(MOUNTS), received=repr(self.mount))
        if self.bending not in BENDS:
            is_axis = self.bending.lower().lstrip("+-") in set("xyz")
            hint = "where positive bending carries the tip is said by --x" if is_axis else ""
            raise InputError("bending", expected=" or ".join(BENDS), received=repr(self.bending), hint=hint)
        self._check_space()
        names = [body.name for body in self.markers]
        for name in names:
            if names.count(name) > 1:
                raise InputError("markers", expected="each name once", received=f"{name!r} twice")
        if self.origin is not None and (len(self.origin) != 3 or not all(abs(value) <= FARTHEST for value in self.origin)):
            raise InputError("origin", expected=f"three numbers [m], up to {FARTHEST:g}", received=repr(self.origin))
        for body in self.markers:
            if body.radius > (LONGEST if self.length is None else self.length):
                expected = "a distance from the backbone [m] no longer than the arm"
                raise InputError(f"radius of marker {body.name}", expected=expected, received=f"{body.radius:g}")
        self._check_numbers("mass", [self.mass], zero=False)
        self._check_numbers("diameter", [self.diameter], zero=False)
        self._check_numbers("length", [] if self.length is None else [self.length], zero=False)
        self._check_numbers("keq", self.keq, zero=False)
        self._check_numbers("damping", self.damping, zero=True)
        for offset in self.input_offset:
            if offset != AUTO and not (isinstance(offset, int | float) and math.isfinite(offset)):
                raise InputError("input_offset", expected=f"a number of s, or {AUTO}", received=repr(offset))
        self._check_numbers("tip_mass", self.tip_mass, zero=True)
        if not self.keq:
            raise InputError("keq", expected="a stiffness [Nm/rad]", received="none")

    def _check_space(self) -> None:
        only = {
            "torsion": math.isfinite(self.torsion),
            "sections": bool(self.sections),
            "channels": bool(self.channels),
            "gain": self.gain is not None,
            "marker beside the backbone": any(body.radius for body in self.markers),
            "pose of a marker": any(body.pose for body in self.markers),
        }
        for name in (name for name, said in only.items() if said and not self.in_space):
            raise InputError(name, expected="--bending space with it", received=self.bending)
        if self.own_plane and self.in_space:
            raise InputError("own_plane", expected="an arm that bends in a plane", received="one in space")
        if self.gain is not None and self.channels:
            raise InputError("gain", expected="a gain, or [[input]]", received="both")
        if self.gain is not None and len(self.sections) > 1:
            raise InputError("gain", expected="an arm of one section", received=len(self.sections), hint="say [[input]] in --map")
        for name, value in (("gain", self.gain), ("angle", self.angle)):
            if value is not None and not math.isfinite(value):
                raise InputError(name, expected="a number", received=f"{value:g}")
        for name, angle in (
            ("angle", self.angle),
            *((f"angle of marker {body.name}", body.angle or 0.0) for body in self.markers),
        ):
            if doubt := angle_doubt(angle):
                raise InputError(name, **doubt.facts)
        self._check_numbers("torsion", [] if math.isinf(self.torsion) else [self.torsion], zero=True)

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
