"""Initial estimates and fits of change hypotheses, to the residuals that the reference recording does not predict."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.diagnosis.change.frame import Frame
from hsr_pin.diagnosis.change.hypotheses import ChangeHypothesis
from hsr_pin.identification.evaluation import FRACTION, simulate_run
from hsr_pin.parallel import Shared, run, with_shared
from hsr_pin.trajectory import Array

#: Number of start points, without and with shape parameters, and their least distance from the bounds [scales].
_STARTS, _SHAPES, _INSIDE = 2, 3, 0.2
#: Range of factors on the size of a probe in an initial estimate, which covers the distance to the next probe.
_BETWEEN = (0.6, 1.6)
#: Relative tolerance of cost and values, and largest number of evaluations.
_DONE, _EVALUATIONS = 1e-3, 15


@dataclass(frozen=True, eq=False)
class InitialEstimate:
    """Start points of the fit of a change.

    Attributes:
        change: the change hypothesis.
        starts: start points (K,) of its open values, the most promising first.
        square: predicted sum of squared residuals of the best one.
    """

    change: ChangeHypothesis
    starts: tuple[Array, ...]
    square: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fitted change.

    Attributes:
        change: the change hypothesis.
        after: (K,) open values in the current recording.
        residual: (n,) whitened residuals of both recordings.
        slopes: (n, K) derivatives of the residuals.
        moved: for each run of the current recording (B, M, A) influence of the change on the prediction [m].
    """

    change: ChangeHypothesis
    after: Array
    residual: Array
    slopes: Array
    moved: tuple[Array, ...]

    @property
    def square(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)

    @property
    def rms(self) -> float:
        """RMS distance by which the change moves the markers of the current recording [m]."""
        return _rms(self.moved)

    def distance_to(self, other: Fitted) -> float:
        """Return the RMS distance between the influences of two changes on the current recording [m]."""
        return _rms([one - two for one, two in zip(self.moved, other.moved, strict=True)])


def _rms(moved: Sequence[Array]) -> float:
    axes = moved[0].shape[2]
    return float(np.sqrt(axes * np.mean(np.concatenate([each.ravel() for each in moved]) ** 2)))


def moved(frame: Frame, change: ChangeHypothesis, changed: Array, runs: Sequence[int], *, fine: bool = False) -> list[Array]:
    """Return the influence of a change on the prediction, relative to the reference values, for some runs (B, M, A, C) [m].

    ``changed`` (C, K) are the open values. All columns use the time steps that the first one needs. A delay shifts the measured
    motion, not that of the model.
    """
    experiment = frame.pair.experiment
    late, changed = change.delays(changed)
    points = np.vstack([change.values(changed), change.before])
    model = change.hypothesis if fine else change.hypothesis.rough
    found = []
    for k in runs:
        seen = np.moveaxis(simulate_run(experiment, experiment.runs[k], model, points).positions[..., experiment.axes], 1, -1)
        seen = np.nan_to_num(seen, nan=experiment.dataset.length)
        found.append(frame.pair.bins[k](seen[..., :-1] - seen[..., -1:]) + (frame.pair.later(k, late) if late.any() else 0.0))
    return found


def initial_estimates(frame: Frame, change: ChangeHypothesis, assumed: Fitted | None = None) -> InitialEstimate | None:
    """Return the best probes of a change, each scaled to its best size; None if none can be simulated.

    ``assumed`` is a change that is assumed already: ``change`` then combines it with another one, whose probes are used.
    """
    known = np.empty(0) if assumed is None else assumed.after
    places = change.probes.reshape(-1, change.probes.shape[-1])
    probes = np.column_stack([np.tile(known, (len(places), 1)), places])
    start = np.append(known, change.start[len(known) :])
    columns = frame.change(moved(frame, change, np.vstack([start, probes]), frame.pair.new_runs))
    residual = frame.seen + columns[:, 0]
    columns = columns[:, 1:] - columns[:, :1]
    if change.probes.ndim == 3:
        return _added_up(change, start, probes, residual, columns)
    low, high = _bounds(change)
    squares = (columns**2).sum(axis=0)
    usable = np.isfinite(squares) & (squares > 1e-9)
    with np.errstate(invalid="ignore", divide="ignore"):
        factors = np.clip(-(columns.T @ residual) / squares, *_BETWEEN)
    left = ((residual[:, None] + factors * columns) ** 2).sum(axis=0)
    sized = np.array(change.sizes)
    sized[: len(known)] = False
    starts: dict[object, Array] = {}
    order = [int(c) for c in np.argsort(left) if usable[c]]
    for c in order:  # a local defect is fitted at several positions; a change without shape parameters at two sizes
        shape = tuple(probes[c][len(known) :][~sized[len(known) :]])[:1] or c
        starts.setdefault(shape, np.where(sized, np.clip(start + factors[c] * (probes[c] - start), low, high), probes[c]))
    if not order:
        return None
    return InitialEstimate(
        change, tuple(starts.values())[: _STARTS if sized[len(known) :].all() else _SHAPES], float(left[order[0]])
    )


def _added_up(change: ChangeHypothesis, start: Array, probes: Array, residual: Array, columns: Array) -> InitialEstimate | None:
    """Return the best linear combinations of probes (C, K) along the axes, from residuals (n,) and their changes (n, C)."""
    found, axes = [], change.probes.shape[-1]
    for first in range(0, len(probes), axes):
        chosen = slice(first, first + axes)
        if not np.isfinite(columns[:, chosen]).all():
            continue
        weights = np.linalg.lstsq(columns[:, chosen], -residual, rcond=1e-6)[0]
        weights *= min(1.0, _BETWEEN[1] / max(float(np.linalg.norm(weights)), 1e-12))
        values = np.clip(start + weights @ (probes[chosen] - start), *_bounds(change))
        found.append((float(((residual + columns[:, chosen] @ weights) ** 2).sum()), values))
    found.sort(key=lambda each: each[0])
    return InitialEstimate(change, tuple(values for _, values in found[:_STARTS]), found[0][0]) if found else None


def _bounds(change: ChangeHypothesis) -> tuple[Array, Array]:
    """Return the lower and upper bounds (K,) of the open values."""
    low, high = (np.array([getattr(fact, side) for fact in change.facts]) for side in ("lower", "upper"))
    return low, high


def refined(frame: Frame, estimate: InitialEstimate, *, fine: bool = False) -> Fitted:
    """Return the best fit from the start points of an initial estimate."""
    change, runs = estimate.change, frame.pair.new_runs
    scale = np.array([fact.scale for fact in change.facts])
    lower, upper = (bound / scale for bound in _bounds(change))
    known: dict[bytes, tuple[Array, Array, list[Array]]] = {}

    def at(x: Array) -> tuple[Array, Array, list[Array]]:
        if x.tobytes() not in known:
            ahead = np.where(x + 2 * FRACTION <= upper, 2 * FRACTION, -2 * FRACTION)
            delta = moved(frame, change, np.vstack([x, x + np.diag(ahead)]) * scale, runs, fine=fine)
            chords = [np.concatenate([d[..., :1], (d[..., 1:] - d[..., :1]) / ahead], axis=-1) for d in delta]
            rows = frame.change(chords)
            known[x.tobytes()] = frame.seen + rows[:, 0], rows[:, 1:], [d[..., 0] for d in delta]
        return known[x.tobytes()]

    answers = []
    for start in estimate.starts:
        inside = np.minimum(_INSIDE, 0.4 * (upper - lower))
        x = np.clip(start / scale, lower + inside, upper - inside)  # a fit that starts at a bound hardly leaves it
        answers.append(
            least_squares(
                lambda x: at(x)[0],
                x,
                jac=lambda x: at(x)[1],
                bounds=(lower, upper),
                ftol=_DONE,
                xtol=_DONE,
                max_nfev=_EVALUATIONS,
            )
        )
    best = min(answers, key=lambda answer: float(answer.cost))
    residual, slopes, delta = at(best.x)
    return Fitted(change, np.asarray(best.x * scale), residual, slopes / scale, tuple(delta))


class ChangeFitPool:
    """Pool that fits many change hypotheses in parallel.

    Args:
        frame: the whitened residuals.
        executor: executor that runs the fits.
    """

    def __init__(self, frame: Frame, executor: Executor) -> None:
        self._shared, self._executor = Shared(frame), executor

    def initial_estimates(
        self, change_hypotheses: Sequence[ChangeHypothesis], assumed: Fitted | None = None
    ) -> list[InitialEstimate]:
        """Return the initial estimates of the changes that can be simulated, the most promising first."""
        answers = run(
            self._executor, with_shared, [(self._shared, initial_estimates, each, assumed) for each in change_hypotheses]
        )
        return sorted((estimate for estimate in answers if estimate is not None), key=lambda estimate: estimate.square)

    def refined(self, estimates: Sequence[InitialEstimate]) -> list[Fitted]:
        """Return the fits from initial estimates, the best first."""
        answers = run(self._executor, with_shared, [(self._shared, refined, estimate) for estimate in estimates])
        return sorted(answers, key=lambda fitted: fitted.square)
