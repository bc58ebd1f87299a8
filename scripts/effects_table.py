"""Print the catalogue of effects as Markdown tables: effects of any arm, and effects of arms in space only."""

from collections.abc import Iterable

from hsr_pin.effects import EFFECTS, Effect
from hsr_pin.effects.spatial import SPATIAL

HEADER = "| name | what the nominal model lacks | typical cause | parameters |\n|---|---|---|---|\n"


def row(effect: type[Effect]) -> str:
    """Return one row of the table: amplitudes with their bounds first, then shapes, then options."""
    facts = sorted(effect.parameters(), key=lambda fact: not fact.amplitude)
    units = {fact.name: "" if fact.unit == "1" else f" {fact.unit}" for fact in facts}
    words = [f"`{fact.name}` {fact.lower:g} to {fact.upper:g}{units[fact.name]}" for fact in facts]
    words += [f"`{name}` {' or '.join(choices)}" for name, choices in effect.choices().items()]
    return f"| `{effect.name}` | {effect.lacks} | {effect.cause} | {', '.join(words)} |\n"


def table(effects: Iterable[type[Effect]]) -> str:
    """Return a whole table, in the order of the catalogue."""
    return HEADER + "".join(map(row, effects))


if __name__ == "__main__":
    print(table(EFFECTS.values()))
    print("Arms in space alone have:\n")
    print(table(SPATIAL.values()), end="")
