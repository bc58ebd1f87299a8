"""What the model of OLD lacks and has no name for: how it goes on in NEW, and how sure that is.

The residuals of a model are taken as Gaussian processes, one for each principal component of all markers' coordinates
(C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006; M. C. Kennedy, A. O'Hagan, Bayesian
calibration of computer models, J. R. Stat. Soc. B 63, 2001):

- a smooth function of what the arm does and is told to do (pose, rate, command, filtered commands, stiffness level, payload,
  time), the same in every trial: where NEW repeats a command of OLD, it is what OLD's trials of it had in common, and drops out;
- what each trial has of its own: a constant, and a process that forgets itself (Ornstein and Uhlenbeck), wider in releases;
- noise.

The first and the process are taken to grow with how much the arm moves in a trial. In NEW the process is wider by a share of what
is to be explained: no law says exactly what a change does.

How large and how long each is follows from OLD alone, by maximum likelihood: a leftover that does not go on from trial to trial
is no function of these, and belongs to the trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from hsr_pin.diagnosis.change.pair import Pair
from hsr_pin.identification.evaluation import respond
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.trajectory import Array

#: Of the residual of a run of NEW, the share that no law of a change is taken to explain.
_INEXACT = 0.05
#: Time constants of the filtered commands that are features [s].
_FILTERS = (0.15, 1.0)
#: Share of the bins in which some marker is not seen, from which on markers are not taken together.
_LOST = 0.05
#: Rows at most from which the sizes are learnt: their cost grows with the third power.
_LEARNT = 320
#: Sizes: shared, constant of a trial, process of a trial, its time [s], noise, reach of a feature, releases over commands; as
#: logarithms, with what is expected and how surely. The first three over the RMS residual, the noise over the noise floor.
_NAMES = ("shared", "constant", "own", "time", "noise", "reach", "released")
_EXPECTED = np.log([0.3, 0.3, 0.3, 0.5, 1.0, 1.5, 2.0])
_SURE = np.array([1.5, 1.5, 1.5, 1.5, 0.3, 0.7, 0.7])
_LOW, _HIGH = np.log([1e-3, 1e-3, 1e-2, 0.02, 0.5, 0.3, 0.5]), np.log([3.0, 3.0, 3.0, 20.0, 5.0, 10.0, 10.0])


@dataclass(frozen=True, eq=False)
class Rows:
    """Of one sum over the markers' coordinates, over both recordings, OLD's first.

    Attributes:
        mix: (M, A) of how much of each; its squares add up to one.
        run: (n,) to which each row belongs.
        place: (n,) its bin.
        white: (n,) [m^2] variance of the noise floor in it.
        time: (n,) [s] in the run.
    """

    mix: Array
    run: NDArray[np.intp]
    place: NDArray[np.intp]
    white: Array
    time: Array

    def part(self, chosen: slice, first: int) -> Rows:
        """Some of them, their runs counted from ``first`` on."""
        run, place = self.run[chosen] - first, self.place[chosen]
        return Rows(self.mix, run, place, self.white[chosen], self.time[chosen])

    def of(self, binned: Sequence[Array]) -> Array:
        """(n, ...) rows of one (B, M, A, ...) per run."""
        whole = np.concatenate([np.einsum("bma...,ma->b...", values, self.mix) for values in binned])
        first = np.cumsum([0, *(len(values) for values in binned)])
        return np.asarray(whole[first[self.run] + self.place])


def rows_of(pair: Pair, missed: Sequence[Array]) -> list[Rows]:
    """One for each of the ways in which the residuals of OLD go together, (B, M, A) [m] for each run; or for each coordinate.

    A trial that bends more than the others is off at all markers, each by its share: what is left across that is known better
    than any coordinate alone (principal components: I. T. Jolliffe, Principal Component Analysis, 2002).
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
    """For each run (B, F) what the arm does and is told to do, as the model of OLD has it, in units of what they are in OLD."""
    found = []
    for run, bins in zip(pair.experiment.runs, pair.bins, strict=True):
        answer = respond(pair.experiment, run, hypothesis, values[None])
        angles, rates = (answer.columns.bends(np.nan_to_num(each[:, 0])) for each in (answer.angles, answer.rates))
        half = angles.shape[1] // 2
        told = []
        for command in run.command.T / run.trial.keq:
            every = [command, *(_filtered(command, run.step, each) for each in _FILTERS)]
            told += [each[run.looked_at] for each in every]
        moving = [angles.sum(axis=1), angles[:, half:].sum(axis=1) - angles[:, :half].sum(axis=1), rates.sum(axis=1)]
        level, payload = np.log(run.trial.keq), run.trial.tip_mass
        binned = bins.of_all(np.column_stack([part for each in (*moving, *told) for part in _directions(each)]))
        rest = np.column_stack([np.full(len(binned), level), np.full(len(binned), payload), np.log1p(bins.time)])
        found.append(np.column_stack([binned, rest]))
    old = np.concatenate([each for each, new in zip(found, pair.is_new, strict=True) if not new])
    told_of = 3 * max(1, len(pair.experiment.dataset.sections))
    least = np.repeat([0.05, 0.02, 0.2, *[0.05] * told_of], len(pair.experiment.directions))
    scale = np.concatenate([np.maximum(old.std(axis=0)[: len(least)], least), [0.7, 0.05, 1.0]])
    return [each / scale for each in found]


def _directions(values: Array) -> tuple[Array, ...]:
    """(T,) in the plane itself; in space towards x and towards y."""
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
    """Of some rows, for sizes (7,) as :data:`_NAMES`.

    Attributes:
        distance: (n, n) squared, between features.
        same: (n, n) one where both rows are of the same run.
        apart: (n, n) [s].
        released: (n,) one where the run is a release.
        motion: (n,) how much the arm moves in the run, over what it does in OLD's.
        inexact: (n,) [m] by which the law of a change may be off; 0 in OLD.
        white: (n,) [m^2] of the noise floor over the samples of the bin.
        scale: [m] RMS residual of OLD.
    """

    distance: Array
    same: Array
    apart: Array
    released: Array
    motion: Array
    inexact: Array
    white: Array
    scale: float

    @classmethod
    def of(
        cls, pair: Pair, rows: Rows, found: Sequence[Array], residual: Array, off: Sequence[float], some: NDArray[np.intp]
    ) -> Covariance:
        """For some of the rows, of whose residuals (n,) [m] those of OLD tell the scale; each run is off by so much [m]."""
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
        """(n, n) each [m^2]: shared, constant, own, and the diagonal of the noise (n,)."""
        s, a, b, t, w, reach, more = np.exp(sizes)
        wide = np.where(self.released > 0, more, 1.0)
        moving, forgets = wide * self.motion, self.same * np.exp(-self.apart / t)
        return [
            (s * self.scale) ** 2 * np.outer(self.motion, self.motion) * np.exp(-self.distance / (2 * reach**2)),
            (a * self.scale) ** 2 * self.same * np.outer(wide, wide),
            forgets * ((b * self.scale) ** 2 * np.outer(moving, moving) + np.outer(self.inexact, self.inexact)),
            w**2 * self.white,
        ]

    def matrix(self, sizes: Array) -> Array:
        """(n, n) [m^2]."""
        shared, constant, own, white = self.parts(sizes)
        return np.asarray(shared + constant + own + np.diag(white))


def learnt(covariance: Covariance, residual: Array, known: Array) -> Array:
    """Sizes (7,) under which a residual (n,) of OLD is most likely, what is known (n, K) to be free in it left free."""
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
                0.5 * np.sum(weight * own * covariance.apart) / time,
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
    """Rows of OLD from which sizes are learnt: pairs of neighbours, spread evenly."""
    own = np.flatnonzero(old[rows.run])
    stride = max(1, -(-2 * len(own) // _LEARNT))
    return np.asarray(own[(np.arange(len(own)) % stride) < 2] if stride > 2 else own)
