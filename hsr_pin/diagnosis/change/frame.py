"""Whitened residuals of both recordings, with shared parameters and trial parameters eliminated.

Generalised least squares for a linear mixed model (C. R. Henderson, Biometrics 31, 1975): r = J b + N c + g + e with b the
parameters that both recordings share, c the trial parameters, g the model discrepancy and e the noise. The rows of the current
recording come last, so that after whitening with a Cholesky factor they are the part that the reference recording does not
predict.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from hsr_pin.diagnosis.change.discrepancy import Covariance, Rows, features, fitted_hyperparameters, rows_of, thinned
from hsr_pin.diagnosis.change.pair import Pair
from hsr_pin.identification.evaluation import predict_with_slopes
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.inference.problem import Prediction
from hsr_pin.inference.residuals import residuals
from hsr_pin.inference.trial_parameters import Eliminated
from hsr_pin.trajectory import Array

#: Prior standard deviation of the shared parameters about the fit to the reference recording [scales].
_WIDE = 0.3
#: Uncertain declared parameters and their relative standard deviation; their error is equal in both recordings.
DECLARED = {"mass_scale": 0.1, "torque_gain": 0.05}


@dataclass(frozen=True, eq=False)
class Frame:
    """Whitened residuals of both recordings, and the transformations that lead to them.

    Attributes:
        pair: the recordings.
        hypothesis, values: the reference model and its values (P,); uncertain declared parameters are free in it too.
        rows: rows of the current recording, for each linear combination of marker coordinates.
        roots: for each of these the Cholesky factor (n, n) of its covariance given the reference recording [m].
        rooted: (n, 1 + K) whitened residuals of both recordings, the reference first, then the shared and trial parameters.
        run: (n,) index of the run of each row.
        sizes: (channels, 7) hyperparameters of the covariances.
        eliminated: elimination of the shared and trial parameters.
    """

    pair: Pair
    hypothesis: Hypothesis
    values: Array
    rows: tuple[Rows, ...]
    roots: tuple[Array, ...]
    rooted: Array
    run: NDArray[np.intp]
    sizes: Array
    eliminated: Eliminated

    @property
    def seen(self) -> Array:
        """Whitened residuals (n,) of both recordings with the parameters eliminated."""
        return self.eliminated(self.rooted[:, :1])[:, 0]

    @property
    def old(self) -> int:
        """Number of rows of the reference recording."""
        return len(self.run) - sum(len(rows.run) for rows in self.rows)

    def change(self, binned: Sequence[Array]) -> Array:
        """Return the influence (n, C) on the residuals of a change (B, M, A, C) [m] in each run of the current recording."""
        return self.eliminated.after(self.old, _rooted(self.rows, self.roots, binned))

    def _metres(self, rooted: Array) -> Array:
        """Return residuals (n,) of the current recording in metres, from whitened ones."""
        parts = np.split(rooted, np.cumsum([len(rows.run) for rows in self.rows])[:-1])
        return np.concatenate([root @ part for root, part in zip(self.roots, parts, strict=True)])

    @property
    def _axes(self) -> int:
        """Number of coordinates of a marker."""
        return len(self.pair.experiment.axes)

    @property
    def scatter(self) -> float:
        """Expected RMS distance of the current recording without any change: discrepancy, trial parameters and noise [m]."""
        variance = np.concatenate([(root**2).sum(axis=1) for root in self.roots])
        columns = self.rooted[:, 1:]
        mine = columns[
            self.old :, ~columns[: self.old].any(axis=0)
        ]  # trial parameters of the current recording; the reference determines the shared ones
        own = np.column_stack([np.zeros(len(mine)), *(self._metres(column) for column in mine.T)])
        return float(np.sqrt(self._axes * (variance + (own**2).sum(axis=1)).mean()))

    @property
    def prediction_error(self) -> Array:
        """Prediction from the reference recording minus the measurement (n,), coordinate by coordinate [m]."""
        return self._metres(self.rooted[self.old :, 0])

    def off(self, moved: Sequence[Array] = ()) -> float:
        """Return the RMS distance between the current recording and its prediction, with a change (B, M, A) [m] in each run."""
        seen = self.prediction_error
        if moved:
            seen = seen + np.concatenate([rows.of(moved) for rows in self.rows])
        return float(np.sqrt(self._axes * np.mean(seen**2)))

    def at(self, model: Hypothesis, values: Array) -> Frame:
        """Return the frame with derivatives at another current model, whose values (P,) include the shared parameters."""
        runs = tuple(self.pair.experiment.runs[k] for k in self.pair.new_runs)
        part = replace(self.pair.experiment, runs=runs)
        chosen = [model.free.index(name) for name in self.hypothesis.free]
        answers = []
        for hypothesis, point, columns in (
            (self.hypothesis, self.values, list(range(len(chosen)))),
            (model, values, chosen),
        ):
            predictions = predict_with_slopes(part, hypothesis, point)
            answers.append(_binned(self.pair, predictions, self.pair.new_runs, columns, _wide(self.hypothesis)))
        total = self.rooted.shape[1] - 1
        own = [_columns(*answer, total)[0] for answer in answers]
        rooted = self.rooted.copy()
        rooted[self.old :, 1:] += _rooted(self.rows, self.roots, [b - a for a, b in zip(*own, strict=True)])
        return replace(self, rooted=rooted, eliminated=Eliminated.of(rooted[:, 1:]))


@dataclass(frozen=True, eq=False)
class Before:
    """Whitened residuals of the reference recording alone, of which some trials can be treated as another recording.

    Attributes:
        rows, roots: as in :class:`Frame`, of the reference recording.
        eliminated: elimination of the shared and trial parameters.
        seen: (n,) residuals.
    """

    rows: tuple[Rows, ...]
    roots: tuple[Array, ...]
    eliminated: Eliminated
    seen: Array

    def change(self, binned: Sequence[Array]) -> Array:
        """Return the influence (n, C) on the residuals of a change (B, M, A, C) [m] in each run of the reference recording."""
        return self.eliminated(_rooted(self.rows, self.roots, binned))


def framed(pair: Pair, hypothesis: Hypothesis, values: Array) -> tuple[Frame, Before]:
    """Return the frames for a model fitted to the reference recording, with its free parameters at ``values`` (P,)."""
    more = tuple(name for name in DECLARED if name not in hypothesis.free)
    hypothesis = replace(hypothesis, free=(*hypothesis.free, *more))
    values = np.append(values, np.ones(len(more)))
    experiment, count = pair.experiment, len(pair.old.runs)
    predictions = predict_with_slopes(experiment, hypothesis, values)
    missed = [b(np.nan_to_num(r)) for b, r in zip(pair.bins, residuals(experiment, predictions), strict=True)]
    everything = range(len(experiment.runs))
    slopes, own = _binned(pair, predictions, everything, list(range(len(values))), _wide(hypothesis))
    columns, _ = _columns(slopes, own)
    found = features(pair, hypothesis, values)
    old_rows, new_rows, old_roots, new_roots, sizes, sides = [], [], [], [], [], []
    off = [float(np.sqrt(np.mean(each**2))) for each in missed]
    for each in rows_of(pair, missed):
        some, first = thinned(each, ~pair.is_new), int(np.sum(~pair.is_new[each.run]))
        residual, known = each.of(missed), each.of(columns)
        size = fitted_hyperparameters(Covariance.of(pair, each, found, residual, off, some), residual[some], known[some])
        whole = Covariance.of(pair, each, found, residual, off, np.arange(len(residual))).matrix(size)
        root = np.asarray(np.linalg.cholesky(whole), dtype=float)
        both = solve_triangular(root, np.column_stack([residual, known]), lower=True)
        sides.append((both[:first], both[first:]))
        old_rows.append(each.part(slice(0, first), 0))
        new_rows.append(each.part(slice(first, None), count))
        old_roots.append(root[:first, :first].copy())
        new_roots.append(root[first:, first:].copy())
        sizes.append(size)
    olds, news = (np.concatenate(side) for side in zip(*sides, strict=True))
    rooted = np.vstack([olds, news])
    run = np.concatenate([*(rows.run for rows in old_rows), *(rows.run + count for rows in new_rows)])
    frame = Frame(
        pair,
        hypothesis,
        values,
        tuple(new_rows),
        tuple(new_roots),
        rooted,
        run,
        np.array(sizes),
        Eliminated.of(rooted[:, 1:]),
    )
    alone = Eliminated.of(olds[:, 1:])
    return frame, Before(tuple(old_rows), tuple(old_roots), alone, alone(olds[:, :1])[:, 0])


def _wide(hypothesis: Hypothesis) -> Array:
    """Return the prior standard deviation of each parameter (P,)."""
    return np.array([DECLARED.get(name, _WIDE * scale) for name, scale in zip(hypothesis.free, hypothesis.scale, strict=True)])


def _binned(
    pair: Pair, predictions: Sequence[Prediction], runs: Sequence[int], chosen: list[int], wide: Array
) -> tuple[list[Array], list[Array]]:
    """Return for each run the influence of the shared (B, M, A, P) and of the trial parameters (B, M, A, K) [m]."""
    slopes = [pair.bins[k](p.slopes[..., chosen] * wide) for k, p in zip(runs, predictions, strict=True) if p.slopes is not None]
    own = [pair.bins[k](p.nuisance) for k, p in zip(runs, predictions, strict=True) if p.nuisance is not None]
    return slopes, own


def _rooted(rows: Sequence[Rows], roots: Sequence[Array], binned: Sequence[Array]) -> Array:
    return np.concatenate([solve_triangular(root, each.of(binned), lower=True) for each, root in zip(rows, roots, strict=True)])


def _columns(slopes: Sequence[Array], own: Sequence[Array], width: int | None = None) -> tuple[list[Array], int]:
    """Return for each run (B, M, A, K) the shared parameters, then the trial parameters; those of the last runs come last."""
    shared, numbers = slopes[0].shape[-1], sum(each.shape[-1] for each in own)
    total = shared + numbers if width is None else width
    placed, out = total - numbers, []
    for slope, each in zip(slopes, own, strict=True):
        block = np.zeros((*each.shape[:-1], total))
        block[..., :shared] = slope
        block[..., placed : placed + each.shape[-1]] = each
        placed += each.shape[-1]
        out.append(block)
    return out, total
