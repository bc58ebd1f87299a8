"""Trial-to-trial repeatability: trials that repeat a command or a release are compared with each other, without a model.

For n repetitions, the mean square distance from their mean, multiplied by n / (n - 1), is the scatter of a single trial. A model
that knows everything that repeats would still have this error.

The time axes are aligned first: the steps of a command to their mean times, and each trial by the shift of at most two samples
that brings it closest to the others.

The initial poses of releases differ. The influence of the initial pose, and with enough repetitions of the initial velocity,
along the direction of the largest differences is removed by least squares at every time; each costs one degree of freedom. With
too few repetitions, only releases with nearly equal initial poses are compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import gammaincinv

from hsr_pin.diagnosis.commands import steps
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.document import millimetres_or_null
from hsr_pin.trajectory import Array

#: Two commands are equal if they differ by more than the first share of their range for at most the second share of the time ...
_SAME, _ELSEWHERE = 0.02, 0.02
#: ... and the shorter one lasts for at least this share of the longer one.
_OVERLAP = 0.8
#: Two initial poses are equal if no marker differs by more than this share of the largest motion: if their difference can be
#: corrected by regression, and if not.
_START_TOLERANCE, _START_TOLERANCE_UNMODELLED = 0.35, 0.1
#: Number of repetitions needed for every parameter of the initial state that is corrected.
_REPEATS_PER_REGRESSOR = 3
#: Largest error of clocks and release times, in samples.
_SHIFT = 2.0
#: Largest deviation of the time of a step in one trial from its mean time [s].
_ASTRAY = 0.3
_ALIGNMENTS = 6
#: Least number of common samples of a group.
_FEWEST = 5
#: Differences of the initial poses below this share of the differences of the motion do not explain the latter.
_NEAR = 0.5
#: Share of a run, at its end, in which a released arm is assumed to be in equilibrium.
_END = 0.1
#: Coverage probability of the intervals.
_LEVEL = 0.95


@dataclass(frozen=True)
class Group:
    """Trials that repeat one command or one release.

    Attributes:
        kind: "command" or "release".
        trials: names of the trials.
        keq, tip_mass: declared stiffness [Nm/rad] and payload [kg].
        in_plane: RMS distance along the axes between one trial and the mean of the group, beyond noise [m].
        moving: the same after removing the mean position of each trial, that is, the scatter apart from the equilibrium [m].
        markers: (M,) as ``in_plane`` for each marker [m]; NaN for a marker that was not visible in two trials.
        out_of_plane: as ``moving``, out of the plane [m].
        rest: RMS distance in the plane between the equilibrium pose of one trial and the mean pose [m]; NaN if there is none.
        shift: standard deviation of the time shifts that align the trials [s].
        start: RMS distance in the plane between one initial pose and the mean [m]; 0 if trials start in equilibrium.
        allowed_for: number of parameters of the initial state whose influence was removed.
        freedom: degrees of freedom: number of trials minus the number of estimated parameters.
    """

    kind: str
    trials: tuple[str, ...]
    keq: float
    tip_mass: float
    in_plane: float
    moving: float
    markers: tuple[float, ...]
    out_of_plane: float
    rest: float
    shift: float
    start: float
    allowed_for: int
    freedom: int

    @property
    def from_one_start(self) -> bool:
        """Whether the trials have nearly equal initial poses, or their differences were removed; models know these poses."""
        return self.allowed_for > 0 or self.start <= _NEAR * self.moving


@dataclass(frozen=True)
class Repeatability:
    """Trial-to-trial scatter of the arm.

    Attributes:
        groups: groups of trials that repeat each other.
        in_plane: RMS scatter in the plane, pooled over the groups by their degrees of freedom [m].
        interval: 95 % interval of ``in_plane`` [m], where each degree of freedom counts as one observation.
        moving, out_of_plane, rest: pooled values of the groups [m].
        floor: ``moving`` of the groups with equal initial poses, a limit for any model [m]; None without any.
        sentence: summary of the result.
    """

    groups: tuple[Group, ...]
    in_plane: float
    interval: tuple[float, float]
    moving: float
    out_of_plane: float
    rest: float
    floor: float | None
    sentence: str

    def to_json(self) -> dict[str, Any]:
        """Return plain numbers and texts; lengths in mm."""
        return {
            "in_plane_mm": millimetres_or_null(self.in_plane),
            "ci95_mm": [millimetres_or_null(bound) for bound in self.interval],
            "moving_mm": millimetres_or_null(self.moving),
            "floor_mm": None if self.floor is None else millimetres_or_null(self.floor),
            "out_of_plane_mm": millimetres_or_null(self.out_of_plane),
            "rest_mm": millimetres_or_null(self.rest),
            "sentence": self.sentence,
            "groups": [
                {
                    "kind": group.kind,
                    "trials": list(group.trials),
                    "keq": group.keq,
                    "tip_mass_kg": group.tip_mass,
                    "in_plane_mm": millimetres_or_null(group.in_plane),
                    "moving_mm": millimetres_or_null(group.moving),
                    "markers_mm": [millimetres_or_null(value) for value in group.markers],
                    "out_of_plane_mm": millimetres_or_null(group.out_of_plane),
                    "rest_mm": millimetres_or_null(group.rest),
                    "shift_s": group.shift,
                    "start_mm": millimetres_or_null(group.start),
                    "allowed_for": group.allowed_for,
                    "freedom": group.freedom,
                }
                for group in self.groups
            ],
        }


def repeatability(experiment: Experiment) -> Repeatability | None:
    """Return the trial-to-trial scatter of an experiment; None if no trials repeat one another."""
    compared = [_compared(members, experiment) for members in repeated_groups(experiment.runs)]
    groups = tuple(group for group in compared if group is not None)
    if not groups:
        return None
    freedom = sum(group.freedom for group in groups)
    in_plane = _pooled([group.in_plane for group in groups], groups)
    low, high = (in_plane * np.sqrt(freedom / (2 * gammaincinv(freedom / 2, p))) for p in ((1 + _LEVEL) / 2, (1 - _LEVEL) / 2))
    moving, out, rest = (_pooled([getattr(g, name) for g in groups], groups) for name in ("moving", "out_of_plane", "rest"))
    fair = [group for group in groups if group.from_one_start]
    floor = _pooled([group.moving for group in fair], fair) if fair else None
    sentence = _sentence(groups, in_plane, out, rest, floor)
    return Repeatability(groups, in_plane, (float(low), float(high)), moving, out, rest, floor, sentence)


def repeated_groups(runs: Sequence[Run]) -> list[list[Run]]:
    """Return groups of at least two runs with the same declared arm, the same command and the same kind of start."""
    groups: list[list[Run]] = []
    for run in runs:
        home = next((group for group in groups if all(_repeats(run, other) for other in group)), None)
        if home is None:
            groups.append([run])
        else:
            home.append(run)
    ready = []
    for group in groups:
        few = len(group) < 1 + _REPEATS_PER_REGRESSOR and group[0].start_pose is not None
        if few:  # the differences of the initial poses cannot be corrected
            group = [run for run in group if _start_distance(run, group[0]) < _START_TOLERANCE_UNMODELLED]
        if len(group) > 1:
            ready.append(group)
    return ready


def _repeats(run: Run, other: Run) -> bool:
    """Return whether two runs repeat the same command or release."""
    declared = [(r.trial.keq, r.trial.damping, r.trial.tip_mass, r.start_pose is None) for r in (run, other)]
    if declared[0] != declared[1] or run.trial.trajectory.has_input != other.trial.trajectory.has_input:
        return False
    if run.start_pose is not None and _start_distance(run, other) > _START_TOLERANCE:
        return False
    if not run.trial.trajectory.has_input:
        return True
    clocks = _clocks([run, other])
    time = _grid(clocks)
    if len(time) < _OVERLAP * max(len(run.time), len(other.time)):
        return False
    commands = [
        r.command[np.clip(np.searchsorted(own, time, side="right") - 1, 0, None)]
        for r, own in zip((run, other), clocks, strict=True)
    ]
    both = np.concatenate(commands)
    span = max(float(np.hypot(np.ptp(both.real, axis=0), np.ptp(both.imag, axis=0)).max()), 1e-12)
    return bool(np.mean(np.abs(commands[0] - commands[1]).max(axis=1) > _SAME * span) < _ELSEWHERE)


def _start_distance(run: Run, other: Run) -> float:
    """Return the largest marker distance of two initial poses over the largest motion; infinite without common markers."""
    assert run.start_pose is not None and other.start_pose is not None
    distance = np.linalg.norm((run.start_pose - other.start_pose)[:, run.axes], axis=1)
    ways = [r.compared - pose[:, run.axes] for r, pose in ((run, run.start_pose), (other, other.start_pose))]
    if not np.isfinite(distance).any():
        return np.inf
    way = max(float(np.nan_to_num(np.linalg.norm(each, axis=2)).max()) for each in ways)
    return float(np.nanmax(distance)) / max(way, 1e-12)


def _clocks(runs: Sequence[Run]) -> list[Array]:
    """Return for each run the aligned times (T,) since its start [s], with the steps of the command at their mean times."""
    own = [np.asarray(run.time - run.time[0] + run.lead * run.step) for run in runs]
    instants = [np.array([step.instant for step in steps(run)]) - run.time[0] for run in runs]
    if len({len(each) for each in instants}) > 1 or not len(instants[0]):
        return own
    together = np.mean(instants, axis=0)
    if np.any(np.abs(np.array(instants) - together) > _ASTRAY):
        return own
    clocks = []
    for time, each in zip(own, instants, strict=True):
        later = np.interp(time, [0.0, *each], [0.0, *(together - each)])
        clocks.append(np.asarray(time + later))
    return clocks


def _grid(clocks: Sequence[Array]) -> Array:
    """Return the common times of all runs since their start [s], at the sampling interval of the first run."""
    first, end = max(own[0] for own in clocks), min(own[-1] for own in clocks)
    step = (clocks[0][-1] - clocks[0][0]) / (len(clocks[0]) - 1)
    return np.asarray(first + step * np.arange(max(int((end - first) / step + 1e-9) + 1, 0)))


def _compared(runs: Sequence[Run], experiment: Experiment) -> Group | None:
    """Return the scatter within a group of runs; None if there are too few runs or samples."""
    starts, clocks = _starts(runs), _clocks(runs)
    time, design = _grid(clocks), np.hstack([np.ones((len(runs), 1)), starts])
    freedom = len(runs) - design.shape[1]
    if freedom < 1 or len(time) < _FEWEST:
        return None
    axes, flat = runs[0].axes, len(runs[0].axes) == 2
    shifts, most = np.zeros(len(runs)), _SHIFT * runs[0].step
    for _ in range(_ALIGNMENTS):
        seen, _ = _sampled(runs, clocks, time + shifts[:, None])
        own, _ = _own(seen, design)
        shifts = shifts + _late(own, np.gradient(seen - own, runs[0].step, axis=1), axes)
        shifts = np.clip(shifts - shifts.mean(), -most, most)
    seen, kept = _sampled(runs, clocks, time + shifts[:, None])
    own, free = _own(seen, design)
    noise = experiment.noise**2 * kept  # for each marker, in one coordinate, after resampling
    squares = _mean_square(own, free)
    around = _mean_square(own - np.nanmean(own, axis=1, keepdims=True), free)
    known = np.isfinite(squares[:, 0])
    plane = squares[:, axes].sum(axis=1) - len(axes) * noise
    return Group(
        kind="command" if runs[0].trial.trajectory.has_input else "release",
        trials=tuple(run.trial.name for run in runs),
        keq=runs[0].trial.keq,
        tip_mass=runs[0].trial.tip_mass,
        in_plane=_root(float(np.mean(plane[known]))),
        moving=_root(float(np.mean((around[:, axes].sum(axis=1) - len(axes) * noise)[known]))),
        markers=tuple(_root(float(square)) for square in plane),
        out_of_plane=_root(float(np.mean((around[:, 1] - noise)[known]))) if flat else float("nan"),
        rest=_rest_scatter(runs),
        shift=float(np.std(shifts, ddof=1)),
        start=_start_scatter(runs),
        allowed_for=starts.shape[1],
        freedom=freedom,
    )


def _starts(runs: Sequence[Run]) -> Array:
    """Return (n, k) parameters of the initial states, as many as the number of repetitions permits.

    The first is the position, the second the velocity, each along the direction of the largest differences.
    """
    most = (len(runs) - 1) // _REPEATS_PER_REGRESSOR
    if runs[0].start_pose is None or most < 1:
        return np.zeros((len(runs), 0))
    poses = np.array([run.start_pose[:, run.axes].ravel() for run in runs if run.start_pose is not None])
    speeds = np.array(
        [np.zeros(poses.shape[1]) if r.start_velocity is None else r.start_velocity[:, r.axes].ravel() for r in runs]
    )
    numbers = []
    for part in (poses, speeds):
        part = part[:, np.isfinite(part).all(axis=0)]
        if part.shape[1] and np.any(np.ptp(part, axis=0) > 1e-9):
            centred = part - part.mean(axis=0)
            along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
            numbers.append(along / np.std(along))
    return np.stack(numbers[:most], axis=1) if numbers else np.zeros((len(runs), 0))


def _sampled(runs: Sequence[Run], clocks: Sequence[Array], times: Array) -> tuple[Array, float]:
    """Return positions (n, T, M, 3) [m] interpolated at ``times`` (n, T) [s], and the share of noise variance that is left."""
    seen, kept = [], []
    for run, own, time in zip(runs, clocks, times, strict=True):
        at = np.clip(np.searchsorted(own, time, side="right") - 1, 0, len(own) - 2)
        part = (time - own[at]) / (own[at + 1] - own[at])
        part = np.where(np.abs(part - np.round(part)) < 1e-6, np.round(part), part)  # a gap next to a sample does not remove it
        weight = np.where((part >= 0) & (part <= 1), part, np.nan)[:, None, None]
        before, after = run.measured[at], run.measured[at + 1]
        seen.append(np.where(weight == 0, before, np.where(weight == 1, after, (1 - weight) * before + weight * after)))
        kept.append(np.nanmean(weight**2 + (1 - weight) ** 2))
    return np.array(seen), float(np.mean(kept))


def _own(seen: Array, design: Array) -> tuple[Array, Array]:
    """Return the deviations of repetitions, ``seen`` (n, T, M, 3) minus what ``design`` (n, k) explains; NaN if undetermined.

    Also return their degrees of freedom (T, M), which depend on the number of visible repetitions.
    """
    shown = np.isfinite(seen[..., 0])  # all coordinates of a marker are visible, or none
    patterns, which = np.unique(shown.reshape(len(seen), -1), axis=1, return_inverse=True)
    values = seen.reshape(len(seen), -1, 3)
    own, free = np.full_like(values, np.nan), np.zeros(values.shape[1])
    for number, pattern in enumerate(patterns.T):
        known = design[pattern]
        if len(known) > design.shape[1]:
            places = np.flatnonzero(which.ravel() == number)
            rows = np.ix_(pattern, places)
            own[rows] = values[rows] - np.tensordot(known @ np.linalg.pinv(known), values[rows], axes=1)
            free[places] = len(known) - design.shape[1]
    return own.reshape(seen.shape), free.reshape(seen.shape[1:3])


def _late(own: Array, speed: Array, axes: tuple[int, ...]) -> Array:
    """Return by how much each repetition lags behind the others (n,) [s], estimated from its motion along the axes."""
    known = np.isfinite(own) & np.isfinite(speed) & np.isin(np.arange(3), axes)
    v, d = (np.where(known, part, 0.0).reshape(len(own), -1) for part in (speed, own))
    return -np.asarray((d * v).sum(axis=1) / np.maximum((v * v).sum(axis=1), 1e-30))


def _mean_square(own: Array, free: Array) -> Array:
    """Return the mean square (M, 3) [m^2] of deviations (n, T, M, 3) with (T, M) degrees of freedom; NaN where there are none."""
    total, freedom = np.nansum(own**2, axis=(0, 1)), free.sum(axis=0)[:, None]
    return np.where(freedom > 0, total / np.maximum(freedom, 1), np.nan)


def _rest_scatter(runs: Sequence[Run]) -> float:
    """Return the RMS scatter of the equilibrium poses of some runs [m]."""
    if runs[0].start_pose is None:
        rests = np.array([run.rest for run in runs])
    else:
        rests = np.array([_at_end(run.measured[-max(5, round(_END * len(run.time))) :]) for run in runs])
    return _scatter(rests[:, :, runs[0].axes])


def _at_end(places: Array) -> Array:
    """Return the median (M, 3) [m] of the visible positions (T, M, 3); NaN for a marker that is never visible."""
    seen = np.isfinite(places).any(axis=0)
    return np.where(seen, np.nanmedian(np.where(seen, places, 0.0), axis=0), np.nan)


def _start_scatter(runs: Sequence[Run]) -> float:
    """Return the RMS scatter of the initial poses of some runs [m]."""
    poses = [run.start_pose for run in runs if run.start_pose is not None]
    return _scatter(np.array(poses)[:, :, runs[0].axes]) if poses else 0.0


def _scatter(poses: Array) -> float:
    """Return the RMS distance [m] of poses (n, M, A) from their mean, for markers visible in all of them; NaN without any."""
    plane = poses[:, np.isfinite(poses).all(axis=(0, 2))]
    if not plane.shape[1]:
        return float("nan")
    return float(np.sqrt(((plane - plane.mean(axis=0)) ** 2).sum(axis=(0, 2)).mean() / (len(plane) - 1)))


def _pooled(values: Sequence[float], groups: Sequence[Group]) -> float:
    """Return the root mean square over groups, weighted by their degrees of freedom."""
    known = [(value, group.freedom) for value, group in zip(values, groups, strict=True) if np.isfinite(value)]
    if not known:
        return float("nan")
    return float(np.sqrt(np.average([value**2 for value, _ in known], weights=[freedom for _, freedom in known])))


def _sentence(groups: Sequence[Group], in_plane: float, out: float, rest: float, floor: float | None) -> str:
    trials = sum(len(group.trials) for group in groups)
    of = " and ".join(sorted({f"a {group.kind}" for group in groups}))
    at_rest = f" (equilibrium poses: {1e3 * rest:.2g} mm)" if np.isfinite(rest) else ""
    text = (
        f"{trials} trials in {len(groups)} group{'s' * (len(groups) > 1)} repeat {of}: the trial-to-trial scatter is "
        f"{1e3 * in_plane:.2g} mm{' in the plane' * bool(np.isfinite(out))}, beyond noise{at_rest}"
    )
    if floor is not None:
        text += f"; during motion, it limits the accuracy of any model to {1e3 * floor:.2g} mm"
    if any(group.allowed_for for group in groups):
        text += "; differences of the initial state are corrected by regression"
    elif any(group.start > 0 for group in groups):
        text += f"; the initial poses differ by {1e3 * max(group.start for group in groups):.2g} mm, which is not corrected"
    return f"{text}. Out of the plane, the scatter is {1e3 * out:.2g} mm." if np.isfinite(out) else f"{text}."


def _root(square: float) -> float:
    return float(np.sqrt(max(square, 0.0))) if np.isfinite(square) else float("nan")
