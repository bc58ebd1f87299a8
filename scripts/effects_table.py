"""Print the catalogue of effects as a Markdown table. ``--check`` says instead whether README.md holds exactly that table."""

import sys
from pathlib import Path

from hsr_pin.effects import EFFECTS, Effect

ROOT = Path(__file__).resolve().parent.parent
HEADER = "| name | what the nominal model lacks | typical cause | parameters |\n|---|---|---|---|\n"


def row(effect: type[Effect]) -> str:
    """One line: amplitudes with their bounds first, then shapes, then options."""
    facts = sorted(effect.parameters(), key=lambda fact: not fact.amplitude)
    units = {fact.name: "" if fact.unit == "1" else f" {fact.unit}" for fact in facts}
    words = [f"`{fact.name}` {fact.lower:g} to {fact.upper:g}{units[fact.name]}" for fact in facts]
    words += [f"`{name}` {' or '.join(choices)}" for name, choices in effect.choices().items()]
    return f"| `{effect.name}` | {effect.lacks} | {effect.cause} | {', '.join(words)} |\n"


def table() -> str:
    """The whole table, in the order of the catalogue."""
    return HEADER + "".join(row(effect) for effect in EFFECTS.values())


def main() -> None:
    """Print the table, or check README.md."""
    if sys.argv[1:] == ["--check"]:
        if table() not in (ROOT / "README.md").read_text(encoding="utf-8"):
            sys.exit("README.md: the table of effects is not current; paste what scripts/effects_table.py prints")
    else:
        print(table(), end="")


if __name__ == "__main__":
    main()
