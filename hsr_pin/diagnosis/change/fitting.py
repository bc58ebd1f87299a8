"""How much of the difference a change explains: tried at a few sizes, then fitted to what OLD does not foretell of NEW."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.diagnosis.change.frame import Frame
from hsr_pin.diagnosis.change.suspects import Suspect
from hsr_pin.identification.evaluation import FRACTION, respond
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.parallel import Shared, run
from hsr_pin.trajectory import Array

#: Links and error of a step [m at the tip] of the chain that is tried: what counts is the difference of two predictions.
_LINKS, _TOLERANCE = 8, 5e-4
#: Starts of a fit, of what has no shape and of what has; and how far within its bounds each is, over its scale.
_STARTS, _SHAPES, _INSIDE = 2, 3, 0.2
#: From one probe to the next: a size between them is guessed within these factors.
_BETWEEN = (0.6, 1.6)
#: Relative change of cost and values at which a fit has converged, and evaluations at most.
_DONE, _EVALUATIONS = 1e-3, 15


@dataclass(frozen=True, eq=False)
class Guess:
    """Where to begin.

    Attributes:
        suspect: what may have changed.
        starts: (K,) open values each, the most promising first.
        square: what the best would leave of the squared residuals.
    """

    suspect: Suspect
    starts: tuple[Array, ...]
    square: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """A change, fitted.

    Attributes:
        suspect: what has changed.
        after: (K,) the open values in NEW.
        residual: (n,) whitened, of both recordings.
        slopes: (n, K) its derivatives.
        moved: for each run of NEW (B, M, A) [m] how the change moves the prediction.
    """

    suspect: Suspect
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
        """[m] RMS distance by which the change moves the markers of NEW."""
        return _rms(self.moved)

    def apart(self, other: Fitted) -> float:
        """[m] RMS distance between what two changes make of NEW."""
        return _rms([one - two for one, two in zip(self.moved, other.moved, strict=True)])


def _rms(moved: Sequence[Array]) -> float:
    axes = moved[0].shape[2]
    return float(np.sqrt(axes * np.mean(np.concatenate([each.ravel() for each in moved]) ** 2)))


def moved(frame: Frame, suspect: Suspect, changed: Array, runs: Sequence[int], *, fine: bool = False) -> list[Array]:
    """For some of the runs (B, M, A, C) [m] how the prediction moves with open values (C, K), from what it is with OLD's.

    All take the steps in time that the first of them needs. A delay shifts what was seen, and not what the model makes of it.
    """
    experiment = frame.pair.experiment
    late, changed = suspect.delays(changed)
    points = np.vstack([suspect.values(changed), suspect.before])
    model = suspect.hypothesis if fine else _rough(suspect.hypothesis)
    found = []
    for k in runs:
        seen = np.moveaxis(respond(experiment, experiment.runs[k], model, points).positions[..., experiment.axes], 1, -1)
        seen = np.nan_to_num(seen, nan=experiment.dataset.length)
        found.append(frame.pair.bins[k](seen[..., :-1] - seen[..., -1:]) + (frame.pair.later(k, late) if late.any() else 0.0))
    return found


def _rough(model: Hypothesis) -> Hypothesis:
    return replace(model, links=min(_LINKS, model.links), tolerance=max(_TOLERANCE, model.tolerance))


def guessed(frame: Frame, suspect: Suspect, beside: Fitted | None = None) -> Guess | None:
    """The best of the probes, each made as large as it would best be; None where none can be simulated.

    ``beside`` (a change that is there already): the suspect is that and another, its probes are those of the other alone.
    """
    known = np.empty(0) if beside is None else beside.after
    places = suspect.probes.reshape(-1, suspect.probes.shape[-1])
    probes = np.column_stack([np.tile(known, (len(places), 1)), places])
    start = np.append(known, suspect.start[len(known) :])
    columns = frame.change(moved(frame, suspect, np.vstack([start, probes]), frame.pair.new_runs))
    residual = frame.seen + columns[:, 0]
    columns = columns[:, 1:] - columns[:, :1]
    if suspect.probes.ndim == 3:
        return _added_up(suspect, start, probes, residual, columns)
    low, high = _bounds(suspect)
    squares = (columns**2).sum(axis=0)
    usable = np.isfinite(squares) & (squares > 1e-9)
    with np.errstate(invalid="ignore", divide="ignore"):
        factors = np.clip(-(columns.T @ residual) / squares, *_BETWEEN)
    left = ((residual[:, None] + factors * columns) ** 2).sum(axis=0)
    sized = np.array(suspect.sizes)
    sized[: len(known)] = False
    starts: dict[object, Array] = {}
    order = [int(c) for c in np.argsort(left) if usable[c]]
    for c in order:  # a local defect is looked for in two places; what has no shape at two sizes
        shape = tuple(probes[c][len(known) :][~sized[len(known) :]])[:1] or c
        starts.setdefault(shape, np.where(sized, np.clip(start + factors[c] * (probes[c] - start), low, high), probes[c]))
    if not order:
        return None
    return Guess(suspect, tuple(starts.values())[: _STARTS if sized[len(known) :].all() else _SHAPES], float(left[order[0]]))


def _added_up(suspect: Suspect, start: Array, probes: Array, residual: Array, columns: Array) -> Guess | None:
    """The best sums of probes (C, K) along the axes, of each size one; (n,) and (n, C) is what they are to explain, and do."""
    found, axes = [], suspect.probes.shape[-1]
    for first in range(0, len(probes), axes):
        chosen = slice(first, first + axes)
        if not np.isfinite(columns[:, chosen]).all():
            continue
        weights = np.linalg.lstsq(columns[:, chosen], -residual, rcond=1e-6)[0]
        weights *= min(1.0, _BETWEEN[1] / max(float(np.linalg.norm(weights)), 1e-12))
        values = np.clip(start + weights @ (probes[chosen] - start), *_bounds(suspect))
        found.append((float(((residual + columns[:, chosen] @ weights) ** 2).sum()), values))
    found.sort(key=lambda each: each[0])
    return Guess(suspect, tuple(values for _, values in found[:_STARTS]), found[0][0]) if found else None


def _bounds(suspect: Suspect) -> tuple[Array, Array]:
    """(K,) each."""
    low, high = (np.array([getattr(fact, side) for fact in suspect.facts]) for side in ("lower", "upper"))
    return low, high


def refined(frame: Frame, guess: Guess, *, fine: bool = False) -> Fitted:
    """The best fit from the starts of a guess."""
    suspect, runs = guess.suspect, frame.pair.new_runs
    scale = np.array([fact.scale for fact in suspect.facts])
    lower, upper = (bound / scale for bound in _bounds(suspect))
    known: dict[bytes, tuple[Array, Array, list[Array]]] = {}

    def at(x: Array) -> tuple[Array, Array, list[Array]]:
        if x.tobytes() not in known:
            ahead = np.where(x + 2 * FRACTION <= upper, 2 * FRACTION, -2 * FRACTION)
            delta = moved(frame, suspect, np.vstack([x, x + np.diag(ahead)]) * scale, runs, fine=fine)
            chords = [np.concatenate([d[..., :1], (d[..., 1:] - d[..., :1]) / ahead], axis=-1) for d in delta]
            rows = frame.change(chords)
            known[x.tobytes()] = frame.seen + rows[:, 0], rows[:, 1:], [d[..., 0] for d in delta]
        return known[x.tobytes()]

    answers = []
    for start in guess.starts:
        inside = np.minimum(_INSIDE, 0.4 * (upper - lower))
        x = np.clip(start / scale, lower + inside, upper - inside)  # a fit that begins at a bound hardly leaves it
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
    return Fitted(suspect, np.asarray(best.x * scale), residual, slopes / scale, tuple(delta))


class Bench:
    """Many suspects side by side.

    Args:
        frame: what residuals are seen through.
        executor: who computes.
    """

    def __init__(self, frame: Frame, executor: Executor) -> None:
        self._shared, self._executor = Shared(frame), executor

    def guessed(self, suspects: Sequence[Suspect], beside: Fitted | None = None) -> list[Guess]:
        """Those that can be simulated, the most promising first."""
        answers = run(self._executor, _guessed, [(self._shared, suspect, beside) for suspect in suspects])
        return sorted((guess for guess in answers if guess is not None), key=lambda guess: guess.square)

    def refined(self, guesses: Sequence[Guess]) -> list[Fitted]:
        """The best first."""
        answers = run(self._executor, _refined, [(self._shared, guess) for guess in guesses])
        return sorted(answers, key=lambda fitted: fitted.square)


def _guessed(shared: Shared[Frame], suspect: Suspect, beside: Fitted | None) -> Guess | None:
    return guessed(shared.get(), suspect, beside)


def _refined(shared: Shared[Frame], guess: Guess) -> Fitted:
    return refined(shared.get(), guess)
