"""The verdict on a change, from the posterior over change hypotheses.

The residuals of the current recording are whitened by the prediction from the reference recording, so that noise and scatter have
unit variance. A change hypothesis is a model of these residuals; the model without causes states that nothing has changed. A gain
that the same change would have between trials of the reference recording is attributed to scatter.
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
from hsr_pin.diagnosis.change.hypotheses import ChangeHypothesis
from hsr_pin.diagnosis.change.size import Size, left_out, sizes
from hsr_pin.diagnosis.change.swing import apparent_damping_range
from hsr_pin.diagnosis.change.words import changes_in_words
from hsr_pin.diagnosis.verdict import millimetres
from hsr_pin.effects.effect import KINDS
from hsr_pin.inference import Cause, Data, Decision, Loss, Model, Posterior, decide, posterior
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.evidence import variance
from hsr_pin.inference.model import information
from hsr_pin.inference.verdict import listed

#: Largest distance of the current recording from its prediction without a change, as a multiple of the expected scatter.
_FARTHER = 2.0
#: Largest remaining share of the difference if a change is said to explain it.
_REST = 0.1
#: Odds at which a change counts as detected, for the smallest detectable change.
_ODDS = 20.0
#: Probabilities below this are not listed.
_LISTED = 0.01


@dataclass(frozen=True)
class Difference:
    """RMS distances between the current recording and the prediction from the reference recording [m].

    Attributes:
        before: distance without any change.
        after: distance with the change.
        scatter: expected distance if nothing has changed.
        share: share of the difference, in units of its scatter, that the change explains on held-out trials.
    """

    before: float
    after: float
    scatter: float
    share: float


@dataclass(frozen=True)
class ChangeVerdict:
    """Conclusion on a change.

    Attributes:
        status: "identified", "partly_identified", "ambiguous", "unexplained", "unchanged" or "insufficient".
        effects: sorted names of what is reported as changed; parameters of the arm under their own names.
        alternatives: sets of names that these recordings cannot distinguish, the most probable first.
        sentence: the verdict as one sentence.
        kinds: sorted kinds of physics that are reported.
        changes: sizes of the changes of the best hypothesis, then of the alternatives.
        difference: difference of the recordings; None if it could not be determined.
        limits: name -> smallest detectable change; relative for parameters of the arm.
        confidence: name or kind -> its probability.
        decision: the report chosen by the loss table; None if nothing was fitted.
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
class ChangeEvidence:
    """Evidence for a verdict on a change.

    Attributes:
        frame: the whitened residuals.
        fits: (change, the frame of its fit), the best first; one for each set of names.
        chance: gains of the most promising changes within the reference recording.
        was: 95 % intervals of the values of the reference model, by name.
    """

    frame: Frame
    fits: tuple[tuple[Fitted, Frame], ...]
    chance: Chance
    was: Mapping[str, tuple[float, float]]

    @property
    def new(self) -> NDArray[np.bool_]:
        """For each row (n,), whether it belongs to the current recording."""
        return np.asarray(self.frame.run >= len(self.frame.pair.old.runs))

    @property
    def nothing(self) -> float:
        """Sum of the squared residuals without any change."""
        return float(self.frame.seen @ self.frame.seen)

    def gain(self, fitted: Fitted) -> float:
        """Return the decrease of the squared residuals by a change."""
        return self.nothing - fitted.square

    @cached_property
    def data(self) -> Data:
        """Unit noise variance and number of whitened residuals."""
        return Data.of_one_group(1.0, self.count)

    @property
    def count(self) -> int:
        """Number of whitened residuals of the current recording."""
        return int(self.new.sum())

    @cached_property
    def sizes(self) -> dict[tuple[str, ...], tuple[Size, ...]]:
        """Sizes of each fitted change, by its names."""
        return {f.change.names: sizes(frame, f, self.was, max(1.0, self.chance.inflation)) for f, frame in self.fits}

    @cached_property
    def posterior(self) -> Posterior:
        """Posterior over the reportable changes and over the hypothesis that nothing has changed."""
        least = min([self.nothing, *(fitted.square for fitted, _ in self.fits)])
        expected = len(self.frame.seen) * self._noisier
        floor = max(0.0, least - expected)  # remaining misfit of all hypotheses beyond noise

        def misfit(square: float) -> float:
            return max(square - least + floor, self.chance.largest) / self.count

        models = [Model((), np.array([misfit(self.nothing)]), np.zeros((1, 0, 0)), np.zeros(0))]
        seen: dict[int, ChangeHypothesis | None] = {id(models[0]): None}
        for fitted, _ in self.fits:
            if fitted.rms >= self.frame.pair.reportable:
                models.append(_model(fitted, misfit(fitted.square), {size.name for size in self.reported(fitted)}))
                seen[id(models[-1])] = fitted.change

        def special_case(one: Model, other: Model) -> bool:
            return _special_case(seen[id(one)], seen[id(other)])

        return posterior(models, self.data, calibrated(), special_case)

    @property
    def _noisier(self) -> float:
        """Mean square of the residuals of the reference recording, at least 1, which is expected in the current recording too."""
        old = self.frame.seen[~self.new]
        return max(1.0, float(np.mean(old**2)))

    def reported(self, fitted: Fitted) -> tuple[Size, ...]:
        """Return the reported sizes of a change, without a damping change that a change of frequency can cause."""
        found = self.sizes[fitted.change.names]
        own = [size for size in found if size.parameter == "damping_scale" and size.step is not None]
        if not own or len(fitted.change.names) < 2 or own[0].step is None:
            return found
        (low, high), (least, most) = own[0].step, apparent_damping_range(self.frame.pair, fitted)
        return tuple(size for size in found if size is not own[0]) if least < most and low <= most and high >= least else found

    def fit_of(self, names: tuple[str, ...]) -> Fitted:
        """Return the best fit in which exactly these have changed."""
        own = [fitted for fitted, _ in self.fits if tuple(sorted({s.name for s in self.reported(fitted)})) == names]
        return min(own, key=lambda fitted: fitted.square)

    def difference(self, fitted: Fitted) -> Difference:
        """Return the difference between the recordings with and without a change."""
        frame = next(frame for each, frame in self.fits if each is fitted)
        _, residual = left_out(frame, fitted)
        was, is_, least = (float((each[self.new] ** 2).sum()) for each in (self.frame.seen, residual, fitted.residual))
        beyond = max(0.0, least - self.count * self._noisier)
        share = (was - is_) / max(self.gain(fitted) + beyond, was - is_, 1e-300)
        return Difference(self.frame.off(), frame.off(fitted.moved), self.frame.scatter, float(np.clip(share, 0.0, 1.0)))

    @property
    def needed(self) -> float:
        """Gain at which a change of one parameter is 20 times as probable as no change."""
        return needed(self.data, self.chance.largest / self.count)


def needed(data: Data, scatter: float = 0.0) -> float:
    """Return the decrease of the squared residuals at which one cause is 20 times as probable as none.

    Args:
        data: noise variance and number of the residuals.
        scatter: mean square that no change is required to explain.
    """
    numbers = calibrated()
    left = float((data.count * variance(np.array([scatter]), data, numbers)).sum())
    return left * (exp(2 * (numbers.cause + log(_ODDS)) / numbers.samples) - 1)


def _model(fitted: Fitted, misfit: float, names: set[str]) -> Model:
    """Return the summary of a change for the evidence; the prior of a parameter is centred at its reference value."""
    facts, change = fitted.change.facts, fitted.change
    widths = np.array([fact.prior_width(value) for fact, value in zip(facts, fitted.after, strict=True)])
    steps = [
        log(max(after, 1e-9) / before) / fact.ratio_width if fact.ratio_width is not None else (after - before) / width * sized
        for fact, after, before, width, sized in zip(facts, fitted.after, change.start, widths, change.sizes, strict=True)
    ]
    causes = tuple(Cause(name, kind) for name, kind in change.kinds.items() if name in names)
    return Model(causes, np.array([misfit]), information([fitted.slopes], widths)[None], np.array(steps))


def _special_case(one: ChangeHypothesis | None, other: ChangeHypothesis | None) -> bool:
    if one is None or other is None:
        return False
    return set(one.names) < set(other.names) or other.contains(one)


def judge(found: ChangeEvidence, loss: Loss | None = None) -> ChangeVerdict:
    """Return the verdict on a change.

    Args:
        found: the evidence.
        loss: gains and losses of a report; default: the table of :class:`~hsr_pin.inference.Loss`.
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
    explained = f"explains {100 * difference.share:.0f} % of the difference on held-out trials"
    share = f"{explained}, probability {decision.probability:.2f}"

    def said(status: str, sentence: str, sets: Sequence[tuple[str, ...]] = ()) -> ChangeVerdict:
        return ChangeVerdict(
            status, decision.names, tuple(sets), sentence, decision.kinds, changes, difference, {}, confidence, decision
        )

    if len(decision.sets) > 1:
        common = f"{listed(decision.names)} in any case; " if decision.names else ""
        each = ", or ".join(" with ".join(one) for one in decision.sets)
        return said("ambiguous", f"These recordings do not determine what has changed: {common}{each} ({share}).", decision.sets)
    if not decision.sets:
        known = {kind for name, kind in found.posterior.kinds.items() if name in decision.names}
        further_kinds = [kind for kind in decision.kinds if kind not in known]
        of_kind = [f"something of the kind {kind} ({KINDS[kind]})" for kind in further_kinds]
        return said(
            "partly_identified", f"{listed([*decision.names, *of_kind])} has changed, together with other causes ({share})."
        )
    left = 1 - difference.share
    rest = "no other change is visible" if left <= _REST else "another change is not explained by any candidate"
    return said(
        "identified" if left <= _REST else "partly_identified", f"{changes_in_words(found.reported(best))}; {rest} ({share})."
    )


def _confidence(judged: Posterior) -> dict[str, float]:
    stated = {name: judged.of_name(name) for name in judged.kinds} | {kind: judged.of_kind(kind) for kind in KINDS}
    return {name: round(value, 3) for name, value in sorted(stated.items()) if value >= _LISTED}


def _nothing(found: ChangeEvidence, decision: Decision, confidence: Mapping[str, float]) -> ChangeVerdict:
    """Return the verdict if no change is reported: no change is visible, or no candidate explains it."""
    before, scatter = found.frame.off(), found.frame.scatter
    beyond = sqrt(max(0.0, before**2 - scatter**2))
    difference = Difference(before, before, scatter, 0.0)
    if before > _FARTHER * scatter and beyond >= found.frame.pair.reportable:
        sentence = (
            f"Something has changed by {millimetres(beyond)} beyond the scatter of trials, and no candidate is certain enough."
        )
        return ChangeVerdict("unexplained", (), (), sentence, (), (), difference, {}, confidence, decision)
    limits = {fitted.change.names[0]: _limit(found, fitted) for fitted, _ in found.fits if len(fitted.after) == 1}
    words = {"keq_scale": "stiffness", "damping_scale": "damping"}
    seen_from = [f"of {words[name]} by {100 * limits[name]:.2g} %" for name in words if name in limits]
    would = f" A change {' or '.join(seen_from)} would have been detected." if seen_from else ""
    sentence = (
        f"No change is visible: the second recording deviates by {millimetres(before)} from the prediction of the first one, and "
        f"{millimetres(scatter)} is expected from the scatter of trials.{would}"
    )
    return ChangeVerdict("unchanged", (), (), sentence, (), (), difference, limits, confidence, decision)


def _limit(found: ChangeEvidence, fitted: Fitted) -> float:
    """Return the smallest detectable size of a change, relative if it has a size in the reference recording."""
    slope, start = fitted.slopes[:, 0], float(fitted.change.start[0])
    by_gain = sqrt(found.needed / max(float(slope @ slope), 1e-300))
    step = abs(float(fitted.after[0]) - start)
    by_size = found.frame.pair.reportable * step / fitted.rms if fitted.rms > 0 else 0.0
    return max(by_gain, by_size) / (start if start else 1.0)
