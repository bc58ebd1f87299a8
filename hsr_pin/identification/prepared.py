"""Recordings of an arm, prepared for comparison with simulations."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hsr_pin.identification.nuisance import RELEASE_ENDS
from hsr_pin.identification.release import median
from hsr_pin.identification.smoothing import Filter
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.command import Delivered
from hsr_pin.trajectory import Array, Dataset, Marker, Trial

#: Markers closer to the base than this share of the length do not depend on bending.
BASE = 0.02
#: Largest number of samples over which the resting pose is averaged.
REST = 20
#: Smallest noise that is assumed [m].
QUIETEST = 1e-6
#: Tolerance of an integration step, relative to the motion of a run.
_FINE = 0.02
#: Model error that is assumed in addition to the noise, relative to the length; markers with less noise have equal weights.
TRUEST = 5e-4


@dataclass(frozen=True, eq=False)
class Run:
    """One trial as the model must reproduce it.

    Attributes:
        trial: the trial.
        time: (T,) times of the measured samples, from the start on [s].
        torque: (T,) commanded torque: tau, or Eqs. (4) and (5) with the declared Keq; zeros for a release [N m]. In space
            complex, towards x and y of the base; for an arm of sections the mean along the arm.
        measured: (T, M, 3) measured positions [m]; NaN in gaps.
        start_pose: (M, 3) marker positions at the start [m]; None for an equilibrium under the first torque.
        lead: fraction of a sample by which the motion starts before ``time[0]`` (a release between two samples).
        start_velocity: (M, 3) marker velocities at the start [m/s]; None if at rest.
        interpolated: whether the torque is interpolated linearly between samples instead of held.
        axes: indices of the world coordinates in which the arm moves.
        by_section: (T, S) commanded torque of an arm of S > 1 sections, complex [N m]; None if it is the same for all.
        place: position in the session, from 0 for the first trial to 1 for the last.
        every: only every so many of the samples that count are used.
        rows: (R,) samples that count: new ones with independent noise; None for all.
        smoothing: the filter that was applied to the markers; None for none.
        found_poses: cache of the initial poses, rates and modes by model, as initial guesses for other parameter values.
        declared: cache of the declared arm by chain.
        delivered: cache of the delivered torque without actuator effects, by whether a curve may be smoothed.
    """

    trial: Trial
    time: Array
    torque: Array
    measured: Array
    start_pose: Array | None
    lead: float
    start_velocity: Array | None = None
    interpolated: bool = False
    axes: tuple[int, ...] = (0, 2)
    by_section: Array | None = None
    place: float = 0.0
    every: int = 1
    rows: NDArray[np.intp] | None = None
    smoothing: Filter | None = None
    found_poses: dict[object, tuple[Array, Array, Array]] = field(default_factory=dict, repr=False)
    declared: dict[object, ArmSpecification] = field(default_factory=dict, repr=False)
    delivered: dict[bool, Delivered] = field(default_factory=dict, init=False, repr=False)

    @property
    def looked_at(self) -> NDArray[np.intp]:
        """Indices (R,) of the samples that are used."""
        return np.asarray((np.arange(len(self.time)) if self.rows is None else self.rows)[:: self.every])

    @property
    def instants(self) -> Array:
        """Times (R,) [s] of the samples that are used."""
        return np.asarray(self.time[self.looked_at])

    @cached_property
    def compared(self) -> Array:
        """Measured positions (R, M, A) [m] along the axes at the samples that are used."""
        return np.asarray(self.tracked[self.looked_at])

    @property
    def tracked(self) -> Array:
        """Measured positions (T, M, A) [m] along the axes at all samples."""
        return np.asarray(self.measured[:, :, self.axes])

    def shown(self, marker: int) -> Array:
        """Return the measured positions (S, 3) [m] of a marker at the samples in which it was visible."""
        return np.asarray(self.measured[np.isfinite(self.measured[:, marker, 0]), marker])

    @property
    def whole(self) -> Run:
        """The run with all samples used."""
        return self if self.rows is None and self.every == 1 else replace(self, rows=None, every=1)

    @cached_property
    def moved(self) -> float:
        """RMS distance [m] from its mean position of the marker that moves most."""
        seen = np.asarray(np.isfinite(self.compared).all(axis=2))
        ways = [self.compared[seen[:, m], m].var(axis=0).sum() for m in range(seen.shape[1]) if seen[:, m].any()]
        return float(np.sqrt(max(ways, default=0.0)))

    @property
    def tolerance(self) -> float:
        """Tolerance of an integration step that is small compared with the motion [m at the tip]."""
        return max(_FINE * self.moved, QUIETEST)

    @property
    def command(self) -> Array:
        """Commanded torque (T, S) [N m] of each section; (T, 1) if it is the same for all."""
        return self.torque[:, None] if self.by_section is None else self.by_section

    @property
    def drive(self) -> Array:
        """Commanded torque (T,) [N m] in the format of recordings; in space (T, 2), or (T, 2 S) for S sections."""
        if not np.iscomplexobj(self.torque):
            return self.torque
        return np.stack([self.command.real, self.command.imag], axis=2).reshape(len(self.time), -1)

    @property
    def span(self) -> float:
        """Range of the commanded torque [N m]; the largest of all sections."""
        return float(np.hypot(np.ptp(self.command.real, axis=0), np.ptp(self.command.imag, axis=0)).max())

    @cached_property
    def rest(self) -> Array:
        """Marker positions (M, 3) [m] before the first change of command; NaN for a marker that was not measured."""
        return median(self.measured[self._at_rest])

    @property
    def resting(self) -> int:
        """Number of samples before the first change of command, at most twenty."""
        changes = np.flatnonzero(np.diff(self.command, axis=0).any(axis=1))
        return min(int(changes[0]) + 1 if len(changes) else REST, REST)

    @property
    def _at_rest(self) -> slice:
        """The resting samples that are not mixed with others by a filter, if there are any."""
        half = self.smoothing.half if self.smoothing else 0
        return slice(half, self.resting - half) if self.resting > 2 * half else slice(0, self.resting)

    @property
    def name(self) -> str:
        """Name of the trial."""
        return self.trial.name

    @property
    def samples_at_rest(self) -> int:
        """Number of independent resting samples."""
        inside = self._at_rest
        rows = self.whole.looked_at if self.rows is None else self.rows
        return max(1, int(((rows >= inside.start) & (rows < inside.stop)).sum()))

    @property
    def step(self) -> float:
        """Sampling interval [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


@dataclass(frozen=True, eq=False)
class Prepared:
    """All usable trials of a dataset.

    Attributes:
        dataset: the cleaned dataset.
        runs: one run per usable trial.
        markers: (M,) markers that depend on bending (not those at the base).
        noise: (M,) standard deviation of each marker's coordinates along the axes [m].
        notes: exclusions and their reasons.
        rest_scatter: standard deviation of the farthest marker's resting position over the trials [m].
        disturbed_release: whether the release may have held the arm for a short time.
    """

    dataset: Dataset
    runs: tuple[Run, ...]
    markers: tuple[Marker, ...]
    noise: Array
    notes: tuple[str, ...] = ()
    rest_scatter: float = 0.0
    disturbed_release: bool = True

    @cached_property
    def reach(self) -> Array:
        """Arc lengths (M,) of the markers [m]."""
        return np.array([marker.arc_length for marker in self.markers])

    @property
    def axes(self) -> tuple[int, ...]:
        """Indices of the world coordinates in which the arm moves, which are compared and fitted."""
        return self.dataset.axes

    @property
    def directions(self) -> tuple[complex, ...]:
        """Directions in which the arm bends, as complex numbers: one in the plane, two in space."""
        return (1.0, 1.0j)[: len(self.axes) - 1]

    @property
    def systematic(self) -> int:
        """Number of parameters of a trial's resting position: one for each direction, none if it is constant."""
        return len(self.directions) if self.rest_scatter > 0 else 0

    def own(self, run: Run) -> int:
        """Return the number of parameters that may belong to a run instead of the arm."""
        released = 1 + len(self.directions) * (1 + self.disturbed_release * len(RELEASE_ENDS))
        return self.systematic + (0 if run.start_pose is None else released)

    @property
    def unconditional(self) -> int:
        """Number of own parameters that each run always has: resting position, initial pose and release instant."""
        return self.systematic + len(self.axes)

    @property
    def confounded(self) -> NDArray[np.bool_]:
        """Mask (K,) of the own parameters that could compensate for a missing law: resting position and release disturbance."""
        own = np.arange(self.unconditional + len(RELEASE_ENDS) * len(self.directions))
        return (own < self.systematic) | (own >= self.unconditional)

    def has_conditional(self, run: Run) -> bool:
        """Return whether the release of a run may have been disturbed."""
        return self.disturbed_release and run.start_pose is not None

    @cached_property
    def floor(self) -> Array:
        """Error floor (M,) [m] of a coordinate of each marker, from noise and from the assumed model error."""
        return np.hypot(self.noise, TRUEST * self.dataset.length)

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """One group: the markers of an arm share one variance of the model discrepancy."""
        return (tuple(range(len(self.noise))),)

    def tolerances(self, run: Run) -> Array:
        """Return no columns: stiffness and damping are fitted, and other declared numbers have no tolerances."""
        return np.zeros((*run.compared.shape, 0))

    @property
    def discrepancy(self) -> Array:
        """Zeros (M,): no inaccuracy of the declared arm is known in advance."""
        return np.zeros(len(self.noise))

    @property
    def worst(self) -> float:
        """Error that is assigned to a failed simulation [m]."""
        return self.dataset.length

    def cameras(self, batch: ArmBatch) -> Cameras:
        """Return the cameras that measure these markers on arms."""
        return Cameras(batch, self.reach, np.array([marker.offset for marker in self.markers]), fast=True)

    @cached_property
    def levels(self) -> tuple[float, ...]:
        """The declared stiffnesses [Nm/rad], in increasing order."""
        return tuple(sorted({trial.keq for trial in self.dataset.trials}))

    @property
    def noise_rms(self) -> float:
        """RMS distance [m] along the axes between model and markers that noise alone causes."""
        return float(np.sqrt(len(self.axes) * np.mean(self.noise**2)))
