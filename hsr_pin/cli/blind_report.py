"""Printed report of ``hsr-blind score``: rates, grades, calibration and all misses."""

from __future__ import annotations

from hsr_pin.blind.changes import ChangeScore
from hsr_pin.blind.outcome import GRADES, Outcome
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.reliability import Reliability
from hsr_pin.blind.scoring import FACTS, Score


def report(score: Score) -> str:
    """Return the report on a score as text."""
    parts = [f"{len(score.outcomes)} cases diagnosed" + _missing(score), _rates(score.rates)]
    if set(score.tiers) - {"clean"}:
        parts.append(_grades(score))
    if trust := score.reliability():
        parts.append(_calibration(trust))
    return "\n\n".join([*parts, _misses(score.misses)])


def report_changes(score: ChangeScore) -> str:
    """Return the report on a score of pairs of recordings as text."""
    wrong = tuple(
        outcome for outcome, size in zip(score.outcomes, score.sizes, strict=True) if not outcome.exact or size is False
    )
    return "\n\n".join([f"{len(score.outcomes)} pairs diagnosed" + _missing(score), _rates(score.rates), _misses(wrong)])


def _missing(score: Score | ChangeScore) -> str:
    if not score.missing:
        return ""
    return f", {len(score.missing)} not diagnosed: {', '.join(score.missing[:5])}{' ...' * (len(score.missing) > 5)}"


def _rates(rates: dict[str, Rate]) -> str:
    known = {name: rate for name, rate in rates.items() if rate.of}
    width = max(map(len, known), default=0)
    return "\n".join(f"{name:<{width}}  {rate}" for name, rate in known.items())


def _grades(score: Score) -> str:
    """Return a table of the grades of each tier and kind of case."""
    cases = dict.fromkeys((outcome.answer.tier, outcome.answer.kind) for outcome in score.outcomes)
    lines = ["tier and kind of case".ljust(24) + "".join(f"{grade:>14}" for grade in GRADES)]
    for tier, kind in sorted(cases):
        counts = score.grades(tier, kind)
        lines.append(f"{tier}, {kind}".ljust(24) + "".join(f"{counts[grade] or '.':>14}" for grade in GRADES))
    return "\n".join(lines)


def _calibration(found: Reliability) -> str:
    low, high = found.interval
    mean, most = found.by_chance
    head = f"expected calibration error {found.error:.3f} (95 % interval {low:.3f} to {high:.3f});"
    lines = [head, f"perfect calibration would give {mean:.3f} on average, and rarely more than {most:.3f}"]
    lines += [f"  stated {each.low:.1f} to {each.high:.1f} (mean {each.stated:.2f}): right {each.right}" for each in found.bins]
    return "\n".join(lines)


def _misses(misses: tuple[Outcome, ...]) -> str:
    if not misses:
        return "no misses"
    return "\n".join([f"{len(misses)} misses:", *map(_miss, misses)])


def _miss(outcome: Outcome) -> str:
    answer = outcome.answer
    truth = " + ".join(answer.effects) or "nothing"
    tier = answer.tier if answer.tier != "clean" else ""
    about = ", ".join(filter(None, (tier, answer.kind, answer.size, *(str(answer.facts.get(key, "")) for key in FACTS))))
    wrong = "WRONG NAME, " * outcome.wrong_name + "WRONG KIND, " * outcome.wrong_kind
    wrong += "kind right, " * (outcome.grade == "kind")
    return f"{answer.name}  {truth} ({about})\n    {wrong}{outcome.status}: {outcome.sentence}"
