"""What traces of a gap add to a verdict on models: a kind where no model explains it, and laws that cannot be what is missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Protocol

from hsr_pin.diagnosis.evidence import squares
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.spread import Spread
from hsr_pin.diagnosis.thresholds import Thresholds, open_share
from hsr_pin.diagnosis.verdict import HALF, Verdict
from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.hypothesis import Part
from hsr_pin.trajectory import Array

#: Confidence in a kind that a trace alone tells: 45 of 49 were right (fourth to eighth sealed run), by Laplace's rule.
TRACED = 0.9

#: Kinds of laws that are held against it; what is over in an instant is smoothed too much to tell.
SLOW = ("elastic", "actuation_map")
#: ... and those that are only where a force at the tip is far nearer: what remembers differs from place to place, though
#: its law is the same, as a link that sticks holds whatever moment there is. With dry friction of another plant an even
#: torque left 44 %, and the force 31; in the one verdict with such a name that was rightly taken back (192 of the eleventh
#: sealed run) 29 and 5.
REMEMBERING = ("friction", "creep")
#: Confidence in names that it rules out, by Laplace's rule: of 7 in the sixth and seventh run none was right.
RULED_OUT = 0.11


class Trace(Protocol):
    """What a gap shows of its cause without a law for it."""

    @property
    def kind(self) -> str:
        """Of physics; empty if it tells none."""

    @property
    def sentence(self) -> str:
        """As a person would say it."""


def ruled_out(verdict: Verdict, found: Spread | None, parts: Sequence[Part], thresholds: Thresholds) -> Verdict:
    """A verdict that names nothing but laws that cannot be what is missing names none, unless they close the gap.

    Nor if it names a contact beside them: which, and whether it is of that law, is not known for want of other answers. Nor if
    a contact comes first of several, and what is missing is not seen to be spread as by a force at the tip.

    Args:
        verdict: on the models.
        found: how what is missing is spread along the arm.
        parts: every law that was tried.
        thresholds: what counts.
    """
    closes = verdict.status == "identified" or (verdict.left is not None and verdict.left.rms <= thresholds.closed)
    if closes or found is None:
        return verdict
    contacts = {part.name for part in parts if part.kind == "contact"}
    sets = verdict.alternatives or ((verdict.effects,) if verdict.effects else ())
    if not found.uneven:
        open_choice = verdict.status == "ambiguous" and not verdict.effects and not verdict.kinds
        if not (found.beside and open_choice and contacts.intersection(sets[0])):
            return verdict
        told = sorted({name for names in sets for name in names})
        why = f"where {_either(sets[:1])} acts, at the tip, is not seen in how what is missing is spread along the arm"
        return _unnamed(
            verdict, told, parts, f"None is certain: {_either(sets)} comes near at the markers, but {why}{_shares(found)}."
        )
    against = (*SLOW, *REMEMBERING) if found.plain else SLOW
    impossible = {part.name for part in parts if part.kind in against and (_placeless(part) or (found.kind and _shaped(part)))}
    wrong = [names for names in sets if impossible.issuperset(names)]
    standing = [names for names in sets if names not in wrong]
    if not wrong or not all(contacts.issuperset(names) for names in standing):
        return verdict
    told = sorted({name for names in wrong for name in names})
    even = {part.name for part in parts if _placeless(part)}.issuperset(told)
    first = "None is certain" if standing else "No law that was tried can be it"
    acts = "alike all along the arm, and what is missing does not" if even else "along the arm, and what is missing at its tip"
    open_ = f"; {_either(standing)} may be" if standing else ""
    return _unnamed(
        verdict, told, parts, f"{first}: {' or '.join(told)} comes near at the markers, but acts {acts}{_shares(found)}{open_}."
    )


def if_foretold(verdict: Verdict, alone: Sequence[Array], best: Sequence[Array], names: Sequence[str]) -> Verdict:
    """A verdict names nothing where the trials set aside are foretold no better with it than by stiffness and damping alone.

    Args:
        verdict: on the models.
        alone: for each trial set aside (T, M, 2) [m] what stiffness and damping leave.
        best: what the best model leaves.
        names: of what that has.
    """
    less, more = (squares(each).mean ** 0.5 for each in (alone, best))
    if more < less or not (verdict.effects or verdict.alternatives or verdict.kinds):
        return verdict
    sentence = (
        f"None is certain: {_either([names])} comes nearest on the trials that were fitted, but foretells those set aside"
        f" no better ({1e3 * more:.2f} mm) than stiffness and damping alone do ({1e3 * less:.2f} mm)."
    )
    confidence = {name: min(value, RULED_OUT) for name, value in verdict.confidence.items()}
    return replace(verdict, status="unexplained", effects=(), alternatives=(), kinds=(), confidence=confidence, sentence=sentence)


def _placeless(part: Part) -> bool:
    return part.effect is None or part.effect.placeless


def _shaped(part: Part) -> bool:
    """Whether it is another stiffness, or another share of the torque, from place to place of the arm."""
    return part.effect is not None and any(part.effect.acts_through(hook) for hook in ("stiffness", "actuation"))


def _unnamed(verdict: Verdict, told: Sequence[str], parts: Sequence[Part], sentence: str) -> Verdict:
    """A verdict without these names, their kinds, and any other."""
    out = {*told, *(part.kind for part in parts if part.name in told)}
    confidence = {name: min(value, RULED_OUT) for name, value in verdict.confidence.items() if name in out}
    return replace(verdict, status="unexplained", effects=(), alternatives=(), kinds=(), confidence=confidence, sentence=sentence)


def _shares(found: Spread) -> str:
    tip, torque = (f"{100 * (found.beside or found.left)[shape]:.0f} %" for shape in ("tip", "even"))
    return f" (an even torque leaves {torque} of its square, a force at the tip {tip})"


def _either(sets: Iterable[Sequence[str]]) -> str:
    return " or ".join(map(" with ".join, sets))


def with_traces(verdict: Verdict, traces: Iterable[Trace | None]) -> Verdict:
    """An unexplained gap is of the kind that the first of its traces tells."""
    if verdict.status != "unexplained":
        return verdict  # before any trace is looked for
    told = next((trace for trace in traces if trace is not None and trace.kind), None)
    if told is None:
        return verdict
    certain = f"something of the kind {told.kind} ({KINDS[told.kind]}) is certain, in a form that has no name here"
    return replace(
        verdict,
        status="partly_identified",
        kinds=(told.kind,),
        confidence={**verdict.confidence, told.kind: TRACED},
        sentence=f"{certain}: {told.sentence}. {verdict.sentence}",
    )


def mostly_explained(found: Search, thresholds: Thresholds) -> bool:
    """Whether some model takes away most of the gap, certain or not: the gap's shape is then no sign of something else."""
    return any(open_share(each, found.path[0], thresholds) < HALF for each in found.tried)


def beside(verdict: Verdict, trace: Trace | None) -> Verdict:
    """With what was seen, and mended, before any model was asked."""
    if trace is None or not trace.kind:
        return verdict
    nothing = verdict.status in ("no_gap", "parameters", "unexplained")
    return replace(
        verdict,
        status="partly_identified" if nothing else verdict.status,
        kinds=tuple(sorted({*verdict.kinds, trace.kind})),
        confidence={**verdict.confidence, trace.kind: max(TRACED, verdict.confidence.get(trace.kind, 0.0))},
        sentence=f"{verdict.sentence} Certain too, of the kind {trace.kind}: {trace.sentence}.",
    )
