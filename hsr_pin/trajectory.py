"""Motion, simulated or measured, in one frozen type; trials and datasets made of it.

World frame everywhere: z up, origin at the base of the arm, the arm bends in the x-z plane.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hsr_pin.errors import InputError, SpecificationError, quoted
from hsr_pin.parameters import finite

Array = NDArray[np.float64]

MOUNTS = ("hanging", "upright", "horizontal")
BENDS = ("plane", "space")


def read_only(values: ArrayLike | None) -> Array | None:
    """A float copy that cannot be written to (None stays None).

    Raises:
        InputError: not numbers, or too large for a float.
    """
    if values is None:
        return None
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("array", expected="numbers", received=quoted(values)) from error
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Marker:
    """A tracked point of the arm.

    Attributes:
        name: any; column prefix in a recording.
        arc_length: distance from the base along the backbone [m].
        radius: distance from the backbone [m]; of an arm in space alone.
        angle: of the direction in which it lies, from x towards y of its link [rad].
    """

    name: str
    arc_length: float
    radius: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        finite(f"arc length of marker {self.name}", self.arc_length, "a finite number [m]")
        finite(f"radius of marker {self.name}", self.radius, "a finite number [m]")
        finite(f"angle of marker {self.name}", self.angle, "a finite number [rad]")

    @property
    def beside(self) -> complex:
        """Where it is seen from its place on the backbone [m]: towards x, and towards y of its link."""
        return cmath.rect(self.radius, self.angle)


@dataclass(frozen=True)
class Section:
    """One stretch of an arm, by itself.

    Attributes:
        length: arc length [m].
        mass: [kg], spread evenly over it.
        keq: its bending stiffness [Nm/rad].
        damping: its damping [Nm s/rad].
    """

    length: float
    mass: float
    keq: float
    damping: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value, zero = getattr(self, field.name), field.name == "damping"
            is_number = isinstance(value, int | float | np.floating) and not isinstance(value, bool) and np.isfinite(value)
            if not is_number or value < 0 or (value == 0 and not zero):
                expected = "a number, zero or more" if zero else "a number, more than zero"
                raise SpecificationError(f"{field.name} of a section", expected=expected, received=quoted(value))


@dataclass(frozen=True)
class Channel:
    """A pressure, or the tension of a tendon, that was recorded beside the motion of an arm in space.

    Attributes:
        name: column in a recording.
        unit: of its values.
        torque: (2 S,) [N m per unit] what it gives each of S sections, towards x and towards y of the base; none: it was measured
            and drives nothing.
    """

    name: str
    unit: str
    torque: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Marker positions over time, with the input that caused them.

    Attributes:
        time: (T,) [s], increasing, evenly spaced.
        markers: (M,) the tracked points, in the order of ``positions``.
        positions: (T, M, 3) [m] in the world frame; NaN where a marker was not seen.
        torque: (T,) [N m] the commanded torque, held from each sample to the next, in space (T, 2) towards x and towards y of the
            base, or (T, 2 S) for S sections; None without this input.
        pressures: (T, 2) [bar] the commanded pressures P1, P2; None without this input.
        joint_angles: (T, N) [rad], simulated motion only; in space (T, N, 3), towards x, towards y and twist.
        joint_rates: as these, [rad/s].
        notes: what was done to the data on the way here, one sentence each.
        channels: (T, C) values of the dataset's channels, from which its torque was made; None without them.
    """

    time: Array
    markers: tuple[Marker, ...]
    positions: Array
    torque: Array | None = None
    pressures: Array | None = None
    joint_angles: Array | None = None
    joint_rates: Array | None = None
    notes: tuple[str, ...] = ()
    channels: Array | None = None

    def __post_init__(self) -> None:
        for name in ("time", "positions", "torque", "pressures", "channels", "joint_angles", "joint_rates"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        samples = self.time.shape[0]
        shapes = {
            "time": (samples,),
            "positions": (samples, len(self.markers), 3),
            "torque": (samples,) if self.torque is None or self.torque.ndim == 1 else (samples, self.torque.shape[1]),
            "pressures": (samples, 2),
        }
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                raise ValueError(f"{name}: expected shape {shape}, got {value.shape}")

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def has_input(self) -> bool:
        """Whether a command was recorded; without one the motion is a free release."""
        return self.torque is not None or self.pressures is not None

    def marker(self, name: str) -> Array:
        """(T, 3) [m] positions of one marker.

        Raises:
            KeyError: listing the markers that there are.
        """
        names = [marker.name for marker in self.markers]
        if name not in names:
            raise KeyError(f"no marker {name!r}; there are {', '.join(names)}")
        return self.positions[:, names.index(name)]


@dataclass(frozen=True, eq=False)
class Trial:
    """One recorded run and what is declared about it.

    Attributes:
        name: the file's stem (``"trial_01"``).
        trajectory: the whole recording, as it is on disk (or cleaned, as its notes say).
        keq: declared bending stiffness [Nm/rad].
        damping: declared damping C of the whole arm [Nm s/rad]; None if not declared.
        tip_mass: declared payload at the tip [kg].
        t_start: use the recording from here on [s]; None: from its first sample.
        interpolated: whether the input goes straight from sample to sample instead of being held; None: not declared.
    """

    name: str
    trajectory: Trajectory
    keq: float
    damping: float | None = None
    tip_mass: float = 0.0
    t_start: float | None = None
    interpolated: bool | None = None

    @property
    def starts_at_rest(self) -> bool:
        """Settled under its first input sample (True), or starting from the pose that the markers show (False)."""
        return self.trajectory.has_input and self.t_start is None

    @property
    def first_sample(self) -> int:
        """Index of the first sample at or after ``t_start``."""
        if self.t_start is None:
            return 0
        return int(np.searchsorted(self.trajectory.time, self.t_start - 1e-9))


@dataclass(frozen=True, eq=False)
class Dataset(Mapping[str, "Trial"]):
    """Recordings of one arm: a mapping from the names of its trials to them.

    Attributes:
        name: of the dataset.
        length: arc length of the backbone [m].
        mass: [kg].
        diameter: [m].
        mount: "hanging", "upright" or "horizontal".
        trials: at least one.
        description: one line.
        path: the folder it was read from; None if it was made in memory.
        notes: what was done to the data on the way here, one sentence each.
        bending: "plane", or "space" where the arm bends about two axes.
        torsion: declared stiffness against twisting [Nm/rad]; infinite: it does not twist.
        sections: that the arm is declared to be made of, in space, from the base on; none: a uniform arm. A trial's ``keq`` and
            ``damping`` are those of all together.
        channels: what was recorded beside the motion, and the torque that each gives.
        chain: number of links and placement of the joints of the model that simulated it; None where it was recorded.
        weighed: whether the mass is known, so that no other is considered.
        smoothed: samples of the moving average that its tracks went through, an odd number, 1: none; None: nobody says.
    """

    name: str
    length: float
    mass: float
    diameter: float
    mount: str
    trials: tuple[Trial, ...]
    description: str = ""
    path: Path | None = None
    notes: tuple[str, ...] = ()
    bending: str = "plane"
    torsion: float = inf
    sections: tuple[Section, ...] = ()
    channels: tuple[Channel, ...] = ()
    chain: tuple[int, str] | None = None
    smoothed: int | None = None
    weighed: bool = False

    def __getitem__(self, name: str) -> Trial:
        return {trial.name: trial for trial in self.trials}[name]

    __eq__, __hash__ = object.__eq__, object.__hash__  # not a mapping's: two recordings are equal if they are one

    def __iter__(self) -> Iterator[str]:
        return (trial.name for trial in self.trials)

    def __len__(self) -> int:
        return len(self.trials)

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The tracked points, the same in every trial."""
        return self.trials[0].trajectory.markers

    @property
    def axes(self) -> tuple[int, ...]:
        """The world's coordinates in which its arm moves: x and z, in space all three."""
        return (0, 1, 2) if self.bending == "space" else (0, 2)
