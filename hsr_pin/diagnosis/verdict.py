"""From the posterior over models to what is reported of the gap, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.part import PLAIN, SESSION
from hsr_pin.identification.plane import Plane
from hsr_pin.inference import Decision, Loss, decide
from hsr_pin.inference.search import Search

STATUSES = ("identified", "partly_identified", "ambiguous", "parameters", "no_gap", "unexplained", "insufficient", "unchanged")

#: Probability of the smallest collection of sets of causes whose names and kinds are listed.
_CREDIBLE = 0.95

#: Numbers of the arm in words.
_IN_WORDS = {
    "torque_gain": "another gain of the torque (torque_gain)",
    "mass_scale": "another mass (mass_scale)",
    "keq_drift": "a stiffness that changes over the session (keq_drift)",
    "gain_drift": "a gain of the torque that changes over the session (gain_drift)",
}


@dataclass(frozen=True)
class Limits:
    """What is too small to report.

    Attributes:
        noise: [m] RMS distance that noise alone leaves.
        closed: [m] an RMS distance beyond noise that is too small to ask about: 0.3 noise floors, or 0.075 % of the arm's length.
        share: of the squared gap, what may be left where causes are said to explain it.
    """

    noise: float
    closed: float
    share: float = 0.03

    @classmethod
    def of(cls, noise: float, length: float) -> Limits:
        """For a noise floor [m] and an arm of this length [m]."""
        return cls(noise, max(0.3 * noise, 0.75e-3 * length))

    def explains(self, left: float, gap: float) -> bool:
        """Whether a mean square [m^2] that is left beyond noise is next to nothing, by itself or of a squared gap [m^2]."""
        return left <= max(self.closed**2, self.share * gap)


@dataclass(frozen=True)
class Left:
    """What the best model leaves beyond noise.

    Attributes:
        rms: [m].
        share: of the squared gap that stiffness and damping left.
        length: [m] of the arm.
        not_repeatable: [m] RMS distance between trials that repeat one another; None where none do.
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
    found: Search, limits: Limits, nominal: float, length: float, *, scatter: float | None = None, loss: Loss | None = None
) -> Verdict:
    """The verdict on what a search found.

    Args:
        found: fitted models and their posterior.
        limits: what is too small to report.
        nominal: [m^2] mean square beyond noise of the declared model, finely discretised.
        length: [m] of the arm.
        scatter: [m] RMS distance between trials that repeat one another; None where none do.
        loss: what each report gains or loses; default: the table of :class:`~hsr_pin.inference.Loss`.
    """
    axes = len(found.base.fit.residuals[0][0, 0])
    gap, rest = axes * found.base.model.misfit, axes * found.best.model.misfit
    left = Left(sqrt(rest), rest / max(gap, 1e-300), length, scatter)
    if sqrt(nominal) <= limits.closed:
        sentence = f"The declared model reproduces these recordings to within {_mm(limits.closed)} of their noise."
        return Verdict("no_gap", (), (), sentence, left=left)
    if sqrt(gap) <= limits.closed:
        return Verdict("parameters", (), (), _parameters(found, sqrt(nominal), sqrt(gap)), left=left)
    decision = decide(found.posterior, loss)
    status, alternatives, sentence = _said(found, decision, limits, nominal, axes)
    effects = tuple(name for name in decision.names if name not in PLAIN) if status != "parameters" else ()
    kinds = () if status in ("parameters", "unexplained") else decision.kinds
    return Verdict(status, effects, alternatives, sentence, kinds, _confidence(found), left, decision)


def predicted_no_better(verdict: Verdict, alone: float, best: float, names: Sequence[str]) -> Verdict:
    """A verdict names nothing where trials set aside are predicted no better with it than by stiffness and damping alone.

    Args:
        verdict: on the trials that were fitted.
        alone: [m] RMS distance that stiffness and damping leave on the trials set aside.
        best: [m] likewise the best model.
        names: of its causes.
    """
    if best < alone or not (verdict.effects or verdict.alternatives or verdict.kinds):
        return verdict
    sentence = (
        f"No cause is reported: {' with '.join(names)} fits best, but predicts the trials set aside no better ({_mm(best)}) than "
        f"stiffness and damping alone ({_mm(alone)})."
    )
    return replace(verdict, status="unexplained", effects=(), alternatives=(), kinds=(), confidence={}, sentence=sentence)


def turned_plane(verdict: Verdict, plane: Plane | None) -> Verdict:
    """A verdict with the plane that was turned back before any model was fitted."""
    if plane is None or not plane.kind:
        return verdict
    nothing = verdict.status in ("no_gap", "parameters", "unexplained")
    return replace(
        verdict,
        status="partly_identified" if nothing else verdict.status,
        kinds=tuple(sorted({*verdict.kinds, plane.kind})),
        sentence=f"{verdict.sentence} Besides, of the kind {plane.kind}: {plane.sentence}.",
    )


def _said(
    found: Search, decision: Decision, limits: Limits, nominal: float, axes: int
) -> tuple[str, tuple[tuple[str, ...], ...], str]:
    """Status, alternatives and sentence of a decision."""
    gap, names = axes * found.base.model.misfit, decision.names
    sure = f"probability {decision.probability:.2f}"
    if not decision.sets and not decision.kinds:
        return _nothing(found, limits, nominal, axes)
    if len(decision.sets) > 1:
        common = f" Each contains {listed(names)}." if names else ""
        each = ", or ".join(f"{' with '.join(some)} ({found.posterior.sets[some]:.2f})" for some in decision.sets)
        none = found.posterior.sets.get((), 0.0)
        unknown = f" That no known cause is missing has the probability {none:.2f}." if none >= 1 - _CREDIBLE else ""
        return "ambiguous", decision.sets, f"One of these is missing from the model ({sure}): {each}.{common}{unknown}"
    if not decision.sets:
        beside = sorted(set(decision.kinds) - {_kinds(found).get(name, "") for name in names})
        kinds = f"something of the kind {listed(beside)} ({'; '.join(KINDS[kind] for kind in beside)})" if beside else ""
        what = ", and ".join(filter(None, (listed(names), kinds)))
        verb = "are" if len(names) + bool(beside) > 1 else "is"
        return "partly_identified", (), f"{_capital(what)} {verb} missing from the model, in part of its gap ({sure})."
    model = found.leader(decision.sets[0])
    left = axes * model.model.misfit
    share = f"{100 * (1 - left / max(gap, 1e-300)):.0f} % of the squared gap that stiffness and damping leave is gone"
    goes = f"{share}, {_mm(sqrt(left))} beyond noise is left"
    them = "it" if len(names) == 1 else "them"
    if set(names) <= set(PLAIN):
        status = "partly_identified" if set(names) & set(SESSION) else "parameters"
        verb = "explains" if len(names) == 1 else "explain"
        return status, (), f"{_capital(listed([_IN_WORDS[name] for name in names]))} {verb} it ({sure}): with {them} {goes}."
    whole = limits.explains(left, gap)
    rest = "" if whole else "; something else is left"
    verb = "is" if len(names) == 1 else "are"
    sentence = f"{listed(names)} {verb} missing from the model ({sure}): with {them} {goes}{rest}."
    return ("identified" if whole else "partly_identified"), (), sentence


def _nothing(found: Search, limits: Limits, nominal: float, axes: int) -> tuple[str, tuple[tuple[str, ...], ...], str]:
    """Where no cause is reported: stiffness and damping explain the gap, or nothing does."""
    gap = axes * found.base.model.misfit
    alone = found.leader(())
    if limits.explains(axes * alone.model.misfit, nominal if alone is found.base else gap):
        return "parameters", (), _parameters(found, sqrt(nominal), sqrt(axes * alone.model.misfit))
    named = [(names, probability) for names, probability in found.posterior.sets.items() if names]
    hint = "no effect of the catalogue takes away enough of it to be named"
    if named:
        names, probability = named[0]
        hint = f"the most probable cause ({listed(names)}, probability {probability:.2f}) is not certain enough to be named"
    return "unexplained", (), f"A gap of {_mm(sqrt(gap))} beyond noise is left with fitted stiffness and damping, and {hint}."


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


def _parameters(found: Search, before: float, after: float) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in found.leader(()).fit.named.items())
    return f"Stiffness and damping explain it ({values}): the gap beyond noise falls from {_mm(before)} to {_mm(after)}."


def either(sets: Sequence[tuple[str, ...]]) -> str:
    """``a with b, or c``."""
    return ", or ".join(" with ".join(each) for each in sets)


def listed(names: Sequence[str]) -> str:
    """``a, b and c``."""
    return "" if not names else names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm"
