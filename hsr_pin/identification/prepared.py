"""Recordings of an arm that are ready to be compared with simulations."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hsr_pin.identification.nuisance import LETS_GO
from hsr_pin.identification.release import median
from hsr_pin.identification.smoothing import Filter
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered
from hsr_pin.trajectory import Array, Dataset, Marker, Trial

#: Markers nearer to the base than this share of the length do not tell anything about bending.
BASE = 0.02
#: Samples at most over which the pose at rest is averaged.
REST = 20
#: No recording is less noisy than this [m].
QUIETEST = 1e-6
#: Share of what a run moves that a step of integration may be in error by.
_FINE = 0.02
#: No model of an arm is truer than this share of its length: markers that are seen with less noise than that weigh the same.
TRUEST = 5e-4


@dataclass(frozen=True, eq=False)
class Run:
    """One trial as the model must reproduce it.

    Attributes:
        trial: where it comes from.
        time: (T,) [s] of the measured samples, from the start on.
        torque: (T,) [N m] commanded: tau, or Eqs. (4) and (5) with the declared Keq; zeros for a release. In space complex:
            towards x, and towards y of the base. Of an arm of sections the mean along it, where one number has to stand for all.
        measured: (T, M, 3) [m]; NaN in gaps.
        start_pose: (M, 3) [m] where the markers are at the start; None: settled under the first torque.
        lead: fraction of a sample by which the motion starts before ``time[0]`` (a release between two samples).
        start_velocity: (M, 3) [m/s] of the markers at the start; None: at rest.
        interpolated: the torque goes straight from sample to sample instead of being held.
        axes: the world's coordinates in which the arm moves.
        by_section: (T, S) [N m] commanded, complex, of an arm of S > 1 sections; None: the same for all.
        place: in the session, from 0 for the first of its trials to 1 for the last.
        every: only one in so many of the samples that count is looked at.
        rows: (R,) the samples that count: those that are new, and whose noise is independent; None: all.
        smoothing: the filter that its markers went through; None: none.
        found_poses: the pose at the start, its rate and its modes, by model: for others of its values the search begins there.
        declared: the arm as the trial declares it, by chain.
        delivered: what arrives of the command where no muscle changes it, by whether a curve is taken as one.
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
        """(R,) indices of the samples that are looked at."""
        return np.asarray((np.arange(len(self.time)) if self.rows is None else self.rows)[:: self.every])

    @property
    def instants(self) -> Array:
        """(R,) [s] of these."""
        return np.asarray(self.time[self.looked_at])

    @cached_property
    def compared(self) -> Array:
        """(R, M, A) [m] what was measured along the axes, of the samples that are looked at."""
        return np.asarray(self.tracked[self.looked_at])

    @property
    def tracked(self) -> Array:
        """(T, M, A) [m] what was measured along the axes."""
        return np.asarray(self.measured[:, :, self.axes])

    @property
    def whole(self) -> Run:
        """The same with all samples looked at."""
        return self if self.rows is None and self.every == 1 else replace(self, rows=None, every=1)

    @cached_property
    def moved(self) -> float:
        """RMS way [m] about its mean place of the marker that goes farthest."""
        seen = np.asarray(np.isfinite(self.compared).all(axis=2))
        ways = [self.compared[seen[:, m], m].var(axis=0).sum() for m in range(seen.shape[1]) if seen[:, m].any()]
        return float(np.sqrt(max(ways, default=0.0)))

    @property
    def tolerance(self) -> float:
        """Error of a step [m at the tip] that is small beside what moves."""
        return max(_FINE * self.moved, QUIETEST)

    @property
    def command(self) -> Array:
        """(T, S) [N m] what drives each section; where all are driven alike (T, 1)."""
        return self.torque[:, None] if self.by_section is None else self.by_section

    @property
    def drive(self) -> Array:
        """(T,) [N m] the torque as recordings have it; in space (T, 2), or (T, 2 S) for S sections."""
        if not np.iscomplexobj(self.torque):
            return self.torque
        return np.stack([self.command.real, self.command.imag], axis=2).reshape(len(self.time), -1)

    @property
    def span(self) -> float:
        """How far the torque goes from its one end to the other [N m]; the farthest of the sections'."""
        return float(np.hypot(np.ptp(self.command.real, axis=0), np.ptp(self.command.imag, axis=0)).max())

    @cached_property
    def rest(self) -> Array:
        """(M, 3) [m] where the markers are before the first change of command; NaN for one that is not seen."""
        return median(self.measured[self._at_rest])

    @property
    def resting(self) -> int:
        """Samples before the first change of command, twenty at most."""
        changes = np.flatnonzero(np.diff(self.command, axis=0).any(axis=1))
        return min(int(changes[0]) + 1 if len(changes) else REST, REST)

    @property
    def _at_rest(self) -> slice:
        """Those of these that a filter did not mix with others, if there are any."""
        half = self.smoothing.half if self.smoothing else 0
        return slice(half, self.resting - half) if self.resting > 2 * half else slice(0, self.resting)

    @property
    def name(self) -> str:
        """Of the trial."""
        return self.trial.name

    @property
    def samples_at_rest(self) -> int:
        """How many independent samples these are."""
        inside = self._at_rest
        rows = self.whole.looked_at if self.rows is None else self.rows
        return max(1, int(((rows >= inside.start) & (rows < inside.stop)).sum()))

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


@dataclass(frozen=True, eq=False)
class Prepared:
    """All usable trials of a dataset.

    Attributes:
        dataset: cleaned.
        runs: one per usable trial.
        markers: (M,) those that tell about bending (not the base's).
        noise: (M,) [m] noise floor: standard deviation of each marker's coordinates along the axes.
        notes: what was left out and why.
        rest_scatter: [m] standard deviation, over the trials, of where the farthest marker rests.
        hand: whether what let the arm go may have held it a little longer.
    """

    dataset: Dataset
    runs: tuple[Run, ...]
    markers: tuple[Marker, ...]
    noise: Array
    notes: tuple[str, ...] = ()
    rest_scatter: float = 0.0
    hand: bool = True

    @cached_property
    def reach(self) -> Array:
        """(M,) [m] arc lengths of the markers."""
        return np.array([marker.arc_length for marker in self.markers])

    @property
    def axes(self) -> tuple[int, ...]:
        """The world's coordinates in which the arm moves: what is compared, and fitted to."""
        return self.dataset.axes

    @property
    def directions(self) -> tuple[complex, ...]:
        """In which the arm bends: as numbers, one in the plane, two in space."""
        return (1.0, 1.0j)[: len(self.axes) - 1]

    @property
    def lasting(self) -> int:
        """How many numbers say where the arm rests in a trial: one for each direction, none where it always rests alike."""
        return len(self.directions) if self.rest_scatter > 0 else 0

    def own(self, run: Run) -> int:
        """How many numbers may belong to a run and not to the arm."""
        released = 1 + len(self.directions) * (1 + self.hand * len(LETS_GO))
        return self.lasting + (0 if run.start_pose is None else released)

    @property
    def seen(self) -> int:
        """How many of its own numbers a run has in any case: where it rests, and how and when it was let go."""
        return self.lasting + len(self.axes)

    @property
    def doubted(self) -> NDArray[np.bool_]:
        """(K,) those that could stand in for what a model lacks: where a trial rests, and the hold of a hand."""
        own = np.arange(self.seen + len(LETS_GO) * len(self.directions))
        return (own < self.lasting) | (own >= self.seen)

    def shown(self, run: Run) -> bool:
        """Whether a hand may have held the arm of a run a little longer."""
        return self.hand and run.start_pose is not None

    @cached_property
    def floor(self) -> Array:
        """(M,) [m] what noise and the truest of models leave of a coordinate of each marker."""
        return np.hypot(self.noise, TRUEST * self.dataset.length)

    @property
    def worst(self) -> float:
        """[m] what a failed simulation counts as."""
        return self.dataset.length

    def cameras(self, columns: Columns) -> Cameras:
        """What is seen of arms with these markers."""
        return Cameras(columns, self.reach, np.array([marker.beside for marker in self.markers]), fast=True)

    @cached_property
    def levels(self) -> tuple[float, ...]:
        """The declared stiffnesses [Nm/rad], the softest first."""
        return tuple(sorted({trial.keq for trial in self.dataset.trials}))

    @property
    def noise_rms(self) -> float:
        """RMS distance [m] along the axes that noise alone leaves between model and markers."""
        return float(np.sqrt(len(self.axes) * np.mean(self.noise**2)))
