"""From the posterior over models to what is reported of the gap, in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.posterior import Names
from hsr_pin.inference.search import Search

STATUSES = ("identified", "partly_identified", "ambiguous", "parameters", "no_gap", "unexplained", "insufficient", "unchanged")

#: Verdict -> what it comes down to.
HEADLINES = {
    "identified": "Missing physics identified",
    "partly_identified": "Missing physics identified in part",
    "ambiguous": "More than one explanation",
    "parameters": "Fitted parameters explain it",
    "no_gap": "No gap",
    "unexplained": "Not explained by any known effect",
    "insufficient": "Too little to go on",
    "unchanged": "Nothing has changed",
}


#: Probability of the smallest collection of sets of causes whose names and kinds are listed.
_CREDIBLE = 0.95


@dataclass(frozen=True)
class Vocabulary:
    """How a verdict calls what it speaks of.

    Attributes:
        fitted: the numbers that are fitted without any cause, as in "stiffness and damping".
        size: a distance as text.
        kinds: of physics, in a few words each.
        numbers: causes that are numbers of the model itself, in words: they are no missing effects.
        session: those of them that change over the session.
        missing: what is said of a cause.
        nothing: status and beginning of the sentence where the declared model leaves no gap.
        declared: the model as declared, as a row of the ladder.
        headlines: what a verdict comes down to, by its status.
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
        """The numbers as they are at best without any cause."""
        return self.fitted if self.fitted.startswith("the ") else f"fitted {self.fitted}"


@dataclass(frozen=True)
class Limits:
    """What is too small to report.

    Attributes:
        noise: RMS distance that noise alone leaves.
        closed: an RMS distance beyond noise that is too small to ask about.
        share: of the squared gap, what may be left where causes are said to explain it.
    """

    noise: float
    closed: float
    share: float = 0.03

    @classmethod
    def of(cls, noise: float, truest: float) -> Limits:
        """For noise, and what the truest of models leaves: three tenths of the one, or one and a half times the other."""
        return cls(noise, max(0.3 * noise, 1.5 * truest))

    def explains(self, left: float, gap: float) -> bool:
        """Whether a mean square that is left beyond noise is next to nothing, by itself or of a squared gap."""
        return left <= max(self.closed**2, self.share * gap)


@dataclass(frozen=True)
class Left:
    """What the best model leaves beyond noise.

    Attributes:
        rms: distance.
        share: of the squared gap that the model without causes left.
        length: that distances are compared with: of the arm.
        not_repeatable: RMS distance between trials that repeat one another; None where none do.
    """

    rms: float
    share: float
    length: float
    not_repeatable: float | None = None


@dataclass(frozen=True)
class Verdict:
    """What the recordings say.

    Attributes:
        status: one of :data:`STATUSES`.
        effects: names of the effects that are reported as missing, sorted (those that all alternatives share).
        alternatives: sets of names that these recordings cannot tell apart, the most probable first.
        sentence: the verdict as a person would say it.
        kinds: of physics that are reported, sorted.
        confidence: name or kind -> its probability.
        left: what is left; None where nothing was fitted.
        decision: the report that the loss chose; None where nothing was fitted.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str
    kinds: tuple[str, ...] = ()
    confidence: Mapping[str, float] = field(default_factory=dict)
    left: Left | None = None
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
    """The verdict on what a search found.

    Args:
        found: fitted models and their posterior.
        limits: what is too small to report.
        nominal: mean square beyond noise of the declared model.
        words: how it calls what it speaks of.
        length: that distances are compared with.
        scatter: RMS distance between trials that repeat one another; None where none do.
        loss: what each report gains or loses; default: the table of :class:`~hsr_pin.inference.Loss`.
    """
    axes = len(found.base.fit.residuals[0][0, 0])
    gap, rest = axes * found.base.model.misfit, axes * found.best.model.misfit
    left = Left(sqrt(rest), rest / max(gap, 1e-300), length, scatter)
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
    """A verdict names nothing where trials set aside are predicted no better with it than by the model without causes.

    Args:
        verdict: on the trials that were fitted.
        alone: RMS distance that the model without causes leaves on the trials set aside.
        best: likewise the best model.
        names: of its causes.
        words: how it calls what it speaks of.
    """
    if best < alone or not (verdict.effects or verdict.alternatives or verdict.kinds):
        return verdict
    sentence = (
        f"No cause is reported: {' with '.join(names)} fits best, but predicts the trials set aside no better "
        f"({words.size(best)}) than {words.fitted} alone ({words.size(alone)})."
    )
    return replace(verdict, status="unexplained", effects=(), alternatives=(), kinds=(), confidence={}, sentence=sentence)


@dataclass(frozen=True, eq=False)
class _Words:
    """A decision in words; arguments as of :func:`verdict_of`."""

    found: Search
    decision: Decision
    limits: Limits
    nominal: float
    axes: int
    words: Vocabulary

    @property
    def sure(self) -> str:
        return f"probability {self.decision.probability:.2f}"

    @property
    def gap(self) -> float:
        """Squared, of the model without causes."""
        return self.axes * self.found.base.model.misfit

    def said(self) -> tuple[str, tuple[Names, ...], str]:
        """Status, alternatives and sentence."""
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
        unknown = f" That no known cause is missing has the probability {none:.2f}." if none >= 1 - _CREDIBLE else ""
        return "ambiguous", sets, f"One of these is {self.words.missing} ({self.sure}): {each}.{common}{unknown}"

    def _in_part(self) -> str:
        names, kinds = self.decision.names, _kinds(self.found)
        beside = sorted(set(self.decision.kinds) - {kinds.get(name, "") for name in names})
        what = "; ".join(self.words.kinds.get(kind, kind) for kind in beside)
        of_kind = f"something of the kind {listed(beside)} ({what})" if beside else ""
        both = _capital(", and ".join(filter(None, (listed(names), of_kind))))
        verb = "are" if len(names) + bool(beside) > 1 else "is"
        return f"{both} {verb} {self.words.missing}, in part of its gap ({self.sure})."

    def _one(self) -> tuple[str, tuple[Names, ...], str]:
        names, many = self.decision.names, len(self.decision.names) > 1
        left = self.axes * self.found.leader(self.decision.sets[0]).model.misfit
        share = 100 * (1 - left / max(self.gap, 1e-300))
        goes = (
            f"with {'them' if many else 'it'} {share:.0f} % of the squared gap that {self.words.fitted} leave is gone, "
            f"{self.words.size(sqrt(left))} beyond noise is left"
        )
        if set(names) <= set(self.words.numbers):
            status = "partly_identified" if set(names) & self.words.session else "parameters"
            what = _capital(listed([self.words.numbers[name] for name in names]))
            return status, (), f"{what} {'explain' if many else 'explains'} it ({self.sure}): {goes}."
        whole = self.limits.explains(left, self.gap)
        rest = "" if whole else "; something else is left"
        sentence = f"{listed(names)} {'are' if many else 'is'} {self.words.missing} ({self.sure}): {goes}{rest}."
        return ("identified" if whole else "partly_identified"), (), sentence

    def _nothing(self) -> tuple[str, tuple[Names, ...], str]:
        """Where no cause is reported: the numbers that are fitted anyway explain the gap, or nothing does."""
        found, alone = self.found, self.found.leader(())
        left = self.axes * alone.model.misfit
        if self.limits.explains(left, self.nominal if alone is found.base else self.gap):
            return "parameters", (), _parameters(found, sqrt(self.nominal), sqrt(left), self.words)
        named = [(names, probability) for names, probability in found.posterior.sets.items() if names]
        hint = "no effect of the catalogue takes away enough of it to be named"
        if named:
            names, probability = named[0]
            hint = f"the most probable cause ({listed(names)}, probability {probability:.2f}) is not certain enough to be named"
        size = self.words.size(sqrt(self.gap))
        return "unexplained", (), f"A gap of {size} beyond noise is left with {self.words.at_best}, and {hint}."


def _confidence(found: Search) -> dict[str, float]:
    """Probability of each cause, and of each kind, of the smallest collection of sets of causes that is credible."""
    sets = found.posterior.credible(_CREDIBLE)
    causes = [cause for names in sets for cause in found.posterior.leader(names).causes]
    stated = {cause.name: found.posterior.of_name(cause.name) for cause in causes if not cause.flexible}
    stated |= {cause.kind: found.posterior.of_kind(cause.kind) for cause in causes}
    return {name: round(value, 3) for name, value in sorted(stated.items())}


def _kinds(found: Search) -> dict[str, str]:
    """Of every cause that was fitted."""
    return {cause.name: cause.kind for model in found.posterior.models for cause in model.causes}


def _parameters(found: Search, before: float, after: float, words: Vocabulary) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in found.leader(()).fit.named.items())
    falls = f"the gap beyond noise falls from {words.size(before)} to {words.size(after)}"
    return f"{_capital(words.fitted)} explain it ({values}): {falls}."


def headline(verdict: Verdict) -> str:
    """What a verdict comes down to."""
    return HEADLINES[verdict.status]


def listed(names: Sequence[str]) -> str:
    """``a, b and c``."""
    return "" if not names else names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
