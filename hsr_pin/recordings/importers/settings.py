"""Settings of an import: the description of the arm, and how to read the captures."""

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
from hsr_pin.recordings.plausible import implausible_angle
from hsr_pin.recordings.sections import torque_columns
from hsr_pin.trajectory import BENDS, MOUNTS, Channel, Section

_Value = TypeVar("_Value")

#: Value of ``input_offset`` for an offset that is estimated.
AUTO = "auto"


@dataclass(frozen=True)
class ImportSettings:
    """Settings of an import: the description of the arm, and how to read the captures.

    The settings of a trial (``keq``, ``damping``, ``tip_mass``, ``t_start``, ``inputs``, ``input_offset``) are sequences with one
    value for all files or one for each; an empty sequence leaves them undeclared.

    Attributes:
        mass: mass of the arm [kg].
        diameter: outer diameter [m].
        keq: bending stiffness [Nm/rad].
        length: arc length of the arm [m]; None: the arc length of the outermost marker.
        name: name of the dataset.
        description: one line of text.
        mount: "hanging", "upright", "horizontal", "flat"; None: determined from the straight pose, which is not flat.
        markers: markers and the points that define them; empty: every named point is a marker.
        origin: (3,) position of the base [m] in the laboratory's frame; None: a marker with arc length 0, or estimated.
        up: axis of the laboratory that points up (``"+z"``); None: by the convention of the tracking system.
        bending: "plane", or "space" where the arm bends about two axes.
        x: direction of the arm's x axis, towards which positive bending moves the tip: an axis of the laboratory (``"+x"``), in
            space also a direction (``"0.8,0.6,0"``), or "input": determined from the input. None: in a plane determined from
            the input, or else the side of the largest excursion; in space the first axis perpendicular to the arm. For a
            horizontal arm positive is down.
        unit: unit of length, in place of that in the files.
        own_plane: fit the bending plane to each file instead of all files together (for arms deflected by hand).
        damping: damping of the whole arm [Nm s/rad].
        tip_mass: payload at the tip [kg].
        t_start: start of the used part [s] on the capture's clock, 0 at its first frame; None: the first frame.
        inputs: CSV files ``t,P1,P2`` or ``t,tau`` on the same clock, in space ``t,tau_x,tau_y`` (for sections ``tau_x_1``, ...)
            or, with a gain, chambers; with a mapping, files as it describes; ``"-"``: no input.
        input_offset: time added to the times of the input [s], or "auto": estimated from motion and command.
        mapping: meaning of the columns of tables of unknown systems and of input files.
        torsion: torsional stiffness of an arm in space [Nm/rad]; infinite: no twist.
        sections: sections of an arm in space, from base to tip; empty: a uniform arm.
        channels: input and measured channels of an arm in space, in the order of the mapping; empty: torques.
        gain: torque per unit [N m per unit] of inputs that are chambers spaced evenly around an arm in space; in place of
            channels.
        angle: angle of the first chamber [rad], from x towards y of the base.
        interpolated: whether the input was measured and is interpolated linearly; None: not declared.
        cut: times [s] on the clock of the recording at which new trials begin, for all files, or "auto": where the arm rests.
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
    cut: Sequence[float] | str = ()

    @property
    def in_space(self) -> bool:
        """Whether the arm bends about two axes."""
        return self.bending == "space"

    @property
    def inputs_of_arm(self) -> int:
        """Number of torques of an arm in space, of two components each: one for each section."""
        return max(1, len(self.sections))

    @property
    def input_columns(self) -> tuple[tuple[str, ...], ...]:
        """Accepted sets of columns of an input file in addition to ``t``; empty: any columns."""
        if self.gain is not None:
            return ()
        return (torque_columns(len(self.sections)),) if self.in_space else IN_PLANE

    def __post_init__(self) -> None:
        if self.mount is not None and self.mount not in MOUNTS:
            raise InputError("mount", expected=" or ".join(MOUNTS), received=repr(self.mount))
        if self.bending not in BENDS:
            is_axis = self.bending.lower().lstrip("+-") in set("xyz")
            hint = "use --x for the direction of positive bending" if is_axis else ""
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
                expected = "a distance from the backbone [m], at most the length of the arm"
                raise InputError(f"radius of marker {body.name}", expected=expected, received=f"{body.radius:g}")
        self._check_numbers("mass", [self.mass], zero=False)
        self._check_numbers("diameter", [self.diameter], zero=False)
        self._check_numbers("length", [] if self.length is None else [self.length], zero=False)
        self._check_numbers("keq", self.keq, zero=False)
        self._check_numbers("damping", self.damping, zero=True)
        for offset in self.input_offset:
            if offset != AUTO and not (isinstance(offset, int | float) and math.isfinite(offset)):
                raise InputError("input_offset", expected=f"a time in s, or {AUTO}", received=repr(offset))
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
        for name in (name for name, is_used in only.items() if is_used and not self.in_space):
            raise InputError(name, expected="--bending space together with this option", received=self.bending)
        if self.own_plane and self.in_space:
            raise InputError("own_plane", expected="an arm that bends in a plane", received="an arm in space")
        if self.gain is not None and self.channels:
            raise InputError("gain", expected="either a gain or [[input]]", received="both")
        if self.gain is not None and len(self.sections) > 1:
            hint = "declare [[input]] in --map"
            raise InputError("gain", expected="an arm of one section", received=len(self.sections), hint=hint)
        for name, value in (("gain", self.gain), ("angle", self.angle)):
            if value is not None and not math.isfinite(value):
                raise InputError(name, expected="a number", received=f"{value:g}")
        for name, angle in (
            ("angle", self.angle),
            *((f"angle of marker {body.name}", body.angle or 0.0) for body in self.markers),
        ):
            if reason := implausible_angle(angle):
                raise InputError(name, **reason.facts)
        self._check_numbers("torsion", [] if math.isinf(self.torsion) else [self.torsion], zero=True)

    @staticmethod
    def _check_numbers(name: str, values: Sequence[float], *, zero: bool) -> None:
        for value in values:
            if not math.isfinite(value) or value < 0 or (value == 0 and not zero):
                raise InputError(
                    name, expected=f"a number, {'zero or more' if zero else 'more than zero'}", received=f"{value:g}"
                )


def per_trial(values: Sequence[_Value], trials: int, name: str) -> list[_Value | None]:
    """Return one value for each trial from a sequence with no value, one value, or one for each trial.

    Raises:
        InputError: the sequence has another length.
    """
    if len(values) not in (0, 1, trials):
        raise InputError(name, expected=f"one value for all files, or one for each of {trials} files", received=len(values))
    return list(values) if len(values) == trials else [values[0] if values else None] * trials
