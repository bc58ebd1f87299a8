"""What ``hsr-blind score`` prints: rates, the confusion matrix, every miss."""

from __future__ import annotations

from textwrap import wrap

from hsr_pin.blind.scoring import FACTS, Outcome, Score


def report(score: Score) -> str:
    """The whole text."""
    parts = [f"{len(score.outcomes)} cases diagnosed" + _missing(score), _rates(score), _matrix(score), _misses(score)]
    return "\n\n".join(parts)


def _missing(score: Score) -> str:
    return (
        f", {len(score.missing)} not: {', '.join(score.missing[:5])}{' ...' * (len(score.missing) > 5)}" if score.missing else ""
    )


def _rates(score: Score) -> str:
    width = max(map(len, score.rates))
    return "\n".join(f"{name:<{width}}  {rate}" for name, rate in score.rates.items())


def _matrix(score: Score) -> str:
    """Rows: truth; columns: verdicts, by number: effects have that of their row."""
    width = max(map(len, score.rows)) + 4
    shared = {name: k for k, name in enumerate(score.rows, start=1)}
    lines = ["truth \\ verdict".ljust(width) + "".join(f"{k:3d}" for k in range(1, len(score.columns) + 1))]
    for name, counts in zip(score.rows, score.counts, strict=True):
        cells = "".join(f"{count or '.':>3}" for count in counts)
        lines.append(f"{shared[name]:2d} {name}".ljust(width) + cells)
    others = [f"{k} {name}" for k, name in enumerate(score.columns, start=1) if shared.get(name) != k]
    legend = f"columns: 1 to {len(score.columns) - len(others)} as the rows; {'; '.join(others)}"
    return "\n".join([*lines, *wrap(legend, len(lines[0]))])


def _misses(score: Score) -> str:
    if not score.misses:
        return "no misses"
    return "\n".join([f"{len(score.misses)} misses:", *map(_miss, score.misses)])


def _miss(outcome: Outcome) -> str:
    answer = outcome.answer
    truth = " + ".join(answer.effects) or "nothing"
    about = ", ".join(filter(None, (answer.kind, answer.size, *(str(answer.facts.get(key, "")) for key in FACTS))))
    wrong = "WRONG NAME, " * outcome.wrong_name
    return f"{answer.name}  {truth} ({about})\n    {wrong}{outcome.status}: {outcome.sentence}"
