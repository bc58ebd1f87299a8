"""Statistical model of the discrepancy of the reference model, which predicts its continuation in the current recording.

The residuals of a model are Gaussian processes, one for each principal component of all marker coordinates (C. E. Rasmussen, C.
K. I. Williams, Gaussian Processes for Machine Learning, 2006; M. C. Kennedy, A. O'Hagan, Bayesian calibration of computer models,
J. R. Stat. Soc. B 63, 2001). A process is the sum of

- a smooth function of state and command (pose, rate, command, filtered commands, stiffness level, payload, time), which is the
  same in every trial: if the current recording repeats a command of the reference, the common residual of that command cancels,
- the scatter of a trial: a constant and an Ornstein-Uhlenbeck process, both larger in releases,
- noise.

The first part and the Ornstein-Uhlenbeck process are proportional to the motion in a trial. In the current recording the latter
is increased by a share of the difference to be explained, because no law describes a change exactly.

The hyperparameters are estimated from the reference recording alone by maximum likelihood. A discrepancy that does not repeat
from trial to trial is thus attributed to the scatter of trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from hsr_pin.diagnosis.change.pair import Pair
from hsr_pin.identification.evaluation import simulate_run
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.trajectory import Array

#: Share of the residual of a current run that a law of change is not expected to explain.
_INEXACT = 0.05
#: Time constants of the filtered commands that are features [s].
_FILTERS = (0.15, 1.0)
#: Largest share of bins with an invisible marker at which principal components are used.
_LOST = 0.05
#: Largest number of rows for estimating the hyperparameters, because the cost grows with its third power.
_MOST_ROWS = 320
#: Hyperparameters as logarithms, with prior means and standard deviations: shared part, constant and process of a trial (all over
#: the RMS residual), time constant of the process [s], noise over the noise floor, length scale of the features, and scatter of
#: releases over that of commands.
_NAMES = ("shared", "constant", "own", "time", "noise", "reach", "released")
_EXPECTED = np.log([0.3, 0.3, 0.3, 0.5, 1.0, 1.5, 2.0])
_SURE = np.array([1.5, 1.5, 1.5, 1.5, 0.3, 0.7, 0.7])
_LOW, _HIGH = np.log([1e-3, 1e-3, 1e-2, 0.02, 0.5, 0.3, 0.5]), np.log([3.0, 3.0, 3.0, 20.0, 5.0, 10.0, 10.0])


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of one linear combination of the marker coordinates, over both recordings with the reference first.

    Attributes:
        mix: (M, A) coefficients; their squares add up to one.
        run: (n,) index of the run of each row.
        place: (n,) index of its bin.
        white: (n,) variance of the noise in the bin [m^2].
        time: (n,) time in the run [s].
    """

    mix: Array
    run: NDArray[np.intp]
    place: NDArray[np.intp]
    white: Array
    time: Array

    def part(self, chosen: slice, first: int) -> Rows:
        """Return some of the rows, with their runs counted from ``first``."""
        run, place = self.run[chosen] - first, self.place[chosen]
        return Rows(self.mix, run, place, self.white[chosen], self.time[chosen])

    def of(self, binned: Sequence[Array]) -> Array:
        """Return the rows (n, ...) of values (B, M, A, ...) in each run."""
        whole = np.concatenate([np.einsum("bma...,ma->b...", values, self.mix) for values in binned])
        first = np.cumsum([0, *(len(values) for values in binned)])
        return np.asarray(whole[first[self.run] + self.place])


def rows_of(pair: Pair, missed: Sequence[Array]) -> list[Rows]:
    """Return one set of rows for each principal component of the reference residuals (B, M, A) [m], or for each coordinate.

    In a trial with larger bending all markers deviate in proportion. Deviations from this pattern are known more accurately than
    any single coordinate (principal components: I. T. Jolliffe, Principal Component Analysis, 2002).
    """
    count, axes = len(pair.experiment.markers), len(pair.experiment.axes)
    together = [np.asarray((bins.counts > 0).all(axis=1)) for bins in pair.bins]
    lost = 1 - sum(each.sum() for each in together) / max(sum((b.counts > 0).any(axis=1).sum() for b in pair.bins), 1)
    if count > 1 and lost < _LOST:
        old = np.concatenate([missed[k][together[k]] for k in pair.old_runs]).reshape(-1, axes * count)
        turned = np.linalg.eigh(old.T @ old)[1].T.reshape(-1, count, axes)
        return [_rows(pair, mix, together) for mix in turned]
    single = np.eye(axes * count).reshape(-1, count, axes)
    return [_rows(pair, mix, [bins.counts[:, k // axes] > 0 for bins in pair.bins]) for k, mix in enumerate(single)]


def _rows(pair: Pair, mix: Array, seen: Sequence[NDArray[np.bool_]]) -> Rows:
    places = [np.flatnonzero(each) for each in seen]
    run = np.concatenate([np.full(len(each), k) for k, each in enumerate(places)])
    power = (mix**2).sum(axis=1) * pair.experiment.noise**2
    white = np.concatenate([(power / np.maximum(b.counts[at], 1.0)).sum(axis=1) for b, at in zip(pair.bins, places, strict=True)])
    time = np.concatenate([b.time[at] for b, at in zip(pair.bins, places, strict=True)])
    return Rows(mix, run, np.concatenate(places), white, time)


def features(pair: Pair, hypothesis: Hypothesis, values: Array) -> list[Array]:
    """Return for each run the features (B, F): state and command in the reference model, divided by their reference spread."""
    found = []
    for run, bins in zip(pair.experiment.runs, pair.bins, strict=True):
        answer = simulate_run(pair.experiment, run, hypothesis, values[None])
        angles, rates = (answer.batch.bends(np.nan_to_num(each[:, 0])) for each in (answer.angles, answer.rates))
        half = angles.shape[1] // 2
        commands = []
        for command in run.command.T / run.trial.keq:
            every = [command, *(_filtered(command, run.step, each) for each in _FILTERS)]
            commands += [each[run.looked_at] for each in every]
        moving = [angles.sum(axis=1), angles[:, half:].sum(axis=1) - angles[:, :half].sum(axis=1), rates.sum(axis=1)]
        level, payload = np.log(run.trial.keq), run.trial.tip_mass
        binned = bins.of_all(np.column_stack([part for each in (*moving, *commands) for part in _directions(each)]))
        rest = np.column_stack([np.full(len(binned), level), np.full(len(binned), payload), np.log1p(bins.time)])
        found.append(np.column_stack([binned, rest]))
    old = np.concatenate([each for each, new in zip(found, pair.is_new, strict=True) if not new])
    command_features = 3 * max(1, len(pair.experiment.dataset.sections))
    least = np.repeat([0.05, 0.02, 0.2, *[0.05] * command_features], len(pair.experiment.directions))
    scale = np.concatenate([np.maximum(old.std(axis=0)[: len(least)], least), [0.7, 0.05, 1.0]])
    return [each / scale for each in found]


def _directions(values: Array) -> tuple[Array, ...]:
    """Return values (T,) in the plane, or their components towards x and y in space."""
    return (values.real, values.imag) if np.iscomplexobj(values) else (values,)


def _filtered(command: Array, step: float, time: float) -> Array:
    keep, out = np.exp(-step / time), np.empty_like(command)
    last = command[0]
    for k, value in enumerate(command):
        out[k] = last
        last = value + (last - value) * keep
    return out


@dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of some rows, as a function of the hyperparameters (7,) in :data:`_NAMES`.

    Attributes:
        distance: (n, n) squared distance between features.
        same: (n, n) one if both rows belong to the same run.
        lag: (n, n) time between the rows [s].
        released: (n,) one if the run is a release.
        motion: (n,) motion in the run relative to that in the reference recording.
        inexact: (n,) standard deviation of the error of a law of change [m]; 0 in the reference recording.
        white: (n,) variance of the noise over the samples of the bin [m^2].
        scale: RMS residual of the reference recording [m].
    """

    distance: Array
    same: Array
    lag: Array
    released: Array
    motion: Array
    inexact: Array
    white: Array
    scale: float

    @classmethod
    def of(
        cls, pair: Pair, rows: Rows, found: Sequence[Array], residual: Array, off: Sequence[float], some: NDArray[np.intp]
    ) -> Covariance:
        """Return the covariance of the rows ``some``.

        The reference rows of ``residual`` (n,) [m] set the scale; ``off`` are the RMS errors of the runs [m].
        """
        old = residual[~pair.is_new[rows.run]]
        noise = float(np.sqrt(((rows.mix**2).sum(axis=1) * pair.experiment.noise**2).sum()))
        scale = max(float(np.sqrt(np.mean(old**2))), noise)
        run, time = rows.run[some], rows.time[some]
        first = np.cumsum([0, *(len(each) for each in found)])
        x = np.concatenate(found)[first[run] + rows.place[some]]
        square = (x**2).sum(axis=1)
        distance = np.maximum(square[:, None] + square - 2 * x @ x.T, 0.0)
        released = np.array([float(each.start_pose is not None) for each in pair.experiment.runs])[run]
        inexact = _INEXACT * np.where(pair.is_new, off, 0.0)[run]
        motion, same = np.array(pair.motion)[run], (run[:, None] == run).astype(float)
        return cls(distance, same, np.abs(time[:, None] - time), released, motion, inexact, rows.white[some], scale)

    def parts(self, sizes: Array) -> list[Array]:
        """Return the parts (n, n) [m^2]: shared, constant, own, and the diagonal of the noise (n,)."""
        s, a, b, t, w, reach, more = np.exp(sizes)
        wide = np.where(self.released > 0, more, 1.0)
        moving, forgets = wide * self.motion, self.same * np.exp(-self.lag / t)
        return [
            (s * self.scale) ** 2 * np.outer(self.motion, self.motion) * np.exp(-self.distance / (2 * reach**2)),
            (a * self.scale) ** 2 * self.same * np.outer(wide, wide),
            forgets * ((b * self.scale) ** 2 * np.outer(moving, moving) + np.outer(self.inexact, self.inexact)),
            w**2 * self.white,
        ]

    def matrix(self, sizes: Array) -> Array:
        """Return the covariance matrix (n, n) [m^2]."""
        shared, constant, own, white = self.parts(sizes)
        return np.asarray(shared + constant + own + np.diag(white))


def fitted_hyperparameters(covariance: Covariance, residual: Array, known: Array) -> Array:
    """Return the hyperparameters (7,) that maximise the likelihood of a residual (n,), with known influences (n, K) left free."""
    free = known @ known.T

    def cost(sizes: Array) -> tuple[float, Array]:
        shared, constant, own, white = covariance.parts(sizes)
        K = shared + constant + own + free
        K[np.diag_indices_from(K)] += white
        L = np.linalg.cholesky(K)
        half = solve_triangular(L, np.column_stack([residual, np.eye(len(K))]), lower=True)
        inverse, alpha = half[:, 1:].T @ half[:, 1:], half[:, 1:].T @ half[:, 0]
        weight = inverse - np.outer(alpha, alpha)
        reach2, time = np.exp(2 * sizes[5]), np.exp(sizes[3])
        wide = covariance.released[:, None] + covariance.released
        gradient = np.array(
            [
                np.sum(weight * shared),
                np.sum(weight * constant),
                np.sum(weight * own),
                0.5 * np.sum(weight * own * covariance.lag) / time,
                float(np.diag(weight) @ white),
                0.5 * np.sum(weight * shared * covariance.distance) / reach2,
                0.5 * np.sum(weight * (constant + own) * wide),
            ]
        )
        prior = (sizes - _EXPECTED) / _SURE
        value = 0.5 * float(half[:, 0] @ half[:, 0]) + float(np.log(np.diag(L)).sum()) + 0.5 * float(prior @ prior)
        return value, gradient + prior / _SURE

    bounds = list(zip(_LOW, _HIGH, strict=True))
    answer = minimize(cost, _EXPECTED, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 40})
    return np.asarray(answer.x)


def thinned(rows: Rows, old: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the reference rows from which the hyperparameters are estimated: evenly spaced pairs of neighbours."""
    own = np.flatnonzero(old[rows.run])
    stride = max(1, -(-2 * len(own) // _MOST_ROWS))
    return np.asarray(own[(np.arange(len(own)) % stride) < 2] if stride > 2 else own)
