"""How far the arm is from itself: trials that repeat a command or a release, compared with each other and with no model.

Of n repeats the mean square distance from their mean, times n / (n - 1), is what one trial has of its own: the difference of
two repeats holds it twice. A model that knew everything that repeats would still miss each trial by it.

Clocks are set alike first: the steps of a command to their mean instants, and each trial by the shift, of two samples at most,
that brings it nearest to what the others show.

Hands never let go of the same pose twice. What a difference of start explains is taken out first, by least squares at every
instant over the repeats, on the place (and with enough repeats the speed) at which each starts, along the direction in which the
starts differ most; each costs a degree of freedom. Where there are too few repeats for that, only releases that start alike are
compared, and what the starts differ by is told beside the result.
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
from hsr_pin.trajectory import Array

#: Two commands are the same if they differ by more than this share of their range for at most this share of the time.
_SAME, _ELSEWHERE = 0.02, 0.02
#: ... and one goes on for at least this share of the other.
_OVERLAP = 0.8
#: Two poses are alike if no marker differs by more than this share of the largest motion: where the difference of the starts can
#: be allowed for, and where it cannot.
_ALIKE, _VERY_ALIKE = 0.35, 0.1
#: A difference of start is allowed for only with so many repeats for every number that describes it.
_REPEATS_PER_REGRESSOR = 3
#: Clocks and instants of release may be off by so many samples.
_SHIFT = 2.0
#: Steps of the same command may come so much earlier or later [s] in one trial than in the mean of them.
_ASTRAY = 0.3
_ALIGNMENTS = 6
#: Fewer instants than this that all repeats show tell nothing.
_FEWEST = 5
#: Starts that differ by less than this share of what the motions differ by do not make that difference.
_NEAR = 0.5
#: Share of a run, at its end, over which a released arm is taken to rest; and samples at most of the rest before a command.
_END = 0.1
#: Probability that an interval covers.
_LEVEL = 0.95


@dataclass(frozen=True)
class Group:
    """Trials that repeat one command or one release.

    Attributes:
        kind: "command" or "release".
        trials: their names.
        keq, tip_mass: declared [Nm/rad], [kg].
        in_plane: RMS distance [m] along the axes between one of them and what they share, beyond noise.
        moving: the same with the mean place of each trial left out: what is left if rests are set alike.
        markers: (M,) as ``in_plane`` for each marker; NaN for one that is not seen in two of them.
        out_of_plane: as ``moving``, out of the plane [m].
        rest: RMS distance [m] in the plane between one trial's pose at rest and the mean of them; NaN where no rest is seen.
        shift: standard deviation [s] of the shifts in time that align them best.
        start: RMS distance [m] in the plane between one start and the mean of them; 0 where trials start settled.
        allowed_for: how many numbers that describe the start were allowed for.
        freedom: degrees of freedom, repeats less what was estimated from them.
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
        """Whether its trials start alike, or what the starts differ by was allowed for: models know the starts."""
        return self.allowed_for > 0 or self.start <= _NEAR * self.moving


@dataclass(frozen=True)
class Repeats:
    """How far the arm is from itself.

    Attributes:
        groups: of trials that repeat each other.
        in_plane: RMS distance [m] in the plane, of all groups by their degrees of freedom.
        interval: of ``in_plane`` [m], 95 %; what one trial has of its own is taken to last through the trial, so that every
            degree of freedom is one draw.
        moving, out_of_plane, rest: as in a group [m].
        floor: as ``moving``, of the groups that start alike: no model can be asked for less; None where none do [m].
        sentence: the result in words, with what was done.
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
        """Plain numbers and texts; lengths in mm."""
        return {
            "in_plane_mm": _mm(self.in_plane),
            "ci95_mm": [_mm(bound) for bound in self.interval],
            "moving_mm": _mm(self.moving),
            "floor_mm": None if self.floor is None else _mm(self.floor),
            "out_of_plane_mm": _mm(self.out_of_plane),
            "rest_mm": _mm(self.rest),
            "sentence": self.sentence,
            "groups": [
                {
                    "kind": group.kind,
                    "trials": list(group.trials),
                    "keq": group.keq,
                    "tip_mass_kg": group.tip_mass,
                    "in_plane_mm": _mm(group.in_plane),
                    "moving_mm": _mm(group.moving),
                    "markers_mm": [_mm(value) for value in group.markers],
                    "out_of_plane_mm": _mm(group.out_of_plane),
                    "rest_mm": _mm(group.rest),
                    "shift_s": group.shift,
                    "start_mm": _mm(group.start),
                    "allowed_for": group.allowed_for,
                    "freedom": group.freedom,
                }
                for group in self.groups
            ],
        }


def repeats(experiment: Experiment) -> Repeats | None:
    """What repeats in an experiment, and how well; None where nothing is repeated."""
    compared = [_compared(members, experiment) for members in alike(experiment.runs)]
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
    return Repeats(groups, in_plane, (float(low), float(high)), moving, out, rest, floor, sentence)


def alike(runs: Sequence[Run]) -> list[list[Run]]:
    """Groups of at least two runs that repeat each other: the same declared arm, command and manner of start."""
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
        if few:  # the difference of start cannot be allowed for
            group = [run for run in group if _start_distance(run, group[0]) < _VERY_ALIKE]
        if len(group) > 1:
            ready.append(group)
    return ready


def _repeats(run: Run, other: Run) -> bool:
    declared = [(r.trial.keq, r.trial.damping, r.trial.tip_mass, r.start_pose is None) for r in (run, other)]
    if declared[0] != declared[1] or run.trial.trajectory.has_input != other.trial.trajectory.has_input:
        return False
    if run.start_pose is not None and _start_distance(run, other) > _ALIKE:
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
    """Largest distance of the markers at two starts, over the largest motion of either run; infinite if none is seen at both."""
    assert run.start_pose is not None and other.start_pose is not None
    apart = np.linalg.norm((run.start_pose - other.start_pose)[:, run.axes], axis=1)
    ways = [r.compared - pose[:, run.axes] for r, pose in ((run, run.start_pose), (other, other.start_pose))]
    if not np.isfinite(apart).any():
        return np.inf
    way = max(float(np.nan_to_num(np.linalg.norm(each, axis=2)).max()) for each in ways)
    return float(np.nanmax(apart)) / max(way, 1e-12)


def _clocks(runs: Sequence[Run]) -> list[Array]:
    """For each run (T,) [s] since its start, which may lie between two samples; steps of the command at their mean instants."""
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
    """Times [s] since the start that all runs were followed through, as far apart as the samples of the first."""
    first, end = max(own[0] for own in clocks), min(own[-1] for own in clocks)
    step = (clocks[0][-1] - clocks[0][0]) / (len(clocks[0]) - 1)
    return np.asarray(first + step * np.arange(max(int((end - first) / step + 1e-9) + 1, 0)))


def _compared(runs: Sequence[Run], experiment: Experiment) -> Group | None:
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
    noise = experiment.noise**2 * kept  # per coordinate and marker, after resampling
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
    """(n, k) numbers that describe how each run starts, as many as there are repeats enough to allow for.

    First the place, then the speed, each along the direction in which the starts differ most.
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
            apart = part - part.mean(axis=0)
            along = apart @ np.linalg.svd(apart, full_matrices=False)[2][0]
            numbers.append(along / np.std(along))
    return np.stack(numbers[:most], axis=1) if numbers else np.zeros((len(runs), 0))


def _sampled(runs: Sequence[Run], clocks: Sequence[Array], times: Array) -> tuple[Array, float]:
    """(n, T, M, 3) positions [m] at ``times`` (n, T) [s], straight between samples; share of the noise's square that is left."""
    seen, kept = [], []
    for run, own, time in zip(runs, clocks, times, strict=True):
        at = np.clip(np.searchsorted(own, time, side="right") - 1, 0, len(own) - 2)
        part = (time - own[at]) / (own[at + 1] - own[at])
        part = np.where(np.abs(part - np.round(part)) < 1e-6, np.round(part), part)  # a gap beside a sample does not hide it
        weight = np.where((part >= 0) & (part <= 1), part, np.nan)[:, None, None]
        before, after = run.measured[at], run.measured[at + 1]
        seen.append(np.where(weight == 0, before, np.where(weight == 1, after, (1 - weight) * before + weight * after)))
        kept.append(np.nanmean(weight**2 + (1 - weight) ** 2))
    return np.array(seen), float(np.mean(kept))


def _own(seen: Array, design: Array) -> tuple[Array, Array]:
    """What each repeat has of its own: ``seen`` (n, T, M, 3) less what ``design`` (n, k) explains; NaN where it cannot be told.

    Also (T, M): the degrees of freedom that it has at each instant, by how many repeats are seen then.
    """
    shown = np.isfinite(seen[..., 0])  # a marker is seen or is not
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
    """(n,) [s] by how much later each repeat moves than the others do, as its motion along the axes tells."""
    told = np.isfinite(own) & np.isfinite(speed) & np.isin(np.arange(3), axes)
    v, d = (np.where(told, part, 0.0).reshape(len(own), -1) for part in (speed, own))
    return -np.asarray((d * v).sum(axis=1) / np.maximum((v * v).sum(axis=1), 1e-30))


def _mean_square(own: Array, free: Array) -> Array:
    """(M, 3) [m^2] mean square of what is left (n, T, M, 3) with (T, M) degrees of freedom; NaN where there are none."""
    total, freedom = np.nansum(own**2, axis=(0, 1)), free.sum(axis=0)[:, None]
    return np.where(freedom > 0, total / np.maximum(freedom, 1), np.nan)


def _rest_scatter(runs: Sequence[Run]) -> float:
    if runs[0].start_pose is None:
        rests = np.array([run.rest for run in runs])
    else:
        rests = np.array([_at_end(run.measured[-max(5, round(_END * len(run.time))) :]) for run in runs])
    return _scatter(rests[:, :, runs[0].axes])


def _at_end(places: Array) -> Array:
    """(M, 3) [m] median of the places (T, M, 3) that are seen; NaN of a marker that is not."""
    seen = np.isfinite(places).any(axis=0)
    return np.where(seen, np.nanmedian(np.where(seen, places, 0.0), axis=0), np.nan)


def _start_scatter(runs: Sequence[Run]) -> float:
    poses = [run.start_pose for run in runs if run.start_pose is not None]
    return _scatter(np.array(poses)[:, :, runs[0].axes]) if poses else 0.0


def _scatter(poses: Array) -> float:
    """RMS distance [m] of one of (n, M, A) poses from their mean, markers that all show; NaN without any."""
    plane = poses[:, np.isfinite(poses).all(axis=(0, 2))]
    if not plane.shape[1]:
        return float("nan")
    return float(np.sqrt(((plane - plane.mean(axis=0)) ** 2).sum(axis=(0, 2)).mean() / (len(plane) - 1)))


def _pooled(values: Sequence[float], groups: Sequence[Group]) -> float:
    """Root mean square over groups, each by its degrees of freedom."""
    known = [(value, group.freedom) for value, group in zip(values, groups, strict=True) if np.isfinite(value)]
    if not known:
        return float("nan")
    return float(np.sqrt(np.average([value**2 for value, _ in known], weights=[freedom for _, freedom in known])))


def _sentence(groups: Sequence[Group], in_plane: float, out: float, rest: float, floor: float | None) -> str:
    trials = sum(len(group.trials) for group in groups)
    of = " and ".join(sorted({f"a {group.kind}" for group in groups}))
    at_rest = f" (their poses at rest {1e3 * rest:.2g} mm)" if np.isfinite(rest) else ""
    text = (
        f"{trials} trials in {len(groups)} group{'s' * (len(groups) > 1)} repeat {of}: one is {1e3 * in_plane:.2g} mm from what "
        f"its group shares, {'in the plane and ' * bool(np.isfinite(out))}beyond noise{at_rest}"
    )
    if floor is not None:
        text += f"; while it moves, no model can be asked for less than {1e3 * floor:.2g} mm"
    if any(group.allowed_for for group in groups):
        text += "; differences of the start are allowed for by regression"
    elif any(group.start > 0 for group in groups):
        text += f"; the starts differ by {1e3 * max(group.start for group in groups):.2g} mm, which is not allowed for"
    return f"{text}. Out of the plane it is {1e3 * out:.2g} mm." if np.isfinite(out) else f"{text}."


def _root(square: float) -> float:
    return float(np.sqrt(max(square, 0.0))) if np.isfinite(square) else float("nan")


def _mm(value: float) -> float | None:
    return 1e3 * value if np.isfinite(value) else None
