"""What may be added to a fitted model, where its fit would start, and how much it promises: probes and quick fits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hsr_pin.inference.fit import Fit, fit
from hsr_pin.inference.misfit import scaled
from hsr_pin.inference.own_numbers import Eliminated
from hsr_pin.inference.problem import ALWAYS, Hypothesis, Part, Problem
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Amplitudes with which an effect is probed, over its parameters' scales, as far as their bounds go: what it does need not grow
#: with them. One with shape parameters is probed with a small and a large one.
_PROBES = (0.5, 8.0, 32.0)
_SHAPED = (0.25, 2.0)
#: Starts of the fit of an effect with shape parameters: their landscape has valleys.
_STARTS = 2
#: Probes and quick fits look at this many runs at most, and at hardly more samples than this of each.
_ENOUGH, _SAMPLES = 8, 400
#: A start whose misfit is more than this many times that of the best is dropped.
_WORSE = 2.0
#: No initial estimate goes further than this from neutral, over the parameter's scale, or than it was probed.
_FARTHEST = 6.0
#: What moves the residuals by less than this share of what the most telling number does tells nothing.
_BLIND = 1e-6


@dataclass(frozen=True, eq=False)
class Proposal:
    """Where to start a fit from.

    Attributes:
        hypothesis: with the effect in it.
        starts: (P,) values each, the most promising first.
        gain: share of the squared misfit that the first start is predicted to take away, 0 to 1.
    """

    hypothesis: Hypothesis
    starts: tuple[Array, ...]
    gain: float


def proposals(problem: Problem, base: Fit, effects: Sequence[Part]) -> list[Proposal]:
    """Proposals for adding one effect to a fitted model, one for each effect, in the order of ``effects``.

    Each effect is probed with a small amplitude (each of them, where it has several) at several values of its shape
    parameters, all in one batch. The change it makes is taken as linear in the amplitudes; those that fit best, with the open
    parameters adjusted along their known derivatives, and the misfit that it should leave, follow from linear least squares.
    """
    problem, base = _thinned(problem, base)
    told, without = base.whitened(), [base.eliminated(run) for run in range(len(problem.runs))]
    residual, slopes = (np.concatenate(part) for part in zip(*told, strict=True))
    known = _Known(residual, slopes * scaled(base.hypothesis)[0])
    probed: dict[tuple[object, ...], list[Array]] = {}  # of each plain variant
    found: list[Proposal] = []
    for effect in effects:
        plain = effect.plain
        if plain.reading not in probed:
            probed[plain.reading] = _changes(problem, base, plain, without)
        found += _propose(problem, base, effect, known, probed[plain.reading])
    return found


def _changes(problem: Problem, base: Fit, effect: Part, without: Sequence[Eliminated]) -> list[Array]:
    """For each run (n, S A): what each of A amplitudes alone makes of the residuals, as large as in each of S probes."""
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
    whole = base.hypothesis.with_part(effect)
    new = whole.parameters[len(base.values) :]
    amplitudes, probes = _amplitudes(new), _probes(new)
    every = np.concatenate([problem.as_read(whole, new, run, own) for own, run in zip(seen, problem.runs, strict=True)])
    answers: dict[tuple[float, ...], tuple[float, Array]] = {}  # the best for each set of shape parameters
    for n, probe in enumerate(probes):
        changes = every[:, n * len(amplitudes) : (n + 1) * len(amplitudes)]
        if not np.isfinite(changes).all():
            continue
        answer = _linear_propose(base, whole, np.append(base.values, probe), known, changes)
        shape = tuple(value for value, fact in zip(probe, new, strict=True) if not fact.amplitude)
        answers[shape] = max(answer, answers.get(shape, answer), key=lambda each: each[0])
    best = _distinct(answers)[:_STARTS]
    return [Proposal(whole, tuple(start for _, start in best), best[0][0])] if best else []


def _amplitudes(facts: Sequence[Parameter]) -> list[int]:
    """Which of an effect's parameters are amplitudes; the first, where none is."""
    return [k for k, fact in enumerate(facts) if fact.amplitude] or [0]


def _at_rest(facts: Sequence[Parameter], values: Array) -> Array:
    """Values with the amplitudes neutral."""
    return np.array([fact.neutral if fact.amplitude else value for fact, value in zip(facts, values, strict=True)])


def _distinct(answers: dict[tuple[float, ...], tuple[float, Array]]) -> list[tuple[float, Array]]:
    """The best first; of those that share their first shape parameter (where a local defect is), only the best."""
    found: dict[tuple[float, ...], tuple[float, Array]] = {}
    for shape, answer in sorted(answers.items(), key=lambda each: -each[1][0]):
        found.setdefault(shape[:1], answer)
    return list(found.values())


def _starts(problem: Problem, proposal: Proposal) -> tuple[Array, ...]:
    """Of each of the proposed values, and those in the next valleys, the one that simulates best; then the best of the others.

    The best of the group that is always tried is among them, however far it is from what was recorded.
    """
    groups, tried = zip(*proposal.hypothesis.tried_from(proposal.starts), strict=True)
    points, squares = np.array(tried), []
    for run, seen in zip(problem.runs, problem.probe(proposal.hypothesis.rough, points), strict=True):
        missed = np.nan_to_num(seen - run.compared[:, None], nan=problem.worst)
        squares.append(np.where(np.isfinite(run.compared[:, None]), missed**2, 0.0).sum(axis=(0, 2, 3)))
    sizes = np.sqrt(np.sum(squares, axis=0))
    order = [int(k) for k in np.argsort(sizes, kind="stable")]
    first: dict[int, int] = {}  # a local defect is looked for in two places, not twice in the one that looks best
    for k in order:
        first.setdefault(groups[k], k)
    ranked = [*first.values(), *(k for k in order if k not in first.values())]
    chosen = [k for k in ranked[:_STARTS] if sizes[k] <= _WORSE * sizes[order[0]]]
    if ALWAYS in first and first[ALWAYS] not in chosen:
        chosen.append(first[ALWAYS])
    return tuple(points[k] for k in chosen)


def quick_fit(problem: Problem, base: Fit, proposal: Proposal) -> Fit:
    """A quick fit from the best of a proposal's starts, to some of the runs; the best of them."""
    problem, base = _thinned(problem, base)
    answers = [fit(problem, proposal.hypothesis.rough, start=start, quick=True) for start in _starts(problem, proposal)]
    return replace(min(answers, key=lambda fitted: fitted.rms), hypothesis=proposal.hypothesis)


def looked_at(problem: Problem) -> list[int]:
    """Which of the runs probes and quick fits look at: of many some in which little moves, some in which much does.

    A stop that is met in two trials of ten is not to be looked for in the others.
    """
    by_size = np.argsort([run.moved for run in problem.runs], kind="stable")
    chosen = np.linspace(0, len(by_size) - 1, min(_ENOUGH, len(by_size))).round().astype(int)
    return sorted(by_size[chosen].tolist())


def _thinned(problem: Problem, base: Fit) -> tuple[Problem, Fit]:
    """Some of the samples of some of the runs, and a fit as it stands on them."""
    thin, kept = _some_of(problem), looked_at(problem)

    def some(items: tuple[Array, ...]) -> tuple[Array, ...]:
        return tuple(items[k][:: run.every] for k, run in zip(kept, thin.runs, strict=True))

    fewer = replace(
        base,
        residuals=some(base.residuals),
        missed=some(base.missed),
        slopes=some(base.slopes),
        weights=some(base.weights),
        nuisance=tuple(each[..., : thin.own(run)] for run, each in zip(thin.runs, some(base.nuisance), strict=True)),
    )
    return thin, fewer


@lru_cache(maxsize=2)
def _some_of(problem: Problem) -> Problem:
    """Some of the samples of some of the runs; the same at every call, which keep what they find out."""
    return problem.some(looked_at(problem), _SAMPLES)


def _probes(facts: Sequence[Parameter]) -> list[Array]:
    """Values of an effect's parameters: a small amplitude, at a few values of each shape parameter."""
    shapes = [fact.across if not fact.amplitude else [0.0] for fact in facts]
    shaped = any(not fact.amplitude for fact in facts)
    sizes = [n for n in (_SHAPED if shaped else _PROBES) if n < 1 or all(_holds(fact, n) for fact in facts if fact.amplitude)]
    return [
        np.array([f.neutral + size * f.scale if f.amplitude else at for f, at in zip(facts, shape, strict=True)])
        for size in sizes
        for shape in itertools.product(*shapes)
    ]


def _holds(fact: Parameter, size: float) -> bool:
    """Whether an amplitude of so many scales is within the bounds."""
    return fact.neutral + size * fact.scale <= fact.upper


class _Known:
    """What the open parameters of a fit make of its residuals (n,), for derivatives (n, P)."""

    def __init__(self, residual: Array, slopes: Array) -> None:
        size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
        basis, strength, mix = np.linalg.svd(slopes / size, full_matrices=False)
        told = strength > _BLIND * strength.max(initial=0.0)
        self._basis, self._back = basis[:, told], (mix[told] / strength[told, None]).T / size[:, None]
        self.residual, self.left = residual, self.without(residual)

    def without(self, rows: Array) -> Array:
        """(n, ...) what no change of theirs takes away."""
        return np.asarray(rows - self._basis @ (self._basis.T @ rows))

    def step(self, rows: Array) -> Array:
        """(P,) the change that takes most of (n,) away."""
        return np.asarray(-self._back @ (self._basis.T @ rows))


def _linear_propose(base: Fit, hypothesis: Hypothesis, start: Array, known: _Known, changes: Array) -> tuple[float, Array]:
    """The predicted gain, and the values (P,) that should bring it.

    ``changes`` (n, A): what each amplitude alone makes of the residuals (n,), as large as it is in ``start`` (P,).
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
    gain = 1 - float(left @ left) / float(known.residual @ known.residual)
    return max(0.0, gain), np.asarray(np.clip(values, lower, upper))


def _allowed(fact: Parameter, wanted: float, farthest: float) -> float:
    """The amplitude, over its scale, nearest to the wanted one that is within bounds, not farther away, and not neutral itself.

    On the neutral value shape parameters have no derivative, and a fit that starts there cannot move them.
    """
    lowest = max(-farthest, (fact.lower - fact.neutral) / fact.scale)
    highest = min(farthest, (fact.upper - fact.neutral) / fact.scale)
    amplitude = float(np.clip(wanted, lowest, highest))
    return amplitude if abs(amplitude) > 0.1 else float(np.copysign(0.1, amplitude if lowest < 0 else 1.0))
