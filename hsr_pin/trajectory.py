"""Frozen types for simulated and measured motion: trajectories, trials and datasets.

All positions are in the world frame: z points up, the origin is at the base of the arm, a planar arm bends in the x-z plane. If
this plane is horizontal (mount "flat"), y is vertical.
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
from hsr_pin.obstacles import Obstacle
from hsr_pin.parameters import finite

Array = NDArray[np.float64]

MOUNTS = ("hanging", "upright", "horizontal", "flat")
BENDS = ("plane", "space")
#: Attributes of a trajectory that hold its input.
INPUTS = ("torque", "pressures", "channels", "commanded")


def read_only(values: ArrayLike | None) -> Array | None:
    """Return a read-only float copy of an array (None for None).

    Raises:
        InputError: the values are not numbers, or too large for a float.
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
        name: any text; the prefix of its columns in a recording.
        arc_length: distance from the base along the backbone [m].
        radius: distance from the backbone [m]; used for arms in space only.
        angle: direction from the backbone to the marker, from x towards y of its link [rad].
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
    def offset(self) -> complex:
        """Offset of the marker from the backbone [m] as a complex number: towards x (real) and y (imaginary) of its link."""
        return cmath.rect(self.radius, self.angle)


@dataclass(frozen=True)
class Section:
    """One section of an arm that is made of several sections in series.

    Attributes:
        length: arc length of the section [m].
        mass: mass of the section [kg], distributed uniformly along it.
        keq: bending stiffness of the section alone [Nm/rad].
        damping: damping of the section alone [Nm s/rad].
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
    """A pressure or tendon tension that was recorded with the motion of an arm in space.

    Attributes:
        name: name of its column in a recording.
        unit: unit of its values.
        torque: (2 S,) torque per unit on each of S sections, about the axes that bend it towards x and towards y of the base
            [N m per unit]; empty if the channel was only measured and drives nothing.
    """

    name: str
    unit: str
    torque: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Marker positions over time, together with the input that was applied.

    Attributes:
        time: (T,) [s], increasing, evenly spaced.
        markers: (M,) the tracked points, in the order of ``positions``.
        positions: (T, M, 3) marker positions in the world frame [m]; NaN where a marker was not seen.
        torque: (T,) the commanded torque, held from each sample to the next [N m]; of an arm in space (T, 2), towards x and
            towards y of the base, or (T, 2 S) for S sections; None without this input.
        pressures: (T, 2) the commanded pressures P1 and P2 [bar]; None without this input.
        joint_angles: (T, N) joint angles, for simulated motion only [rad]; in space (T, N, 3): towards x, towards y and twist.
        joint_rates: joint velocities in the same shape as ``joint_angles`` [rad/s].
        notes: one sentence for each processing step that the data went through.
        channels: (T, C) values of the dataset's channels, from which the torque was computed; None without them.
        commanded: (T, C) commands of the columns of ``inputs`` where these were measured; NaN for a column without a command;
            None without commands beside measured inputs.
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
    commanded: Array | None = None

    def __post_init__(self) -> None:
        for name in ("time", "positions", *INPUTS, "joint_angles", "joint_rates"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        samples = self.time.shape[0]
        shapes = {
            "time": (samples,),
            "positions": (samples, len(self.markers), 3),
            "torque": (samples,) if self.torque is None or self.torque.ndim == 1 else (samples, self.torque.shape[1]),
            "pressures": (samples, 2),
            "commanded": (samples, 0 if self.inputs is None else self.inputs.shape[1]),
        }
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                raise ValueError(f"{name}: expected shape {shape}, got {value.shape}")

    @property
    def step(self) -> float:
        """Sampling interval [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def has_input(self) -> bool:
        """Whether a command was recorded; without one the motion is a release from an initial pose."""
        return self.torque is not None or self.pressures is not None

    @property
    def inputs(self) -> Array | None:
        """Recorded input columns (T, C): pressures, channels or torques; None without an input."""
        given = next((each for each in (self.pressures, self.channels, self.torque) if each is not None), None)
        return None if given is None else given.reshape(len(self.time), -1)

    def marker(self, name: str) -> Array:
        """Return the positions of one marker, (T, 3) [m].

        Raises:
            KeyError: there is no such marker; the message lists the existing ones.
        """
        names = [marker.name for marker in self.markers]
        if name not in names:
            raise KeyError(f"no marker {name!r}; there are {', '.join(names)}")
        return self.positions[:, names.index(name)]


@dataclass(frozen=True, eq=False)
class Trial:
    """One recorded trial with its declared parameters.

    Attributes:
        name: stem of the file name (``"trial_01"``).
        trajectory: the whole recording as stored on disk, or after the cleaning steps in its notes.
        keq: declared bending stiffness [Nm/rad].
        damping: declared damping C of the whole arm [Nm s/rad]; None if it is not declared.
        tip_mass: declared payload at the tip [kg].
        t_start: time from which the recording is used [s]; None: from its first sample.
        interpolated: whether the input is interpolated linearly between samples instead of held; None if it is not declared. An
            input that was recorded beside its command is a measured one, which is interpolated unless declared otherwise.
    """

    name: str
    trajectory: Trajectory
    keq: float
    damping: float | None = None
    tip_mass: float = 0.0
    t_start: float | None = None
    interpolated: bool | None = None

    def __post_init__(self) -> None:
        if self.interpolated is None and self.trajectory.commanded is not None:
            object.__setattr__(self, "interpolated", True)

    @property
    def starts_at_rest(self) -> bool:
        """Whether the arm starts in equilibrium under the first input sample (otherwise from the pose that the markers show)."""
        return self.trajectory.has_input and self.t_start is None

    @property
    def first_sample(self) -> int:
        """Index of the first sample at or after ``t_start``."""
        if self.t_start is None:
            return 0
        return int(np.searchsorted(self.trajectory.time, self.t_start - 1e-9))


@dataclass(frozen=True, eq=False)
class Dataset(Mapping[str, "Trial"]):
    """Recorded trials of one arm: a mapping from trial names to trials.

    Attributes:
        name: name of the dataset.
        length: arc length of the backbone [m].
        mass: mass of the arm [kg].
        diameter: diameter of the arm [m].
        mount: "hanging", "upright", "horizontal", or "flat" for a planar arm that bends in a horizontal plane.
        trials: at least one trial.
        description: one line.
        path: the folder from which the dataset was read; None if it was created in memory.
        notes: one sentence for each processing step that the data went through.
        bending: "plane", or "space" if the arm bends about two axes.
        torsion: declared torsional stiffness [Nm/rad]; infinite if the arm does not twist.
        sections: declared sections of an arm in space, from the base to the tip; empty for a uniform arm. The ``keq`` and
            ``damping`` of a trial are those of all sections in series.
        channels: pressures or tensions that were recorded with the motion, and the torque that each of them produces.
        chain: number of links and joint placement of the model that simulated the dataset; None for a measured one.
        smoothed: window of the moving average that was applied to the tracks, an odd number of samples, 1 for none; None if it is
            not declared.
        weighed: whether the mass is known, so that no fit changes it.
        obstacles: rigid bodies that the arm may touch.
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
    obstacles: tuple[Obstacle, ...] = ()

    def __getitem__(self, name: str) -> Trial:
        return {trial.name: trial for trial in self.trials}[name]

    __eq__, __hash__ = object.__eq__, object.__hash__  # by identity: Mapping would compare arrays

    def __iter__(self) -> Iterator[str]:
        return (trial.name for trial in self.trials)

    def __len__(self) -> int:
        return len(self.trials)

    @property
    def markers(self) -> tuple[Marker, ...]:
        """The tracked points, which are the same in every trial."""
        return self.trials[0].trajectory.markers

    @property
    def axes(self) -> tuple[int, ...]:
        """Indices of the world coordinates in which the arm moves: x and z for a planar arm, all three in space."""
        return (0, 1, 2) if self.bending == "space" else (0, 2)
