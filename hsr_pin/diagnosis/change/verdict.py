"""From fitted changes to what is reported: the posterior over hypotheses of which numbers differ between two recordings.

Residuals of the second recording are whitened by what the first predicts of it, so that noise and scatter have unit variance
there. A hypothesis of a change is a model of these residuals like any other; that nothing has changed is the model without
causes. What the same change would explain between the first recording's own trials is scatter, which is asked of no hypothesis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray

from hsr_pin.diagnosis.change.chance import Chance
from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.frame import Frame
from hsr_pin.diagnosis.change.size import Size, left_out, sizes
from hsr_pin.diagnosis.change.suspects import Suspect
from hsr_pin.diagnosis.change.swing import slack
from hsr_pin.diagnosis.change.words import listed, millimetres, told
from hsr_pin.effects.effect import KINDS
from hsr_pin.inference import Cause, Data, Decision, Loss, Model, Posterior, decide, posterior
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.evidence import variance
from hsr_pin.inference.model import information

#: Where nothing has changed, NEW is no farther from what OLD predicts than this many times the scatter of trials.
_FARTHER = 2.0
#: Share of what OLD does not predict of NEW that may be left where a change is said to explain it.
_REST = 0.1
#: Odds at which a change counts as seen, where it is said how small a change would have been.
_ODDS = 20.0
#: Probabilities below this are not listed.
_LISTED = 0.01


@dataclass(frozen=True)
class Difference:
    """How far NEW is from what OLD predicts, RMS distances [m].

    Attributes:
        before: where nothing is taken to have changed.
        after: with the change.
        scatter: that would be no surprise if nothing had changed.
        share: of the difference, in units of its scatter, that the change explains on trials that it was not fitted to.
    """

    before: float
    after: float
    scatter: float
    share: float


@dataclass(frozen=True)
class ChangeVerdict:
    """What the recordings say of a change.

    Attributes:
        status: "identified", "partly_identified", "ambiguous", "unexplained", "unchanged" or "insufficient".
        effects: names of what is reported as changed, sorted; plain numbers of the arm under their own names.
        alternatives: sets of names that these recordings cannot tell apart, the most probable first.
        sentence: the verdict as a person would say it.
        kinds: of physics that are reported, sorted.
        changes: from what to what, of the best model of the change, then of the alternatives.
        difference: how far NEW is from OLD; None where that could not be told.
        limits: name -> the smallest change that would have been seen; plain numbers: relative.
        confidence: name or kind -> its probability.
        decision: the report that the loss chose; None where nothing was fitted.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str
    kinds: tuple[str, ...] = ()
    changes: tuple[Size, ...] = ()
    difference: Difference | None = None
    limits: Mapping[str, float] = field(default_factory=dict)
    confidence: Mapping[str, float] = field(default_factory=dict)
    decision: Decision | None = None


@dataclass(frozen=True, eq=False)
class Found:
    """What a verdict rests on.

    Attributes:
        frame: what residuals are seen through.
        fits: (change, the frame it was fitted in), the best first; one for each set of names.
        chance: what OLD shows by chance of the most promising changes.
        was: 95 % intervals of the values of OLD's model, by name.
    """

    frame: Frame
    fits: tuple[tuple[Fitted, Frame], ...]
    chance: Chance
    was: Mapping[str, tuple[float, float]]

    @property
    def new(self) -> NDArray[np.bool_]:
        """(n,) which rows are of NEW."""
        return np.asarray(self.frame.run >= len(self.frame.pair.old.runs))

    @property
    def nothing(self) -> float:
        """Sum of the squared residuals where nothing has changed."""
        return float(self.frame.seen @ self.frame.seen)

    def gain(self, fitted: Fitted) -> float:
        """Of the squared residuals, what a change takes away."""
        return self.nothing - fitted.square

    @cached_property
    def data(self) -> Data:
        """The scale of the whitened residuals: unit noise."""
        return Data(1.0, int(self.new.sum()))

    @cached_property
    def sizes(self) -> dict[tuple[str, ...], tuple[Size, ...]]:
        """Of each of the fits, by its names."""
        return {f.suspect.names: sizes(frame, f, self.was, max(1.0, self.chance.inflation)) for f, frame in self.fits}

    @cached_property
    def posterior(self) -> Posterior:
        """Over all changes that move the markers by what can be reported, and that nothing has changed."""
        least = min([self.nothing, *(fitted.square for fitted, _ in self.fits)])
        expected = len(self.frame.seen) * self._noisier
        floor = max(0.0, least - expected)  # left by all, beyond what noise leaves

        def misfit(square: float) -> float:
            return max(square - least + floor, self.chance.largest) / self.data.count

        models = [Model((), misfit(self.nothing), np.zeros(0), np.zeros(0))]
        seen: dict[int, Suspect | None] = {id(models[0]): None}
        for fitted, _ in self.fits:
            if fitted.rms >= self.frame.pair.worth:
                models.append(_model(fitted, misfit(fitted.square), {size.name for size in self.reported(fitted)}))
                seen[id(models[-1])] = fitted.suspect

        def special_case(one: Model, other: Model) -> bool:
            return _special_case(seen[id(one)], seen[id(other)])

        return posterior(models, self.data, calibrated(), special_case)

    @property
    def _noisier(self) -> float:
        """Mean square of OLD's residuals, at least 1: what its own trials leave is expected of NEW."""
        old = self.frame.seen[~self.new]
        return max(1.0, float(np.mean(old**2)))

    def reported(self, fitted: Fitted) -> tuple[Size, ...]:
        """What is reported of a change: no damping that a swing at another rate may make."""
        found = self.sizes[fitted.suspect.names]
        own = [size for size in found if size.parameter == "damping_scale" and size.step is not None]
        if not own or len(fitted.suspect.names) < 2 or own[0].step is None:
            return found
        (low, high), (least, most) = own[0].step, slack(self.frame.pair, fitted)
        return tuple(size for size in found if size is not own[0]) if least < most and low <= most and high >= least else found

    def fit_of(self, names: tuple[str, ...]) -> Fitted:
        """The best fit in which just these have changed."""
        own = [fitted for fitted, _ in self.fits if tuple(sorted({s.name for s in self.reported(fitted)})) == names]
        return min(own, key=lambda fitted: fitted.square)

    def difference(self, fitted: Fitted) -> Difference:
        """How far a change brings NEW to what OLD predicts."""
        frame = next(frame for each, frame in self.fits if each is fitted)
        _, residual = left_out(frame, fitted)
        was, is_, least = (float((each[self.new] ** 2).sum()) for each in (self.frame.seen, residual, fitted.residual))
        beyond = max(0.0, least - self.data.count * self._noisier)
        share = (was - is_) / max(self.gain(fitted) + beyond, was - is_, 1e-300)
        return Difference(self.frame.off(), frame.off(fitted.moved), self.frame.scatter, float(np.clip(share, 0.0, 1.0)))

    @property
    def needed(self) -> float:
        """Gain from which on a change of one number would be more probable than none by odds of twenty to one."""
        return needed(self.data, self.chance.largest / self.data.count)


def needed(data: Data, scatter: float = 0.0) -> float:
    """Of the squared residuals, what one cause must take away to be more probable than none by odds of twenty to one.

    Args:
        data: their scale.
        scatter: mean square that is asked of no change.
    """
    numbers = calibrated()
    return data.count * variance(scatter, data, numbers) * (exp(2 * (numbers.cause + log(_ODDS)) / numbers.samples) - 1)


def _model(fitted: Fitted, misfit: float, names: set[str]) -> Model:
    """A change as the judgement sees it; the prior of a number is about what it was."""
    facts, suspect = fitted.suspect.facts, fitted.suspect
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fitted.after, strict=True)])
    steps = [
        log(max(after, 1e-9) / before) / fact.ratio_width if fact.ratio_width is not None else (after - before) / width * sized
        for fact, after, before, width, sized in zip(facts, fitted.after, suspect.start, widths, suspect.sizes, strict=True)
    ]
    causes = tuple(Cause(name, kind) for name, kind in suspect.kinds.items() if name in names)
    return Model(causes, misfit, information([fitted.slopes], widths), np.array(steps))


def _special_case(one: Suspect | None, other: Suspect | None) -> bool:
    if one is None or other is None:
        return False
    return set(one.names) < set(other.names) or other.contains(one)


def judge(found: Found, loss: Loss | None = None) -> ChangeVerdict:
    """The verdict.

    Args:
        found: what it rests on.
        loss: what each report gains or loses; default: the table of :class:`~hsr_pin.inference.Loss`.
    """
    decision = decide(found.posterior, loss)
    confidence = _confidence(found.posterior)
    if not decision.sets and not decision.kinds:
        return _nothing(found, decision, confidence)
    sets = decision.sets or (decision.names,)
    best = found.fit_of(sets[0]) if decision.sets else found.fits[0][0]
    shown = [found.fit_of(names) for names in decision.sets] or [best]
    changes = tuple(dict.fromkeys(size for each in shown for size in found.reported(each)))
    difference = found.difference(best)
    share = f"{100 * difference.share:.0f} % of the difference on held-out trials, probability {decision.probability:.2f}"

    def said(status: str, sentence: str, sets: Sequence[tuple[str, ...]] = ()) -> ChangeVerdict:
        return ChangeVerdict(
            status, decision.names, tuple(sets), sentence, decision.kinds, changes, difference, {}, confidence, decision
        )

    if len(decision.sets) > 1:
        common = f"{listed(decision.names)} in any case; " if decision.names else ""
        each = ", or ".join(" with ".join(one) for one in decision.sets)
        return said("ambiguous", f"These recordings cannot tell what has changed: {common}{each} ({share}).", decision.sets)
    if not decision.sets:
        beside = [kind for kind in decision.kinds if kind not in _kinds_of(found, decision.names)]
        of_kind = [f"something of the kind {kind} ({KINDS[kind]})" for kind in beside]
        return said("partly_identified", f"{listed([*decision.names, *of_kind])} has changed, among others ({share}).")
    left = 1 - difference.share
    rest = "nothing else" if left <= _REST else "something else as well, that no candidate explains"
    return said("identified" if left <= _REST else "partly_identified", f"{told(found.reported(best))}; {rest} ({share}).")


def _kinds_of(found: Found, names: Sequence[str]) -> set[str]:
    return {cause.kind for model in found.posterior.models for cause in model.causes if cause.name in names}


def _confidence(judged: Posterior) -> dict[str, float]:
    names = {cause.name for model in judged.models for cause in model.causes}
    stated = {name: judged.of_name(name) for name in names} | {kind: judged.of_kind(kind) for kind in KINDS}
    return {name: round(value, 3) for name, value in sorted(stated.items()) if value >= _LISTED}


def _nothing(found: Found, decision: Decision, confidence: Mapping[str, float]) -> ChangeVerdict:
    """Where no change is reported: nothing has changed that shows, or something that no candidate explains."""
    before, scatter = found.frame.off(), found.frame.scatter
    beyond = sqrt(max(0.0, before**2 - scatter**2))
    difference = Difference(before, before, scatter, 0.0)
    if before > _FARTHER * scatter and beyond >= found.frame.pair.worth:
        sentence = f"Something has changed, by {millimetres(beyond)} beyond the scatter of trials, and no candidate is certain."
        return ChangeVerdict("unexplained", (), (), sentence, (), (), difference, {}, confidence, decision)
    limits = {fitted.suspect.names[0]: _limit(found, fitted) for fitted, _ in found.fits if len(fitted.after) == 1}
    words = {"keq_scale": "stiffness", "damping_scale": "damping"}
    seen_from = [f"of {words[name]} by {100 * limits[name]:.2g} %" for name in words if name in limits]
    would = f" A change {' or '.join(seen_from)} would have shown." if seen_from else ""
    sentence = (
        f"Nothing has changed that shows: the second recording is {millimetres(before)} from what the first predicts of it, and "
        f"{millimetres(scatter)} is expected of trials that repeat.{would}"
    )
    return ChangeVerdict("unchanged", (), (), sentence, (), (), difference, limits, confidence, decision)


def _limit(found: Found, fitted: Fitted) -> float:
    """Size that a change would need to be reported, relative where it has one in OLD."""
    slope, start = fitted.slopes[:, 0], float(fitted.suspect.start[0])
    by_gain = sqrt(found.needed / max(float(slope @ slope), 1e-300))
    step = abs(float(fitted.after[0]) - start)
    by_size = found.frame.pair.worth * step / fitted.rms if fitted.rms > 0 else 0.0
    return max(by_gain, by_size) / (start if start else 1.0)
