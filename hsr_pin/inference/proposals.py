"""Proposals of causes to add to a fitted model, with initial estimates and predicted gains, from probe simulations."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.misfit import scaled
from hsr_pin.inference.problem import ALWAYS, Hypothesis, Part, Problem
from hsr_pin.inference.trial_parameters import Eliminated
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Scaled amplitudes with which an effect is probed, within its bounds; several, because its influence may be nonlinear. An effect
#: with shape parameters is probed with the second list.
_PROBES = (0.5, 8.0, 32.0)
_SHAPED = (0.25, 2.0)
#: Number of start points of a quick fit, because the misfit has several minima in the shape parameters.
_STARTS = 2
#: Largest number of runs that probes and quick fits use, and approximate number of samples of each.
_ENOUGH, _SAMPLES = 8, 400
#: A start point whose misfit exceeds that of the best by more than this factor is dropped.
_WORSE = 2.0
#: Largest scaled distance of an initial estimate from neutral, unless it was probed with a larger one.
_FARTHEST = 6.0
#: Directions whose influence on the residuals is below this share of the strongest one are treated as undetermined.
_BLIND = 1e-6
#: Smallest squared residual, for recordings that a model predicts exactly.
_NOTHING = 1e-300


@dataclass(frozen=True, eq=False)
class Proposal:
    """A model with one additional cause and the start points of its fit.

    Attributes:
        hypothesis: the model with the additional cause.
        starts: start points (P,), the most promising first.
        gain: share of the squared misfit that the fit from the first start point is predicted to remove, 0 to 1.
        visibility: name of each amplitude -> (G,) RMS change of the weighted residuals of each group of channels for one unit of
            it, at the most visible values of the shape parameters, beyond what a change of the other free parameters can hide.
    """

    hypothesis: Hypothesis
    starts: tuple[Array, ...]
    gain: float
    visibility: Mapping[str, Array] = field(default_factory=dict)


def proposals(problem: Problem, base: Fit, effects: Sequence[Part]) -> list[Proposal]:
    """Return proposals for adding one effect to a fitted model, at most one for each effect, in the order of ``effects``.

    Each effect is probed with a small value of each of its amplitudes at several values of its shape parameters, all in one
    batch. The change of the residuals is taken as linear in the amplitudes. Linear least squares yields the best amplitudes,
    together with the changes of the free parameters along their known derivatives, and the predicted misfit.
    """
    problem, base = _thinned(problem, base)
    whitened, without = base.whitened(), [base.eliminated(run) for run in range(len(problem.runs))]
    residual, slopes = (np.concatenate(part) for part in zip(*whitened, strict=True))
    known = _Known(residual, slopes * scaled(base.hypothesis)[0])
    probed: dict[tuple[object, ...], list[Array]] = {}  # of each plain variant
    found: list[Proposal] = []
    for effect in effects:
        plain = effect.base_variant
        if plain.variant not in probed:
            probed[plain.variant] = _changes(problem, base, plain, without)
        found += _propose(problem, base, effect, known, probed[plain.variant])
    return found


def _changes(problem: Problem, base: Fit, effect: Part, without: Sequence[Eliminated]) -> list[Array]:
    """Return for each run the changes (n, S A) of the residuals for each of A amplitudes in each of S probes."""
    whole = base.hypothesis.with_part(effect)
    new = whole.parameters[len(base.values) :]
    neutral = np.array([fact.neutral for fact in new])
    alone = [np.where(np.arange(len(new)) == k, probe, _at_rest(new, probe)) for probe in _probes(new) for k in _amplitudes(new)]
    points = np.array([np.append(base.values, values) for values in (neutral, *alone)])
    seen = problem.probe(whole.rough, points)
    return [
        free(np.moveaxis(each[:, 1:] - each[:, :1], 1, -1)[w > 0] * w[w > 0][:, None])
        for each, w, free in zip(seen, base.weights, without, strict=True)
    ]


def _propose(problem: Problem, base: Fit, effect: Part, known: _Known, seen: Sequence[Array]) -> list[Proposal]:
    """Return the proposal for one effect from its probes, or none if all of its simulations fail."""
    whole = base.hypothesis.with_part(effect)
    new = whole.parameters[len(base.values) :]
    amplitudes, probes = _amplitudes(new), _probes(new)
    every = np.concatenate(
        [problem.changes_of_variant(whole, new, run, own) for own, run in zip(seen, problem.runs, strict=True)]
    )
    answers: dict[tuple[float, ...], tuple[float, Array]] = {}  # the best for each set of shape parameters
    visibility: dict[str, Array] = {}
    channels = np.concatenate([np.nonzero(weights > 0)[1] for weights in base.weights])
    groups = [np.isin(channels, own) for own in problem.groups]
    for n, probe in enumerate(probes):
        changes = every[:, n * len(amplitudes) : (n + 1) * len(amplitudes)]
        if not np.isfinite(changes).all():
            continue
        answer = _linear_propose(base, whole, np.append(base.values, probe), known, changes)
        shape = tuple(value for value, fact in zip(probe, new, strict=True) if not fact.amplitude)
        answers[shape] = max(answer, answers.get(shape, answer), key=lambda each: each[0])
        for k, own in zip(amplitudes, known.without(changes).T, strict=True):
            if (size := abs(probe[k] - new[k].neutral)) > 0:
                shown = np.array([np.sqrt(np.mean(own[rows] ** 2)) if rows.any() else 0.0 for rows in groups]) / size
                visibility[new[k].name] = max(visibility.get(new[k].name, 0 * shown), shown, key=np.linalg.norm)
    best = _distinct(answers)[:_STARTS]
    return [Proposal(whole, tuple(start for _, start in best), best[0][0], visibility)] if best else []


def _amplitudes(facts: Sequence[Parameter]) -> list[int]:
    """Return the indices of the amplitudes among an effect's parameters; the first parameter if none is an amplitude."""
    return [k for k, fact in enumerate(facts) if fact.amplitude] or [0]


def _at_rest(facts: Sequence[Parameter], values: Array) -> Array:
    """Return parameter values with neutral amplitudes."""
    return np.array([fact.neutral if fact.amplitude else value for fact, value in zip(facts, values, strict=True)])


def _distinct(answers: dict[tuple[float, ...], tuple[float, Array]]) -> list[tuple[float, Array]]:
    """Return the answers, the best first, with one answer for each value of the first shape parameter (a position)."""
    found: dict[tuple[float, ...], tuple[float, Array]] = {}
    for shape, answer in sorted(answers.items(), key=lambda each: -each[1][0]):
        found.setdefault(shape[:1], answer)
    return list(found.values())


def _starts(problem: Problem, proposal: Proposal) -> tuple[Array, ...]:
    """Return the best start points by simulation: one for each proposed point and its variations, then the best of the others.

    The best point of the group :data:`~hsr_pin.inference.problem.ALWAYS` is included, whatever its misfit.
    """
    groups, tried = zip(*proposal.hypothesis.start_points(proposal.starts), strict=True)
    points, squares = np.array(tried), []
    for run, seen in zip(problem.runs, problem.probe(proposal.hypothesis.rough, points), strict=True):
        missed = np.nan_to_num(seen - run.compared[:, None], nan=problem.worst)
        squares.append(np.where(np.isfinite(run.compared[:, None]), missed**2, 0.0).sum(axis=(0, 2, 3)))
    sizes = np.sqrt(np.sum(squares, axis=0))
    order = [int(k) for k in np.argsort(sizes, kind="stable")]
    first: dict[int, int] = {}  # a local defect is fitted at two positions, not twice at the best one
    for k in order:
        first.setdefault(groups[k], k)
    ranked = [*first.values(), *(k for k in order if k not in first.values())]
    chosen = [k for k in ranked[:_STARTS] if sizes[k] <= _WORSE * sizes[order[0]]]
    if ALWAYS in first and first[ALWAYS] not in chosen:
        chosen.append(first[ALWAYS])
    return tuple(points[k] for k in chosen)


def quick_fit(problem: Problem, base: Fit, proposal: Proposal) -> Fit:
    """Return the best of the quick fits from the start points of a proposal, to some of the runs."""
    problem, base = _thinned(problem, base)
    answers = [fit(problem, proposal.hypothesis.rough, start=start, quick=True) for start in _starts(problem, proposal)]
    return replace(min(answers, key=lambda fitted: fitted.rms), hypothesis=proposal.hypothesis)


def probed_runs(problem: Problem) -> list[int]:
    """Return the indices of the runs that probes and quick fits use, from the least to the most moving ones.

    Both are needed, because a law such as a bending stop acts only in trials with large motion.
    """
    by_size = np.argsort([run.moved for run in problem.runs], kind="stable")
    chosen = np.linspace(0, len(by_size) - 1, min(_ENOUGH, len(by_size))).round().astype(int)
    return sorted(by_size[chosen].tolist())


def _thinned(problem: Problem, base: Fit) -> tuple[Problem, Fit]:
    """Return the problem and a fit, reduced to some of the samples of some of the runs."""
    thin, kept = _some_of(problem), probed_runs(problem)

    def some(items: tuple[Array, ...]) -> tuple[Array, ...]:
        return tuple(items[k][:: run.every] for k, run in zip(kept, thin.runs, strict=True))

    fewer = replace(
        base,
        residuals=some(base.residuals),
        raw_residuals=some(base.raw_residuals),
        slopes=some(base.slopes),
        weights=some(base.weights),
        nuisance=tuple(each[..., : thin.own(run)] for run, each in zip(thin.runs, some(base.nuisance), strict=True)),
    )
    return thin, fewer


@lru_cache(maxsize=2)
def _some_of(problem: Problem) -> Problem:
    """Return the problem reduced to some samples of some runs; cached, so that its own caches are reused."""
    return problem.some(probed_runs(problem), _SAMPLES)


def _probes(facts: Sequence[Parameter]) -> list[Array]:
    """Return the probed values of an effect's parameters: a few amplitudes at a few values of each shape parameter."""
    shapes = [fact.start_values if not fact.amplitude else [0.0] for fact in facts]
    shaped = any(not fact.amplitude for fact in facts)
    sizes = [n for n in (_SHAPED if shaped else _PROBES) if n < 1 or all(_holds(fact, n) for fact in facts if fact.amplitude)]
    return [
        np.array([f.neutral + size * f.scale if f.amplitude else at for f, at in zip(facts, shape, strict=True)])
        for size in sizes
        for shape in itertools.product(*shapes)
    ]


def _holds(fact: Parameter, size: float) -> bool:
    """Return whether an amplitude of this many scales is within the bounds."""
    return fact.neutral + size * fact.scale <= fact.upper


class _Known:
    """Projection of residuals (n,) onto the derivatives (n, P) of the free parameters of a fit."""

    def __init__(self, residual: Array, slopes: Array) -> None:
        size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
        basis, strength, mix = np.linalg.svd(slopes / size, full_matrices=False)
        determined = strength > _BLIND * strength.max(initial=0.0)
        self._basis, self._back = basis[:, determined], (mix[determined] / strength[determined, None]).T / size[:, None]
        self.residual, self.left = residual, self.without(residual)

    def without(self, rows: Array) -> Array:
        """Return the part of (n, ...) that no change of the free parameters can remove."""
        return np.asarray(rows - self._basis @ (self._basis.T @ rows))

    def step(self, rows: Array) -> Array:
        """Return the change (P,) of the free parameters that removes most of (n,)."""
        return np.asarray(-self._back @ (self._basis.T @ rows))


def _linear_propose(base: Fit, hypothesis: Hypothesis, start: Array, known: _Known, changes: Array) -> tuple[float, Array]:
    """Return the predicted gain and the values (P,) that should achieve it.

    ``changes`` (n, A) are the changes of the residuals (n,) for each amplitude alone, with its value in ``start`` (P,).
    """
    facts, old = hypothesis.parameters, len(base.values)
    own = known.without(changes)
    size = np.maximum(np.linalg.norm(own, axis=0), np.maximum(_BLIND * np.linalg.norm(changes, axis=0), 1e-12))
    own = own / size
    amounts = -np.linalg.lstsq(own.T @ own, own.T @ known.left, rcond=_BLIND**2)[0] / size
    values = start.copy()
    for place, index in enumerate(k for k in range(old, len(facts)) if facts[k].amplitude):
        probe = start[index] - facts[index].neutral
        probed = probe / facts[index].scale
        amounts[place] = _allowed(facts[index], amounts[place] * probed, max(_FARTHEST, probed)) / probed
        values[index] = facts[index].neutral + amounts[place] * probe
    rest = known.residual + changes @ amounts
    values[:old] += [fact.scale for fact in facts[:old]] * np.clip(known.step(rest), -3.0, 3.0)
    left = known.without(rest)
    lower, upper = (np.array([getattr(fact, side) for fact in facts]) for side in ("lower", "upper"))
    gain = 1 - float(left @ left) / max(float(known.residual @ known.residual), _NOTHING)
    return max(0.0, gain), np.asarray(np.clip(values, lower, upper))


def _allowed(fact: Parameter, wanted: float, farthest: float) -> float:
    """Return the scaled amplitude nearest to the wanted one that is within all limits and not neutral.

    At the neutral value the derivatives of shape parameters are zero, so that a fit that starts there cannot change them.
    """
    lowest = max(-farthest, (fact.lower - fact.neutral) / fact.scale)
    highest = min(farthest, (fact.upper - fact.neutral) / fact.scale)
    amplitude = float(np.clip(wanted, lowest, highest))
    return amplitude if abs(amplitude) > 0.1 else float(np.copysign(0.1, amplitude if lowest < 0 else 1.0))
