"""The input of a simulation: an arm, its command, its initial state, and the markers to follow."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect, unsupported_laws
from hsr_pin.errors import InputError, quoted
from hsr_pin.parameters import finite
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.load import Load
from hsr_pin.trajectory import Array, Marker, read_only

#: Longest run [s]: one day, or 8.6 million default steps. Longer durations suggest times in another unit.
LONGEST = 86_400.0
#: Largest number of samples of a run.
MOST_SAMPLES = 10_000_000


@dataclass(frozen=True, eq=False)
class Settled:
    """Start in equilibrium under a constant torque [N m]; of arms in space a complex number, towards x and towards y.

    For an arm of S sections it is a tuple of S torques, or one for all sections.

    An arm with play has several equilibria: the search starts at the joint angles ``near`` (N,) [rad], of arms in space (N, 3)
    (default: straight).
    """

    torque: complex | tuple[complex, ...] = 0.0
    near: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "near", read_only(self.near))
        for each in self.torque if isinstance(self.torque, tuple) else (self.torque,):
            for part in (each.real, each.imag) if isinstance(each, complex) else (each,):
                finite("start", part, "a finite torque [N m]")
        if self.near is not None and not np.all(np.isfinite(self.near)):
            raise InputError("start", expected="finite angles [rad]", received=quoted(self.near))


@dataclass(frozen=True, eq=False)
class Pose:
    """Start from given joint angles (N,) [rad] and rates (N,) [rad/s] (default: at rest); of arms in space (N, 3) each."""

    angles: Array
    rates: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "angles", read_only(self.angles))
        object.__setattr__(self, "rates", read_only(np.zeros_like(self.angles) if self.rates is None else self.rates))
        assert self.rates is not None
        if self.rates.shape != self.angles.shape or not np.all(np.isfinite([self.angles, self.rates])):
            raise InputError(
                "start",
                expected="finite joint angles [rad] and as many finite rates [rad/s]",
                received=f"angles {self.angles}, rates {self.rates}",
            )


@dataclass(frozen=True, eq=False)
class Scenario:
    """The input of one run.

    Attributes:
        arm: the nominal arm.
        time: (T,) evenly spaced times of the result [s].
        torque: (T,) command at these times [N m]; of arms in space (T, 2), towards x and towards y of the base, and for S
            sections (T, 2 S).
        start: initial equilibrium under a torque, or initial pose.
        effects: effects in addition to the nominal model, at most one of each type.
        markers: points to follow; default: base, middle and tip.
        interpolated: whether the command is interpolated linearly between samples (as a measured pressure, for example) instead
            of held.
        loads: forces and moments on points of an arm in space.
    """

    arm: ArmSpecification
    time: Array
    torque: Array
    start: Settled | Pose = field(default_factory=Settled)
    effects: tuple[Effect, ...] = ()
    markers: tuple[Marker, ...] = ()
    interpolated: bool = False
    loads: tuple[Load, ...] = ()

    def __post_init__(self) -> None:
        time, torque = read_only(self.time), read_only(self.torque)
        assert time is not None and torque is not None
        if time.ndim != 1 or len(time) < 2 or not np.all(np.isfinite(time)):
            raise InputError("time", expected="at least two finite times [s]", received=f"shape {time.shape}")
        if time[-1] - time[0] > LONGEST or len(time) > MOST_SAMPLES:
            expected = f"at most {LONGEST:g} s and {MOST_SAMPLES:g} samples"
            received = f"{time[-1] - time[0]:g} s, {len(time)} samples"
            raise InputError("time", expected=expected, received=received, hint="times are in seconds; these may be milliseconds")
        steps = np.diff(time)
        if np.any(steps <= 0) or np.ptp(steps) > 1e-6 * steps.mean():
            raise InputError(
                "time", expected="increasing, evenly spaced", received=f"steps from {steps.min():g} to {steps.max():g} s"
            )
        self._check_space(torque, len(time))
        kinds = [type(effect) for effect in self.effects]
        if len(set(kinds)) < len(kinds):
            raise InputError("effects", expected="each effect at most once", received=", ".join(kind.name for kind in kinds))
        angles = self.start.angles if isinstance(self.start, Pose) else self.start.near
        shape = (self.arm.links, 3) if self.arm.bending == "space" else (self.arm.links,)
        if angles is not None and angles.shape != shape:
            expected = f"{self.arm.links} joint angles" if len(shape) == 1 else f"joint angles {shape}"
            raise InputError("start", expected=expected, received=f"shape {angles.shape}")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "torque", torque)
        if not self.markers:
            object.__setattr__(self, "markers", standard_markers(self.arm.length))

    def _check_space(self, torque: Array, samples: int) -> None:
        """Raise an error if a planar arm is given properties of an arm in space, or the reverse."""
        space = self.arm.bending == "space"
        parts = max(1, len(self.arm.sections))
        if torque.shape != ((samples, 2 * parts) if space else (samples,)) or not np.all(np.isfinite(torque)):
            each = f" for each of {parts} sections" if parts > 1 else ""
            expected = f"{samples} finite values [N m]" + (f" towards x and towards y{each}" if space else "")
            raise InputError("torque", expected=expected, received=f"shape {torque.shape}")
        if isinstance(self.start, Settled) and isinstance(self.start.torque, tuple) and len(self.start.torque) != parts:
            raise InputError("start", expected=f"one torque, or {parts}", received=str(len(self.start.torque)))
        if not space and (self.loads or (isinstance(self.start, Settled) and isinstance(self.start.torque, complex | tuple))):
            name = "loads" if self.loads else "start"
            hint = 'an arm in space has bending="space"'
            raise InputError(
                name, expected="a planar torque and no loads for a planar arm", received="an input in space", hint=hint
            )
        if not space and (off := [marker.name for marker in self.markers if marker.radius]):
            raise InputError(
                "markers", expected="markers on the backbone of a planar arm", received=f"{off[0]}, which is off the backbone"
            )
        if wrong := unsupported_laws(self.effects, space=space):
            expected = "laws that are defined for arms in space" if space else "laws that are defined for planar arms"
            raise InputError("effects", expected=expected, received=wrong)
        for load in self.loads:
            load.wrenches(samples)
            if not 0 <= load.arc_length <= self.arm.length * (1 + 1e-9):
                expected = f"from 0 to the arm's length, {self.arm.length:g} m"
                raise InputError("arc length of a load", expected=expected, received=f"{load.arc_length:g}")

    @property
    def reach(self) -> Array:
        """Arc lengths of the markers (M,) [m]."""
        return np.array([marker.arc_length for marker in self.markers])

    @property
    def beside(self) -> Array:
        """Complex offsets of the markers from the backbone (M,), towards x and y of their links [m]."""
        return np.array([marker.offset for marker in self.markers])

    @property
    def points(self) -> Array:
        """Arc lengths of the loads (K,) [m]."""
        return np.array([load.arc_length for load in self.loads])

    @property
    def command(self) -> Array:
        """Commanded torque (T,) [N m]; of arms in space (T, S) complex, towards x and towards y."""
        return np.asarray(self.torque[:, 0::2] + 1j * self.torque[:, 1::2] if self.torque.ndim == 2 else self.torque)

    @property
    def initial_torque(self) -> Array:
        """Torque before the first sample [N m]; of arms in space (S,) complex."""
        before = self.start.torque if isinstance(self.start, Settled) else self.command[0]
        return np.array(np.broadcast_to(before, self.command.shape[1:]), dtype=self.command.dtype)

    @property
    def step(self) -> float:
        """Sampling interval [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


def standard_markers(length: float) -> tuple[Marker, ...]:
    """Return markers at base, middle and tip of an arm of this length [m]."""
    return (Marker("base", 0.0), Marker("mid", length / 2), Marker("tip", length))


def step_scenario(
    arm: ArmSpecification, torque: ArrayLike, *, rest: float = 0.1, duration: float = 3.0, step: float = 0.01, **more: object
) -> Scenario:
    """Return a scenario with zero torque for ``rest`` [s], then a constant ``torque`` [N m] until ``duration`` [s].

    This is the input of the paper's Fig. 4. For an arm in space the torque is towards x, or (2,); the same for all sections, or
    (2 S,).

    Raises:
        InputError: the torque is not a number, or the duration or the step [s] is invalid for a run.
    """
    if space := arm.bending == "space":
        parts = [finite("torque", part) for part in (*np.atleast_1d(torque), 0.0)]
        torque = np.tile(parts[:2], max(1, len(arm.sections))) if len(parts) < 4 else parts[:-1]
    else:
        torque = finite("torque", torque)
    rest = finite("rest", rest)
    if not (0 < finite("step", step) <= finite("duration", duration) <= LONGEST and duration / step <= MOST_SAMPLES):
        expected = f"a step above 0, at most {MOST_SAMPLES:g} steps, and at most {LONGEST:g} s"
        raise InputError("duration", expected=expected, received=f"{duration:g} s in steps of {step:g} s")
    time = np.arange(round(duration / step) + 1) * step
    resting = time < rest - step / 2
    held = np.where(resting[:, None] if space else resting, 0.0, torque)
    return Scenario(arm, time, held, Settled(0.0), **more)  # type: ignore[arg-type]
