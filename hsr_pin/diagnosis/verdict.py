"""From what the search found to what may be said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.evidence import certainly_better
from hsr_pin.diagnosis.search import Search, Thresholds, doubtful, explains, left, mean_square

#: A rival is set aside only if its mean square is certainly larger, and by at least this share of what the best leaves ...
FACTOR = 0.5
#: ... plus the square of this share of the noise floor.
MARGIN = 0.05
#: A gap that no effect is worth having for is called structure only when it is this much larger than one too small to ask about.
STRUCTURE = 2.0
#: [standard errors] An amplitude closer to neutral than this may as well be neutral (95 %).
AWAY = 1.96

STATUSES = ("identified", "ambiguous", "parameters", "no_gap", "unexplained", "insufficient")


@dataclass(frozen=True)
class Verdict:
    """What the recordings say.

    Attributes:
        status: one of :data:`STATUSES`.
        effects: the names that are certain, sorted (those that all alternatives share).
        alternatives: sets of names that these recordings cannot tell apart, the best first; empty unless ambiguous.
        sentence: the verdict as a person would say it.
    """

    status: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    sentence: str


def judge(nominal_left: float, found: Search, thresholds: Thresholds, seed: int, by_level: Candidate | None = None) -> Verdict:
    """The verdict.

    Args:
        nominal_left: [m^2] mean square beyond noise of the declared model, finely discretised.
        found: by the search.
        thresholds: what counts.
        seed: of the resampling.
        by_level: without effects, but a stiffness and a damping for each declared Keq; None if one is declared.
    """
    base, best = found.path[0], found.best
    gap, rest = sqrt(left(base)), sqrt(left(best))
    closed = thresholds.closed
    if sqrt(nominal_left) <= closed:
        return Verdict(
            "no_gap", (), (), f"The declared model reproduces these recordings to within {_mm(closed)} of their noise."
        )
    if gap <= closed or (best is base and gap <= STRUCTURE * closed):
        return Verdict("parameters", (), (), _parameters(base, sqrt(nominal_left), gap))
    levels = by_level if by_level is not None and sqrt(left(by_level)) <= closed else None
    named = explains(best, base, thresholds) and not doubtful(best)
    if levels is not None and (not named or clearly_worse(best, levels, thresholds, seed)):
        return Verdict("parameters", (), (), _parameters(levels, sqrt(nominal_left), sqrt(left(levels))))
    if best is base:
        return Verdict(
            "unexplained", (), (), f"A gap of {_mm(gap)} beyond noise is left, and no effect of the catalogue is worth having."
        )
    if not explains(best, base, thresholds):
        helps = " and ".join(best.names)
        return Verdict(
            "unexplained",
            (),
            (),
            f"Of the gap of {_mm(gap)} beyond noise, {_mm(rest)} is left with the best that the catalogue offers ({helps}): "
            "something else is at work.",
        )
    if not named:
        return Verdict(
            "unexplained",
            (),
            (),
            f"With {_listed(best.names)}, {_mm(rest)} of the gap of {_mm(gap)} beyond noise is left, but these recordings hardly "
            f"tell how large {_listed(doubtful(best))} would be: another law may be at work.",
        )
    sets = [best.names, *rivals(best, base, found.tried, thresholds, seed)]
    if levels is not None and not clearly_worse(levels, best, thresholds, seed):
        sets.append(())
    if len(sets) > 1:
        common = sorted(set.intersection(*map(set, sets)))
        sure = f"{' and '.join(common)} is certain; " if common else ""
        listed = ", or ".join(" with ".join(names) or "another stiffness and damping at each level" for names in sets)
        return Verdict("ambiguous", tuple(common), tuple(sets), f"{sure}these recordings cannot tell apart: {listed}.")
    share = 100 * (1 - left(best) / left(base))
    are, them = ("is", "it") if len(best.names) == 1 else ("are", "them")
    sentence = (
        f"{_listed(best.names)} {are} missing from the model: with {them} {share:.0f} % of the squared gap is gone, "
        f"{_mm(rest)} beyond noise is left."
    )
    return Verdict("identified", best.names, (), sentence)


def rivals(
    best: Candidate, base: Candidate, tried: Sequence[Candidate], thresholds: Thresholds, seed: int
) -> list[tuple[str, ...]]:
    """Other sets of effects, no larger than the best, that explain the recordings as well; the best of them first."""
    answers: list[tuple[str, ...]] = []
    for rival in sorted(tried, key=mean_square):
        names = rival.names
        if not names or names == best.names or len(names) > len(best.names) or names in answers:
            continue
        if not explains(rival, base, thresholds) or doubtful(rival, AWAY):
            continue
        if not clearly_worse(rival, best, thresholds, seed):
            answers.append(names)
    return answers


def clearly_worse(candidate: Candidate, than: Candidate, thresholds: Thresholds, seed: int) -> bool:
    """Whether a model's mean square is larger, certainly and by an amount that counts."""
    much = mean_square(candidate) - mean_square(than) > FACTOR * left(than) + (MARGIN * thresholds.noise) ** 2
    return much and certainly_better(than.heldout, candidate.heldout, seed)


def _parameters(base: Candidate, before: float, after: float) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in base.fit.named.items())
    return f"Stiffness and damping explain it ({values}): the gap beyond noise falls from {_mm(before)} to {_mm(after)}."


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm"
