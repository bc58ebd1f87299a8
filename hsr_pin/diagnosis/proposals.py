"""What may be added to a fitted model, where its fit would start, and how much it promises: probes and quick fits."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hsr_pin.identification.evaluation import Case, respond_each
from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.fit import Fit, fit
from hsr_pin.identification.hypothesis import ARM, Hypothesis, Part
from hsr_pin.identification.nuisance import Eliminated
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
#: Factors on the damping and the amplitude of a initial estimate at which it is tried too: an effect may grow faster than its
#: amplitude; without it, the damping stood in for it, and a fit may stay in that valley.
_VALLEYS = ((1.0, 1.0), (1.0, 0.5), (0.5, 2.0), (0.2, 6.0))
#: Factors on the damping, and sizes over their scale up to the width of the prior, of laws that make the torque late.
_LATE = ((0.5, 0.2), (0.6, 1.5, 5.0))
#: Groups of such starts; the others are numbered by the proposed values that they come from.
_DAMPED, _DECLARED = -1, -2
#: A start whose misfit is more than this many times that of the best is dropped.
_WORSE = 2.0
#: Links and error of a step [m at the tip] of the chain that is screened.
_LINKS, _TOLERANCE = 8, 5e-4
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


def proposals(experiment: Experiment, base: Fit, effects: Sequence[Part]) -> list[Proposal]:
    """Proposals for adding one effect to a fitted model, one for each effect, in the order of ``effects``.

    Each effect is probed with a small amplitude (each of them, where it has several) at several values of its shape
    parameters, all in one batch. The change it makes is taken as linear in the amplitudes; those that fit best, with the open
    parameters adjusted along their known derivatives, and the misfit that it should leave, follow from linear least squares.
    """
    experiment, base = _thinned(experiment, base)
    told, without = base.whitened(), [base.eliminated(run) for run in range(len(experiment.runs))]
    residual, slopes = (np.concatenate(part) for part in zip(*told, strict=True))
    known = _Known(residual, slopes * base.hypothesis.scale)
    probed: dict[Part, list[Array]] = {}  # of one size or another an effect changes as much more or less, here or there
    found: list[Proposal] = []
    for effect in effects:
        plain = replace(effect, resized=False, levels=())
        if plain not in probed:
            probed[plain] = _changes(experiment, base, plain, without)
        found += _propose(experiment, base, effect, known, probed[plain])
    return found


def _changes(experiment: Experiment, base: Fit, effect: Part, without: Sequence[Eliminated]) -> list[Array]:
    """For each run (n, S A): what each of A amplitudes alone makes of the residuals, as large as in each of S probes."""
    whole = base.hypothesis.with_part(effect)
    new = whole.parameters[len(base.values) :]
    neutral = np.array([fact.neutral for fact in new])
    alone = [np.where(np.arange(len(new)) == k, probe, _at_rest(new, probe)) for probe in _probes(new) for k in _amplitudes(new)]
    points = np.array([np.append(base.values, values) for values in (neutral, *alone)])
    seen = _side_by_side(experiment, whole, points)
    return [
        free(np.moveaxis(each[:, 1:] - each[:, :1], 1, -1)[w > 0] * w[w > 0][:, None])
        for each, w, free in zip(seen, base.weights, without, strict=True)
    ]


def _propose(experiment: Experiment, base: Fit, effect: Part, known: _Known, seen: Sequence[Array]) -> list[Proposal]:
    whole = base.hypothesis.with_part(effect)
    new = whole.parameters[len(base.values) :]
    amplitudes, probes = _amplitudes(new), _probes(new)
    if effect.resized:
        powers = np.tile([new[k].resizes for k in amplitudes], len(probes))
        levels = [run.trial.keq / experiment.levels[0] for run in experiment.runs]
        seen = [changes * level**powers for changes, level in zip(seen, levels, strict=True)]
    if effect.levels:
        seen = [_where_it_acts(changes, whole, run, new) for changes, run in zip(seen, experiment.runs, strict=True)]
    every = np.concatenate(seen)
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


def _where_it_acts(changes: Array, whole: Hypothesis, run: Run, new: Sequence[Parameter]) -> Array:
    """(n, S A) what each of A sizes makes of a run's residuals, of (n, S) for one: nothing where it is another level's."""
    acts = np.array([whole.acts(fact.name, run) for fact in new])
    return np.asarray(changes[:, :, None] * acts).reshape(len(changes), -1)


def _side_by_side(experiment: Experiment, hypothesis: Hypothesis, points: Array) -> list[Array]:
    """For each run (T, C, M, 2) [m] about where the markers would be with each of the points (C, P)."""
    rough = _rough(hypothesis)
    answers = respond_each(experiment, rough, (Case(run, points) for run in experiment.runs))
    return [answer.positions[..., experiment.axes] for answer in answers]


def _distinct(answers: dict[tuple[float, ...], tuple[float, Array]]) -> list[tuple[float, Array]]:
    """The best first; of those that share their first shape parameter (where a local defect is), only the best."""
    found: dict[tuple[float, ...], tuple[float, Array]] = {}
    for shape, answer in sorted(answers.items(), key=lambda each: -each[1][0]):
        found.setdefault(shape[:1], answer)
    return list(found.values())


def _starts(experiment: Experiment, proposal: Proposal) -> tuple[Array, ...]:
    """Of each of the proposed values, and those in the next valleys, the one that simulates best; then the best of the others.

    Of a law that makes the torque late the best with the declared arm is among them, however far it is from what was recorded.
    """
    moved = [(k, _moved(proposal.hypothesis, start, *factors)) for k, start in enumerate(proposal.starts) for factors in _VALLEYS]
    groups, tried = zip(*moved, *_late(proposal), strict=True)
    points, squares = np.array(tried), []
    for run, seen in zip(experiment.runs, _side_by_side(experiment, proposal.hypothesis, points), strict=True):
        missed = np.nan_to_num(seen - run.compared[:, None], nan=experiment.dataset.length)
        squares.append(np.where(np.isfinite(run.compared[:, None]), missed**2, 0.0).sum(axis=(0, 2, 3)))
    sizes = np.sqrt(np.sum(squares, axis=0))
    order = [int(k) for k in np.argsort(sizes, kind="stable")]
    first: dict[int, int] = {}  # a local defect is looked for in two places, not twice in the one that looks best
    for k in order:
        first.setdefault(groups[k], k)
    ranked = [*first.values(), *(k for k in order if k not in first.values())]
    chosen = [k for k in ranked[:_STARTS] if sizes[k] <= _WORSE * sizes[order[0]]]
    if _DECLARED in first and first[_DECLARED] not in chosen:
        chosen.append(first[_DECLARED])
    return tuple(points[k] for k in chosen)


def _late(proposal: Proposal) -> list[tuple[int, Array]]:
    """Of a law that makes the torque late, values (P,) with much less damping, and with the declared arm; each with its group.

    A strongly damped arm looks late by itself. Seen from there lateness is worth next to nothing, so that its size is none of the
    proposal's.
    """
    facts, part = proposal.hypothesis.parameters, proposal.hypothesis.parts[-1]
    if part.kind != "actuation_time":
        return []
    own = [k for k, fact in enumerate(facts) if fact.amplitude and fact.name.startswith(f"{part.name}.")]
    start, points = proposal.starts[0], []
    declared = np.array([fact.neutral if fact.name.partition("@")[0] in ARM else v for fact, v in zip(facts, start, strict=True)])
    arms = [*((_DAMPED, _moved(proposal.hypothesis, start, damping, 1.0)) for damping in _LATE[0]), (_DECLARED, declared)]
    for (group, arm), size in itertools.product(arms, _LATE[1]):
        point = arm.copy()
        point[own] = [np.clip(facts[k].neutral + size * facts[k].scale / len(own), facts[k].lower, facts[k].upper) for k in own]
        points.append((group, point))
    return points


def _moved(hypothesis: Hypothesis, values: Array, damping: float, amplitude: float) -> Array:
    """Values (P,) with the damping times one factor, and how far amplitudes of the last effect are from neutral times another."""
    moved, last = values.copy(), hypothesis.parts[-1].name
    for index, fact in enumerate(hypothesis.parameters):
        if fact.name.partition("@")[0] == "damping_scale":
            moved[index] *= damping
        elif fact.amplitude and fact.name.startswith(f"{last}."):
            moved[index] = fact.neutral + amplitude * (moved[index] - fact.neutral)
        moved[index] = np.clip(moved[index], fact.lower, fact.upper)
    return moved


def quick_fit(experiment: Experiment, base: Fit, proposal: Proposal) -> Fit:
    """A quick fit from the best of a proposal's starts, to some of the runs; the best of them."""
    experiment, base = _thinned(experiment, base)
    answers = [fit(experiment, _rough(proposal.hypothesis), start=start, quick=True) for start in _starts(experiment, proposal)]
    return replace(min(answers, key=lambda fitted: fitted.rms), hypothesis=proposal.hypothesis)


def _rough(hypothesis: Hypothesis) -> Hypothesis:
    """The same on the chain that is screened."""
    return replace(hypothesis, links=min(_LINKS, hypothesis.links), tolerance=max(_TOLERANCE, hypothesis.tolerance))


def looked_at(experiment: Experiment) -> list[int]:
    """Which of its runs probes and quick fits look at: of many some in which the arm moves little, some in which it moves far.

    A stop that is met in two trials of ten is not to be looked for in the others.
    """
    by_size = np.argsort([run.moved for run in experiment.runs], kind="stable")
    chosen = np.linspace(0, len(by_size) - 1, min(_ENOUGH, len(by_size))).round().astype(int)
    return sorted(by_size[chosen].tolist())


def _thinned(experiment: Experiment, base: Fit) -> tuple[Experiment, Fit]:
    """Some of the samples of some of the runs, and a fit as it stands on them."""
    thin, kept = _some_of(experiment), looked_at(experiment)

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
def _some_of(experiment: Experiment) -> Experiment:
    """Some of the samples of some of the runs; the same at every call, which keep what they find out.

    What a hand may have done is left to full fits: far from the truth it explains a swing as well as what is lacking would.
    """
    runs = (experiment.runs[k] for k in looked_at(experiment))
    few = tuple(replace(run, every=max(1, len(run.time) // _SAMPLES)) for run in runs)
    return replace(experiment, runs=few, hand=False)


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
