"""Diagnosis of the changes between two recordings of one arm."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hsr_pin.diagnosis.change.chance import chance
from hsr_pin.diagnosis.change.fitting import ChangeFitPool, Fitted, InitialEstimate, refined
from hsr_pin.diagnosis.change.frame import Frame, framed
from hsr_pin.diagnosis.change.hypotheses import ChangeHypothesis, change_hypotheses
from hsr_pin.diagnosis.change.mounting import MOUNTING, BaseRotation, turns_cameras
from hsr_pin.diagnosis.change.pair import Pair, pair
from hsr_pin.diagnosis.change.reference import described
from hsr_pin.diagnosis.change.verdict import ChangeEvidence, ChangeVerdict, judge, needed
from hsr_pin.diagnosis.diagnose import catalogue, refuse_unsupported
from hsr_pin.diagnosis.next_experiment import Proposal, propose
from hsr_pin.effects import Effect, effect_named
from hsr_pin.effects.catalogue import laws
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, informative, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.part import Part
from hsr_pin.inference import Data, Loss
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.fit_pool import FitPool
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.parallel import open_executor
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import Placement
from hsr_pin.simulation.compiled import precompile
from hsr_pin.trajectory import Dataset

#: Number of changes that get a fit, and of those whose gain within the reference recording is computed.
_FITTED, _LOOKED = 14, 10
#: Number of changes that are fitted again with the derivatives after the change.
_SETTLED = 5
#: Changes for which the smallest detectable size is always reported.
_ALWAYS = (("keq_scale",), ("damping_scale",))
#: Number of second changes that get a fit, and of pairs of which each change is fitted again alone.
_SECOND, _TWICE = 6, 3
#: Number of changes that are combined with others, and factors on the damping that are combined with others.
_FIRST, _DAMPED = 2, (0.5, 2.0)


@dataclass(frozen=True, eq=False, repr=False)
class ChangeDiagnosis:
    """Result of a comparison of two recordings.

    Attributes:
        pair: the recordings as they were used.
        reference: the best model of the reference recording; None if the data were insufficient.
        verdict: the conclusion.
        found: the evidence for it; None if the data were insufficient.
        next_experiment: proposed experiments if the verdict is ambiguous, the most informative first.
    """

    pair: Pair
    reference: Candidate | None
    verdict: ChangeVerdict
    found: ChangeEvidence | None = None
    next_experiment: tuple[Proposal, ...] = ()

    def __repr__(self) -> str:
        return f"<ChangeDiagnosis of {self.pair.new.dataset.name}: {self.verdict.status}. {self.verdict.sentence}>"

    def to_html(self, path: str | Path) -> None:
        """Write the report into one self-contained HTML file.

        Raises:
            OutputError: the file cannot be written.
        """
        from hsr_pin.diagnosis.change.history import history_of
        from hsr_pin.diagnosis.change.report import write_report

        write_report(history_of([self]), path)

    def to_json(self) -> dict[str, Any]:
        """Return the diagnosis as a dictionary of plain numbers and texts, which ``hsr-diagnose --since --json`` writes."""
        from hsr_pin.diagnosis.change.document import to_json

        return to_json(self)


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
    """Find out what has changed in an arm between two recordings of it.

    The current recording is compared with the prediction of the best model of the reference recording, including the discrepancy
    of that model. What both recordings have in common, explained or not, is no change.

    Args:
        new: the current recording, with at least one trial in which the arm moves, or its folder.
        old: the reference recording, with at least two such trials, or its folder.
        reference: the best model of the reference recording, if it is known from another comparison.
        effects: names of the effects that may have changed, in addition to stiffness and damping; default: the whole catalogue,
            the other parameters of the arm, and the mounting of the base and the cameras.
        max_effects: largest number of effects in the model of the reference recording.
        max_changes: largest number of changes in one hypothesis.
        links: number of links of the fitted chain; default: 16, or that of the simulation that made the reference recording.
        placement: joint placement of the fitted chain; default: in the middle of each element, or as in that simulation.
        delay: trials that start from a pose are used only from this time after their declared start [s].
        jobs: number of processes; default: one per core.
        cluster: address of a Dask scheduler to use instead of local processes.
        loss: gains and losses of a report; default: the table of :class:`Loss`.
        seed: seed of the random splits of the reference recording.
        tell: function that receives a progress message at each stage.
        advance: called after each fit.

    Raises:
        IdentificationError: the datasets are not of one arm, nothing in them can be compared, or an argument is out of range.
        EffectError: an effect is unknown.
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
    precompile(causes, space=space)
    with open_executor(jobs, cluster) as executor:
        if reference is None:
            pool = FitPool(both.old, executor, advance=advance)
            parts = catalogue(causes, both.old)
            model = Hypothesis(**chain_of(first, links, placement))
            reference = described(both.old, model, parts, pool, max_effects=max_effects, seed=seed, tell=tell)
        tell("estimating the model discrepancy")
        frame, before = framed(both, reference.fit.hypothesis, reference.fit.values)
        tell("fitting the change hypotheses")
        there = {part.variant for part in frame.hypothesis.parts}
        if effects is None:
            candidates = [part for part in candidates if _may_change(part, there)]
        asked = change_hypotheses(frame.hypothesis, frame.values, candidates)
        change_pool = ChangeFitPool(frame, executor)
        estimates = change_pool.initial_estimates(asked)
        plain = [estimate for estimate in estimates[_FITTED:] if estimate.change.names in _ALWAYS]
        single = change_pool.refined([*estimates[:_FITTED], *plain])
        several = _several(change_pool, frame, _distinct(single), asked) if max_changes > 1 else []
        single = _distinct([*single, *change_pool.refined(_alone(several, single))])
    best = _distinct([*single, *_needed(frame, single[0], several)])
    always = (single[0].change.names, *_ALWAYS)
    shown = [*best[:_SETTLED], *(each for each in best[_SETTLED:] if each.change.names in always)]
    looked = list(dict.fromkeys([*best[:_LOOKED], *shown]))
    found = ChangeEvidence(
        frame,
        tuple(_settled(frame, each) for each in shown),
        chance(frame, before, looked, seed),
        _was(reference, frame),
    )
    verdict = judge(found, loss)
    return ChangeDiagnosis(both, reference, verdict, found, _proposals(found, verdict))


def _insufficient(both: Pair) -> str:
    """Return the reason why the recordings are insufficient; empty if they are sufficient."""
    for name, each, least in (("first", both.old, 2), ("second", both.new, 1)):
        moving = len(informative(each))
        if moving < least:
            return (
                f"In {moving} of {len(each.runs)} usable trials of the {name} recording ({each.dataset.name}) the arm moves; at "
                f"least {least} {'are' if least > 1 else 'is'} needed, because variations of trials must be known from others."
            )
    return ""


def _parts(experiment: Experiment, causes: Sequence[type[Effect]], names: Sequence[str] | None) -> list[Part]:
    """Return the effects that may appear, in every variant."""
    lies = experiment.dataset.mount == "horizontal"
    if names is None:
        arm = catalogue(causes, experiment)
        placing = [kind for kind in MOUNTING.values() if not (lies and kind is BaseRotation)]
        return [*arm, *catalogue(placing, experiment, plain=())]
    chosen = [MOUNTING[name] if name in MOUNTING else effect_named(name) for name in dict.fromkeys(names)]
    refuse_unsupported(chosen, space=len(experiment.directions) > 1)
    if lies and BaseRotation in chosen:
        raise IdentificationError("effects", expected="base_tilt, for a horizontal arm", received=BaseRotation.name)
    return catalogue(chosen, experiment, plain=())


def _may_change(part: Part, there: Collection[object]) -> bool:
    """Return whether a part may have changed; rotated cameras are covered by `frame_turn` unless the reference has them."""
    return not turns_cameras(part.effect) or part.variant in there


def _distinct(fits: Sequence[Fitted]) -> list[Fitted]:
    """Return the best fit for each set of names, the best first."""
    first: dict[tuple[str, ...], Fitted] = {}
    for fitted in sorted(fits, key=lambda each: each.square):
        first.setdefault(fitted.change.names, fitted)
    return list(first.values())


def _several(
    change_pool: ChangeFitPool, frame: Frame, single: Sequence[Fitted], asked: Sequence[ChangeHypothesis]
) -> list[Fitted]:
    """Return fits of two changes together, if the residuals of the best single change are large enough."""
    best = single[0]
    left, least = _rest(frame, best)
    if left < least:
        return []
    damping = next(each for each in asked if each.names == ("damping_scale",))
    swings = [replace(best, change=damping, after=factor * damping.start) for factor in _DAMPED]
    firsts = [*single[:_FIRST], *swings]  # a change of damping can hide a change of timing
    estimates = []
    for first in firsts:
        second = [other for other in asked if other.names != first.change.names]
        others = [replace(first.change.together(other), probes=other.probes) for other in second]
        estimates += change_pool.initial_estimates(others, first)[:_SECOND]
    return change_pool.refined(sorted(estimates, key=lambda estimate: estimate.square)[: 2 * _SECOND])


def _rest(frame: Frame, best: Fitted) -> tuple[float, float]:
    """Return the squared residuals beyond noise that one change leaves, and the decrease that another change needs."""
    new = frame.run >= len(frame.pair.old.runs)
    count = int(new.sum())
    return float((best.residual[new] ** 2).sum()) - count, needed(Data.of_one_group(1.0, count))


def _alone(several: Sequence[Fitted], single: Sequence[Fitted]) -> list[InitialEstimate]:
    """Return starts of single changes at their values in fits of two changes, because laws with shapes have several optima."""
    known = {each.change.names: each.change for each in _distinct(single)}
    estimates = []
    for both in several[:_TWICE]:
        for change in (known[(name,)] for name in both.change.names if (name,) in known):
            if len(change.open) > 1 and set(change.open) <= set(both.change.open):
                start = both.after[[both.change.open.index(name) for name in change.open]]
                estimates.append(InitialEstimate(change, (start,), both.square))
    return estimates


def _needed(frame: Frame, best: Fitted, several: Sequence[Fitted]) -> list[Fitted]:
    """Return the fits of two changes that improve the best single change significantly."""
    _, least = _rest(frame, best)
    return [each for each in several if best.square - each.square > least and each.distance_to(best) >= frame.pair.reportable]


def _settled(frame: Frame, fitted: Fitted) -> tuple[Fitted, Frame]:
    """Return a change fitted again with the full chain and with derivatives after the change, and the frame of that fit."""
    change = fitted.change
    there = frame.at(change.hypothesis, change.values(fitted.after[None])[0])
    return refined(there, InitialEstimate(change, (fitted.after,), fitted.square), fine=True), there


def _was(reference: Candidate, frame: Frame) -> dict[str, tuple[float, float]]:
    """Return 95 % intervals of the parameters of the reference model; declared parameters are taken as known."""
    names, intervals = reference.fit.hypothesis.free, uncertainty(reference.fit).interval
    return {name: (1.0, 1.0) for name in frame.hypothesis.free} | {
        name: (float(low), float(high)) for name, (low, high) in zip(names, intervals, strict=True)
    }


def _proposals(found: ChangeEvidence, verdict: ChangeVerdict) -> tuple[Proposal, ...]:
    """Return the experiments in which the alternatives differ most."""
    if verdict.status != "ambiguous":
        return ()
    chosen = [found.fit_of(names) for names in verdict.alternatives]
    rivals = [(each.change.hypothesis, each.change.values(each.after[None])[0]) for each in chosen]
    return propose(found.frame.pair.new, rivals)
