"""The reported verdict and its sentence, from the posterior over models."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.posterior import Names
from hsr_pin.inference.search import Search

STATUSES = ("identified", "partly_identified", "ambiguous", "parameters", "no_gap", "unexplained", "insufficient", "unchanged")

#: Status of a verdict -> its headline.
HEADLINES = {
    "identified": "Missing physics identified",
    "partly_identified": "Missing physics identified in part",
    "ambiguous": "More than one explanation",
    "parameters": "Fitted parameters explain the gap",
    "no_gap": "No gap",
    "unexplained": "Not explained by any known effect",
    "insufficient": "Not enough data",
    "unchanged": "Nothing has changed",
}

#: Total probability of the smallest collection of sets of causes whose names and kinds are listed.
_CREDIBLE = 0.95


@dataclass(frozen=True)
class Vocabulary:
    """Words of a verdict for one kind of model.

    Attributes:
        fitted: the parameters that are fitted without any cause, as in "stiffness and damping".
        size: function that formats a distance.
        kinds: short description of each kind of physics.
        numbers: causes that are parameters of the nominal model, in words; they are not reported as missing effects.
        session: those of them that change during the session.
        missing: phrase that states that a cause is missing.
        nothing: status and beginning of the sentence if the declared model leaves no gap.
        declared: name of the declared model in the ladder.
        headlines: headline for each status.
    """

    fitted: str
    size: Callable[[float], str]
    kinds: Mapping[str, str]
    numbers: Mapping[str, str] = field(default_factory=dict)
    session: frozenset[str] = frozenset()
    missing: str = "missing from the model"
    nothing: tuple[str, str] = ("no_gap", "The declared model reproduces these recordings")
    declared: str = "declared model"
    headlines: Mapping[str, str] = field(default_factory=lambda: HEADLINES)

    @property
    def at_best(self) -> str:
        """Phrase for the best model without any cause."""
        return self.fitted if self.fitted.startswith("the ") else f"fitted {self.fitted}"


@dataclass(frozen=True)
class Limits:
    """Thresholds below which a gap is not reported.

    Attributes:
        noise: RMS distance that noise alone leaves [m].
        closed: RMS distance beyond noise below which a gap counts as closed [m].
        share: share of the squared gap that may remain if causes are said to explain it.
    """

    noise: float
    closed: float
    share: float = 0.03

    @classmethod
    def of(cls, noise: float, truest: float) -> Limits:
        """Return the thresholds for the noise and the error of the best models: 0.3 times the noise or 1.5 times the error."""
        return cls(noise, max(0.3 * noise, 1.5 * truest))

    def explains(self, left: float, gap: float) -> bool:
        """Return whether a mean square beyond noise is negligible, absolutely or relative to a squared gap."""
        return left <= max(self.closed**2, self.share * gap)


@dataclass(frozen=True)
class Remainder:
    """Gap that the best model leaves beyond noise.

    Attributes:
        rms: RMS distance [m].
        share: share of the squared gap of the model without causes.
        length: reference length that distances are compared with, such as that of the arm [m].
        not_repeatable: trial-to-trial scatter (RMS distance between repeated trials) [m]; None without repeated trials.
    """

    rms: float
    share: float
    length: float
    not_repeatable: float | None = None


@dataclass(frozen=True)
class Verdict:
    """Conclusion from the recordings.

    Attributes:
        status: one of :data:`STATUSES`.
        effects: sorted names of the effects that are reported as missing (those common to all alternatives).
        alternatives: sets of names that these recordings cannot distinguish, the most probable first.
        sentence: the verdict as one sentence.
        kinds: sorted kinds of physics that are reported.
        confidence: name or kind -> its probability.
        left: gap that remains; None if nothing was fitted.
        decision: the report chosen by the loss table; None if nothing was fitted.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str
    kinds: tuple[str, ...] = ()
    confidence: Mapping[str, float] = field(default_factory=dict)
    left: Remainder | None = None
    decision: Decision | None = None


def verdict_of(
    found: Search,
    limits: Limits,
    nominal: float,
    words: Vocabulary,
    *,
    length: float = 1.0,
    scatter: float | None = None,
    loss: Loss | None = None,
) -> Verdict:
    """Return the verdict on the result of a search.

    Args:
        found: fitted models and their posterior.
        limits: thresholds below which a gap is not reported.
        nominal: mean square beyond noise of the declared model [m^2].
        words: vocabulary of the sentence.
        length: reference length that distances are compared with [m].
        scatter: trial-to-trial scatter (RMS distance between repeated trials) [m]; None without repeated trials.
        loss: gains and losses of a report; default: the table of :class:`~hsr_pin.inference.Loss`.
    """
    axes = len(found.base.fit.residuals[0][0, 0])
    gap, rest = axes * found.base.model.misfit, axes * found.best.model.misfit
    left = Remainder(sqrt(rest), rest / max(gap, 1e-300), length, scatter)
    if sqrt(nominal) <= limits.closed:
        status, sentence = words.nothing
        return Verdict(status, (), (), f"{sentence} to within {words.size(limits.closed)} of their noise.", left=left)
    if sqrt(gap) <= limits.closed:
        return Verdict("parameters", (), (), _parameters(found, sqrt(nominal), sqrt(gap), words), left=left)
    decision = decide(found.posterior, loss)
    status, alternatives, sentence = _Words(found, decision, limits, nominal, axes, words).said()
    effects = tuple(name for name in decision.names if name not in words.numbers) if status != "parameters" else ()
    kinds = () if status in ("parameters", "unexplained") else decision.kinds
    return Verdict(status, effects, alternatives, sentence, kinds, _confidence(found), left, decision)


def predicted_no_better(verdict: Verdict, alone: float, best: float, names: Sequence[str], words: Vocabulary) -> Verdict:
    """Return the verdict, without any causes if they do not improve the prediction of held-out trials.

    Args:
        verdict: verdict from the fitted trials.
        alone: RMS distance of the model without causes on the held-out trials [m].
        best: RMS distance of the best model on the held-out trials [m].
        names: causes of the best model.
        words: vocabulary of the sentence.
    """
    if best < alone or not (verdict.effects or verdict.alternatives or verdict.kinds):
        return verdict
    sentence = (
        f"No cause is reported: {' with '.join(names)} fits best, but predicts the held-out trials no better "
        f"({words.size(best)}) than {words.fitted} alone ({words.size(alone)})."
    )
    return replace(verdict, status="unexplained", effects=(), alternatives=(), kinds=(), confidence={}, sentence=sentence)


@dataclass(frozen=True, eq=False)
class _Words:
    """Sentence of a decision; the fields are the arguments of :func:`verdict_of`."""

    found: Search
    decision: Decision
    limits: Limits
    nominal: float
    axes: int
    words: Vocabulary

    @property
    def probability(self) -> str:
        """Probability of the report as text."""
        return f"probability {self.decision.probability:.2f}"

    @property
    def gap(self) -> float:
        """Squared gap of the model without causes."""
        return self.axes * self.found.base.model.misfit

    def said(self) -> tuple[str, tuple[Names, ...], str]:
        """Return the status, the alternatives and the sentence."""
        if not self.decision.sets and not self.decision.kinds:
            return self._nothing()
        if not self.decision.sets:
            return "partly_identified", (), self._in_part()
        return self._alternatives() if len(self.decision.sets) > 1 else self._one()

    def _alternatives(self) -> tuple[str, tuple[Names, ...], str]:
        sets, names, judged = self.decision.sets, self.decision.names, self.found.posterior.sets
        common = f" Each contains {listed(names)}." if names else ""
        each = ", or ".join(f"{' with '.join(some)} ({judged[some]:.2f})" for some in sets)
        none = judged.get((), 0.0)
        unknown = f" The probability that no known cause is missing is {none:.2f}." if none >= 1 - _CREDIBLE else ""
        return "ambiguous", sets, f"One of these is {self.words.missing} ({self.probability}): {each}.{common}{unknown}"

    def _in_part(self) -> str:
        names, kinds = self.decision.names, self.found.posterior.kinds
        further_kinds = sorted(set(self.decision.kinds) - {kinds.get(name, "") for name in names})
        what = "; ".join(self.words.kinds.get(kind, kind) for kind in further_kinds)
        of_kind = f"something of the kind {listed(further_kinds)} ({what})" if further_kinds else ""
        both = _capital(", and ".join(filter(None, (listed(names), of_kind))))
        many = len(names) + bool(further_kinds) > 1
        explains = "and explain part of the gap" if many else "and explains part of the gap"
        return f"{both} {'are' if many else 'is'} {self.words.missing} {explains} ({self.probability})."

    def _one(self) -> tuple[str, tuple[Names, ...], str]:
        names, many = self.decision.names, len(self.decision.names) > 1
        left = self.axes * self.found.leader(self.decision.sets[0]).model.misfit
        share = 100 * (1 - left / max(self.gap, 1e-300))
        goes = (
            f"{'they explain' if many else 'it explains'} {share:.0f} % of the squared gap that {self.words.fitted} leave, "
            f"and {self.words.size(sqrt(left))} beyond noise remains"
        )
        if set(names) <= set(self.words.numbers):
            status = "partly_identified" if set(names) & self.words.session else "parameters"
            what = _capital(listed([self.words.numbers[name] for name in names]))
            return status, (), f"{what} {'explain' if many else 'explains'} the gap ({self.probability}): {goes}."
        whole = self.limits.explains(left, self.gap)
        rest = "" if whole else "; another cause is not identified"
        sentence = f"{listed(names)} {'are' if many else 'is'} {self.words.missing} ({self.probability}): {goes}{rest}."
        return ("identified" if whole else "partly_identified"), (), sentence

    def _nothing(self) -> tuple[str, tuple[Names, ...], str]:
        """Return the verdict if no cause is reported: the fitted parameters explain the gap, or nothing does."""
        found, alone = self.found, self.found.leader(())
        left = self.axes * alone.model.misfit
        if self.limits.explains(left, self.nominal if alone is found.base else self.gap):
            return "parameters", (), _parameters(found, sqrt(self.nominal), sqrt(left), self.words)
        named = [(names, probability) for names, probability in found.posterior.sets.items() if names]
        hint = "no effect of the catalogue explains enough of it to be reported"
        if named:
            names, probability = named[0]
            hint = f"the most probable cause ({listed(names)}, probability {probability:.2f}) is too uncertain to be reported"
        size = self.words.size(sqrt(self.gap))
        return "unexplained", (), f"A gap of {size} beyond noise remains with {self.words.at_best}, and {hint}."


def _confidence(found: Search) -> dict[str, float]:
    """Return the probabilities of the causes and kinds in the smallest credible collection of sets."""
    sets = found.posterior.credible(_CREDIBLE)
    causes = [cause for names in sets for cause in found.posterior.leader(names).causes]
    stated = {cause.name: found.posterior.of_name(cause.name) for cause in causes if not cause.flexible}
    stated |= {cause.kind: found.posterior.of_kind(cause.kind) for cause in causes}
    return {name: round(value, 3) for name, value in sorted(stated.items())}


def _parameters(found: Search, before: float, after: float, words: Vocabulary) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in found.leader(()).fit.named.items())
    falls = f"the gap beyond noise falls from {words.size(before)} to {words.size(after)}"
    return f"{_capital(words.fitted)} explain the gap ({values}): {falls}."


def headline(verdict: Verdict) -> str:
    """Return the headline of a verdict."""
    return HEADLINES[verdict.status]


def listed(names: Sequence[str]) -> str:
    """Return names as ``a, b and c``."""
    return "" if not names else names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
