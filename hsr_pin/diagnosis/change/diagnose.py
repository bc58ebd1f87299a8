"""What has changed between two recordings of one arm."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from hsr_pin.diagnosis.change.chance import chance
from hsr_pin.diagnosis.change.fitting import Bench, Fitted, Guess, refined
from hsr_pin.diagnosis.change.frame import Frame, framed
from hsr_pin.diagnosis.change.pair import Pair, pair
from hsr_pin.diagnosis.change.placing import PLACING, BaseRotation, turns_cameras
from hsr_pin.diagnosis.change.reference import described
from hsr_pin.diagnosis.change.suspects import Suspect, suspects
from hsr_pin.diagnosis.change.verdict import ChangeVerdict, Found, judge, needed
from hsr_pin.diagnosis.diagnose import catalogue, refuse_formless
from hsr_pin.diagnosis.next_experiment import Proposal, propose
from hsr_pin.effects import Effect, effect_named
from hsr_pin.effects.catalogue import laws
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, moves, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.part import Part
from hsr_pin.inference import Data, Loss
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.parallel import workers
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import Placement
from hsr_pin.simulation.compiled import ready
from hsr_pin.trajectory import Dataset

#: Changes that get a fit, and those of which it is looked what OLD shows by chance.
_FITTED, _LOOKED = 14, 10
#: Changes that are fitted once more, with the model as it is after them.
_SETTLED = 5
#: Of these it is told how small a change would have shown.
_ALWAYS = (("keq_scale",), ("damping_scale",))
#: Second changes that get a fit; and pairs of which each is fitted once more alone.
_SECOND, _TWICE = 6, 3
#: Changes that are tried with others; and factors on the damping that are.
_FIRST, _DAMPED = 2, (0.5, 2.0)


@dataclass(frozen=True, eq=False, repr=False)
class ChangeDiagnosis:
    """All that was found.

    Attributes:
        pair: the recordings as they were used.
        reference: the best model of OLD; None where there was too little to fit one.
        verdict: what may be said.
        found: what it rests on; None where there was too little.
        next_experiment: what to record next where it is ambiguous, the most telling first.
    """

    pair: Pair
    reference: Candidate | None
    verdict: ChangeVerdict
    found: Found | None = None
    next_experiment: tuple[Proposal, ...] = ()

    def __repr__(self) -> str:
        return f"<ChangeDiagnosis of {self.pair.new.dataset.name}: {self.verdict.status}. {self.verdict.sentence}>"


def diagnose_change(
    new: Dataset | str | Path,
    old: Dataset | str | Path,
    *,
    reference: Candidate | None = None,
    effects: Sequence[str] | None = None,
    max_effects: int = 3,
    max_changes: int = 2,
    links: int | None = None,
    placement: Placement | None = None,
    delay: float = 0.0,
    jobs: int | None = None,
    cluster: str | None = None,
    loss: Loss | None = None,
    seed: int = 0,
    tell: Callable[[str], None] = lambda line: None,
    advance: Callable[[], None] = lambda: None,
) -> ChangeDiagnosis:
    """Say what has changed in an arm between two recordings of it.

    NEW is judged relative to the best model of OLD and to what that model lacks: what both recordings have in common, be it
    explained or not, is no change.

    Args:
        new: at least one trial in which the arm moves; or the folder that holds it.
        old: at least two; likewise.
        reference: the best model of OLD, where it is known from another comparison with it.
        effects: names of the effects that may have changed, beside stiffness and damping; default: the whole catalogue, the arm's
            other numbers, and how the arm is seen.
        max_effects: with which OLD is described, at most.
        max_changes: at most this many together.
        links: of the chain that is fitted; default: 16, or as many as simulated the first dataset.
        placement: of its joints; default: in the middle of each element, or as in the simulation.
        delay: trials that start from a pose are followed only from so long after their declared start [s].
        jobs: processes; default: one per core.
        cluster: address of a Dask scheduler whose workers do it instead.
        loss: what each report gains where it is right and loses where it is not; default: the table of :class:`Loss`.
        seed: of the ways to part the first recording.
        tell: called with a line at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: the datasets are not of one arm, nothing in them can be compared, or an argument is out of range.
        EffectError: an unknown effect.
    """
    if max_changes < 1:
        raise IdentificationError("max_changes", expected="one or more", received=max_changes)
    tell("reading the recordings")
    first, second = (each if isinstance(each, Dataset) else read_dataset(each) for each in (old, new))
    both = pair(prepare(first, delay=delay), prepare(second, delay=delay))
    space = len(both.experiment.directions) > 1
    causes = [kind for kind in laws(space=space) if not kind.flexible]
    candidates = _parts(both.experiment, causes, effects)
    lacking = _insufficient(both)
    if lacking:
        return ChangeDiagnosis(both, None, ChangeVerdict("insufficient", (), (), lacking))
    ready(causes, space=space)
    with workers(jobs, cluster) as executor:
        if reference is None:
            pool = FitPool(both.old, executor, advance=advance)
            parts = catalogue(causes, both.old)
            model = Hypothesis(**chain_of(first, links, placement))
            reference = described(both.old, model, parts, pool, max_effects=max_effects, seed=seed, tell=tell)
        tell("what it does not describe")
        frame, before = framed(both, reference.fit.hypothesis, reference.fit.values)
        tell("what may have changed")
        there = {part.reading for part in frame.hypothesis.parts}
        if effects is None:
            candidates = [part for part in candidates if _may_change(part, there)]
        asked = suspects(frame.hypothesis, frame.values, candidates)
        bench = Bench(frame, executor)
        guesses = bench.guessed(asked)
        plain = [guess for guess in guesses[_FITTED:] if guess.suspect.names in _ALWAYS]
        single = bench.refined([*guesses[:_FITTED], *plain])
        several = _several(bench, frame, _distinct(single), asked) if max_changes > 1 else []
        single = _distinct([*single, *bench.refined(_alone(several, single))])
    best = _distinct([*single, *_needed(frame, single[0], several)])
    told = (single[0].suspect.names, *_ALWAYS)
    shown = [*best[:_SETTLED], *(each for each in best[_SETTLED:] if each.suspect.names in told)]
    looked = list(dict.fromkeys([*best[:_LOOKED], *shown]))
    found = Found(
        frame,
        tuple(_settled(frame, each) for each in shown),
        chance(frame, before, looked, seed),
        _was(reference, frame),
    )
    verdict = judge(found, loss)
    return ChangeDiagnosis(both, reference, verdict, found, _proposals(found, verdict))


def _insufficient(both: Pair) -> str:
    """What is lacking, and what to record; empty if nothing is."""
    for name, each, least in (("first", both.old, 2), ("second", both.new, 1)):
        moving = sum(moves(run, each.noise) for run in each.runs)
        if moving < least:
            return (
                f"In {moving} of {len(each.runs)} usable trials of the {name} recording ({each.dataset.name}) the arm moves; at "
                f"least {least} {'are' if least > 1 else 'is'} needed: what one trial has of its own must be known from another."
            )
    return ""


def _parts(experiment: Experiment, causes: Sequence[type[Effect]], names: Sequence[str] | None) -> list[Part]:
    """What may appear, in every reading."""
    lies = experiment.dataset.mount == "horizontal"
    if names is None:
        arm = catalogue(causes, experiment)
        placing = [kind for kind in PLACING.values() if not (lies and kind is BaseRotation)]
        return [*arm, *catalogue(placing, experiment, plain=())]
    chosen = [PLACING[name] if name in PLACING else effect_named(name) for name in dict.fromkeys(names)]
    refuse_formless(chosen, space=len(experiment.directions) > 1)
    if lies and BaseRotation in chosen:
        raise IdentificationError("effects", expected="base_tilt, of an arm that lies", received=BaseRotation.name)
    return catalogue(chosen, experiment, plain=())


def _may_change(part: Part, there: Collection[object]) -> bool:
    """Whether a part is not what `frame_turn` says; where OLD is described by it, it may grow under its own name as well."""
    return not turns_cameras(part.effect) or part.reading in there


def _distinct(fits: Sequence[Fitted]) -> list[Fitted]:
    """The best reading of each, the best first."""
    first: dict[tuple[str, ...], Fitted] = {}
    for fitted in sorted(fits, key=lambda each: each.square):
        first.setdefault(fitted.suspect.names, fitted)
    return list(first.values())


def _several(bench: Bench, frame: Frame, single: Sequence[Fitted], asked: Sequence[Suspect]) -> list[Fitted]:
    """Two changes together, if what the best of one leaves asks for it."""
    best = single[0]
    left, least = _rest(frame, best)
    if left < least:
        return []
    damping = next(each for each in asked if each.names == ("damping_scale",))
    swings = [replace(best, suspect=damping, after=factor * damping.start) for factor in _DAMPED]
    firsts = [*single[:_FIRST], *swings]  # a swing that dies out sooner hides every change of its time
    guesses = []
    for first in firsts:
        apart = [other for other in asked if other.names != first.suspect.names]
        others = [replace(first.suspect.together(other), probes=other.probes) for other in apart]
        guesses += bench.guessed(others, first)[:_SECOND]
    return bench.refined(sorted(guesses, key=lambda guess: guess.square)[: 2 * _SECOND])


def _rest(frame: Frame, best: Fitted) -> tuple[float, float]:
    """Squares that one change leaves in NEW beyond noise, and how many of them another must take away to be noticed."""
    new = frame.run >= len(frame.pair.old.runs)
    count = int(new.sum())
    return float((best.residual[new] ** 2).sum()) - count, needed(Data(1.0, count))


def _alone(several: Sequence[Fitted], single: Sequence[Fitted]) -> list[Guess]:
    """Each of two changes, from where it ended beside the other: a law with a shape fits well in more than one place."""
    known = {each.suspect.names: each.suspect for each in _distinct(single)}
    guesses = []
    for both in several[:_TWICE]:
        for suspect in (known[(name,)] for name in both.suspect.names if (name,) in known):
            if len(suspect.open) > 1 and set(suspect.open) <= set(both.suspect.open):
                start = both.after[[both.suspect.open.index(name) for name in suspect.open]]
                guesses.append(Guess(suspect, (start,), both.square))
    return guesses


def _needed(frame: Frame, best: Fitted, several: Sequence[Fitted]) -> list[Fitted]:
    """Those of two changes that take away what would be noticed of what the best of one leaves."""
    _, least = _rest(frame, best)
    return [each for each in several if best.square - each.square > least and each.apart(best) >= frame.pair.worth]


def _settled(frame: Frame, fitted: Fitted) -> tuple[Fitted, Frame]:
    """A change fitted once more, on the full chain, with what is shared as it acts after the change; and that frame."""
    suspect = fitted.suspect
    there = frame.at(suspect.hypothesis, suspect.values(fitted.after[None])[0])
    return refined(there, Guess(suspect, (fitted.after,), fitted.square), fine=True), there


def _was(reference: Candidate, frame: Frame) -> dict[str, tuple[float, float]]:
    """95 % intervals of the values of OLD's model; what is declared is known to be that."""
    names, intervals = reference.fit.hypothesis.free, uncertainty(reference.fit).interval
    return {name: (1.0, 1.0) for name in frame.hypothesis.free} | {
        name: (float(low), float(high)) for name, (low, high) in zip(names, intervals, strict=True)
    }


def _proposals(found: Found, verdict: ChangeVerdict) -> tuple[Proposal, ...]:
    """Where the alternatives differ most."""
    if verdict.status != "ambiguous":
        return ()
    chosen = [found.fit_of(names) for names in verdict.alternatives]
    rivals = [(each.suspect.hypothesis, each.suspect.values(each.after[None])[0]) for each in chosen]
    return propose(found.frame.pair.new, rivals)
