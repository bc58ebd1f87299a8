"""Which effects: added one at a time, a few of the best sets carried on side by side, judged on held-out trials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Protocol

from hsr_pin.diagnosis.candidates import Candidate, Guess, glanced
from hsr_pin.diagnosis.evidence import certainly_better, squares, structure
from hsr_pin.effects.effect import Effect
from hsr_pin.identification.evaluation import rms
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.uncertainty import uncertainty

#: Of all effects, those that a probe predicts to help most get a quick fit, at most this many ...
GLANCES = 12
#: ... and at least this share of the best's predicted gain.
PROMISING = 0.03
#: Two readings of one law whose predicted gains differ by less than this are the same on these recordings.
ALIKE = 1e-6
#: The best of these get a full fit: the first few in any case; more, up to a limit, if their RMS is within this factor of the
#: best, and if they take away at least this share of what would be worth having.
FINISHED, AT_MOST, CLOSE, HOPEFUL = 3, 6, 1.2, 0.5
#: Sets carried on to the next rung, and quick fits for each.
BEAM, BEAM_GLANCES = 3, 5

#: Of a gap that is explained, this many times what is too small to ask about is no reason to look for more.
CORNER = 2.0
#: An effect is named only if its amplitude is at least so many standard errors away from neutral. Fits are sure of a law that is
#: in the recordings; one that is stretched over another's traces rests on a few samples.
SURE = 8.0
#: Where two effects leave a larger share of the squared gap than this, no third is looked for.
HOPELESS = 0.5

#: The effects of a model, each with its options.
Key = tuple[tuple[str, object], ...]


@dataclass(frozen=True)
class Thresholds:
    """What counts.

    Attributes:
        noise: [m] RMS distance that noise alone leaves.
        worth: [m] an effect is worth having if it takes this much RMS distance away (square root of the drop of the mean square).
        closed: [m] an RMS distance beyond noise that is too small to ask about.
        explained: largest share of the squared gap that may be left when effects are said to explain it ...
        corner: ... and the largest RMS distance, over the one that is too small to ask about.
        substantial: share of the squared gap that an effect must take away if it leaves more than this share of what the others
            leave: it may be what is wrong with another effect's law.
    """

    noise: float
    worth: float
    closed: float
    explained: float = 0.03
    corner: float = 5.0
    substantial: float = 0.10

    @classmethod
    def of(cls, noise: float, length: float) -> Thresholds:
        """For a noise floor [m] and an arm of this length [m]."""
        return cls(noise, worth=max(0.4 * noise, 1e-3 * length), closed=max(0.3 * noise, 0.75e-3 * length))


class Workers(Protocol):
    """Does the same to many things, perhaps side by side."""

    def guess(self, base: Candidate, effects: Sequence[Effect]) -> list[Guess]:
        """First guesses for adding each effect."""

    def glance(self, tasks: Sequence[tuple[Fit, Guess]]) -> list[Fit]:
        """A quick fit for each guess about a base fit."""

    def finish(self, tasks: Sequence[tuple[Fit, Fit]]) -> list[Candidate]:
        """A candidate for each quick fit, with the fit it is based on before it."""


@dataclass(frozen=True, eq=False)
class Search:
    """What the search did.

    Attributes:
        path: the models on the way from the one without effects to the best, each with the effects of the one before.
        tried: every model that was fitted.
    """

    path: tuple[Candidate, ...]
    tried: tuple[Candidate, ...]

    @property
    def best(self) -> Candidate:
        """Where the path ends."""
        return self.path[-1]


def mean_square(candidate: Candidate) -> float:
    """[m^2] on held-out trials."""
    return squares(candidate.heldout).mean


def left(candidate: Candidate) -> float:
    """[m^2] mean square on held-out trials that is not noise."""
    return structure(candidate.heldout)


def explains(candidate: Candidate, base: Candidate, thresholds: Thresholds) -> bool:
    """Whether a model leaves next to nothing: of noise, or of a large gap."""
    rest, closed = left(candidate), thresholds.closed**2
    return rest <= closed or (rest <= thresholds.explained * left(base) and rest <= thresholds.corner**2 * closed)


def doubtful(candidate: Candidate, least: float = SURE) -> tuple[str, ...]:
    """Effects of a fitted model whose amplitudes are all less than so many standard errors away from neutral."""
    fit = candidate.fit
    facts, errors = fit.hypothesis.parameters, uncertainty(fit).standard_error
    clear = {
        fact.name.split(".")[0]
        for fact, value, error in zip(facts, fit.values, errors, strict=True)
        if fact.amplitude and abs(value - fact.neutral) >= least * error
    }
    return tuple(name for name in candidate.names if name not in clear)


def worth_having(worse: Candidate, better: Candidate, thresholds: Thresholds, seed: int) -> bool:
    """Whether a gain is both certain and worth having."""
    much = mean_square(worse) - mean_square(better) >= thresholds.worth**2
    return much and certainly_better(better.heldout, worse.heldout, seed)


def search(
    start: Candidate,
    effects: Sequence[Effect],
    thresholds: Thresholds,
    workers: Workers,
    *,
    max_effects: int = 3,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
) -> Search:
    """Add effects to a fitted model as long as one is worth having.

    Args:
        start: the model without effects, K and C fitted.
        effects: the catalogue, each with the options it is to be tried with.
        thresholds: what counts.
        workers: who does the fitting.
        max_effects: at most this many.
        seed: of the resampling.
        tell: called at each rung.
    """
    path, beam = [start], [start]
    tried: dict[Key, Candidate] = {(): start}
    while len(path) <= max_effects and _is_open(path, thresholds):
        tell(f"effect {len(path)}: trying {len(effects)} candidates")
        new = _extend(beam, effects, workers, tried, thresholds)
        tried |= {key(candidate): candidate for candidate in new}
        better = sorted((c for c in new if mean_square(c) < mean_square(path[-1])), key=mean_square)
        good = [c for c in better if worth_having(path[-1], c, thresholds, seed)]
        if not good:
            break
        path.append(good[0])
        beam = _distinct(better)[:BEAM]  # one whose own gain is not certain may be half of a pair
    best = _pruned(path[-1], start, tried, thresholds, workers, seed)
    if len(best.names) > 1:
        tell("exchange: each effect found against the others")
        other = _exchanged(best, effects, workers, tried, thresholds)
        best = best if other is best else _pruned(other, start, tried, thresholds, workers, seed)
    return Search(_nested(best, start, list(tried.values())), tuple(tried.values()))


def _is_open(path: Sequence[Candidate], thresholds: Thresholds) -> bool:
    """Whether to look for another effect: more is left than the last corner of a large gap, and there is hope."""
    gap, rest = left(path[0]), left(path[-1])
    if rest <= thresholds.closed**2 or (rest <= thresholds.explained * gap and rest <= (CORNER * thresholds.closed) ** 2):
        return False
    return len(path) < 3 or rest <= HOPELESS * gap


def key(candidate: Candidate) -> Key:
    """The effects of a candidate and the options they were tried with."""
    return _key(candidate.fit)


def _key(fit: Fit) -> Key:
    return tuple(sorted((effect.name, effect.options) for effect in fit.hypothesis.effects))


def _extend(
    beam: Sequence[Candidate],
    effects: Sequence[Effect],
    workers: Workers,
    tried: dict[Key, Candidate],
    thresholds: Thresholds,
) -> list[Candidate]:
    chosen: dict[Key, tuple[Fit, Guess]] = {}
    for base in beam:
        open_effects = [effect for effect in effects if effect.name not in base.names]
        ranked = _told_apart(sorted(workers.guess(base, open_effects), key=lambda guess: -guess.gain))
        for guess in ranked[: GLANCES if len(beam) == 1 else BEAM_GLANCES]:
            if guess.gain < PROMISING * ranked[0].gain:
                break
            name = tuple(sorted((effect.name, effect.options) for effect in guess.hypothesis.effects))
            if name not in tried:
                chosen.setdefault(name, (base.fit, guess))
    tasks = list(chosen.values())
    quick = sorted(zip((base for base, _ in tasks), workers.glance(tasks), strict=True), key=lambda pair: pair[1].rms)
    so_far = min(rms([base.fit.residuals[k] for k in glanced(len(base.fit.residuals))]) for base in beam)
    hopeful = sqrt(max(0.0, so_far**2 - HOPEFUL * thresholds.worth**2))
    limit = min(CLOSE * quick[0][1].rms, hopeful) if quick else 0.0
    return workers.finish(quick[:FINISHED] + [pair for pair in quick[FINISHED:AT_MOST] if pair[1].rms < limit])


def _exchanged(
    best: Candidate, effects: Sequence[Effect], workers: Workers, tried: dict[Key, Candidate], thresholds: Thresholds
) -> Candidate:
    """The best of as many effects after each of them had to stand against all others beside the rest.

    One that was good alone may be a stand-in beside the other, whose partner was never tried with it.
    """
    fewer = [tried[_key(_without(best.fit, effect))] for effect in best.fit.hypothesis.effects]
    new = _extend(fewer, effects, workers, tried, thresholds)
    tried |= {key(candidate): candidate for candidate in new}
    return min((best, *new), key=mean_square)


def _told_apart(guesses: Sequence[Guess]) -> list[Guess]:
    """The first of each reading of a law; the others make no difference, as where a law differs for torques that never came."""
    kept: list[Guess] = []
    for guess in guesses:
        name = guess.hypothesis.effects[-1].name
        if not any(other.hypothesis.effects[-1].name == name and abs(other.gain - guess.gain) < ALIKE for other in kept):
            kept.append(guess)
    return kept


def _pruned(
    best: Candidate, start: Candidate, tried: dict[Key, Candidate], thresholds: Thresholds, workers: Workers, seed: int
) -> Candidate:
    """The best without the effects that, now that the others are there, are not worth having: stand-ins on the way to them.

    Nor is one of doubtful size, nor one that takes a little of what the others leave: it mends what is wrong with another's law.
    """
    while len(best.names) > 1:
        smaller = [_without(best.fit, effect) for effect in best.fit.hypothesis.effects]
        new = workers.finish([(start.fit, fit) for fit in smaller if _key(fit) not in tried])
        tried |= {key(candidate): candidate for candidate in new}
        unsure = doubtful(best)
        spare = [
            fewer
            for fewer in (tried[_key(fit)] for fit in smaller)
            if not set(unsure) <= set(fewer.names)
            or not worth_having(fewer, best, thresholds, seed)
            or _patches(best, fewer, start, thresholds)
        ]
        if not spare:
            break
        best = min(spare, key=mean_square)
    return best


def _patches(best: Candidate, fewer: Candidate, start: Candidate, thresholds: Thresholds) -> bool:
    little = left(fewer) - left(best) < thresholds.substantial * left(start)
    return little and left(best) > max(thresholds.closed**2, thresholds.substantial * left(fewer))


def _without(fit: Fit, effect: Effect) -> Fit:
    """A place to start from for the model without one of its effects."""
    model = fit.hypothesis
    kept = [k for k, name in enumerate(model.free) if not name.startswith(f"{effect.name}.")]
    effects = tuple(other for other in model.effects if other.name != effect.name)
    fewer = replace(model, effects=effects, free=tuple(model.free[k] for k in kept))
    return replace(fit, hypothesis=fewer, values=fit.values[kept])


def _nested(best: Candidate, start: Candidate, tried: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """From the model without effects to the best, through the best of the fitted models whose effects the best has too.

    The search may pass through an effect that a better pair replaces; that one has no place on the way to the pair.
    """
    path = [best]
    while len(path[0].names) > 1:
        inside = [c for c in tried if c.names and set(c.names) < set(path[0].names)]
        if not inside:
            break
        largest = max(len(c.names) for c in inside)
        path.insert(0, min((c for c in inside if len(c.names) == largest), key=mean_square))
    return tuple(path) if best is start else (start, *path)


def _distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The first of each set of names: options of one law do not crowd the beam."""
    first: dict[tuple[str, ...], Candidate] = {}
    for candidate in candidates:
        first.setdefault(candidate.names, candidate)
    return list(first.values())
