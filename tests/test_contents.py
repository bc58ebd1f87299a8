"""A package that lists its modules in its docstring lists all of them, and no others."""

import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "hsr_pin"
ENTRY = re.compile(r"^- ``(\w+)``: ", re.MULTILINE)
LISTS = [door for door in sorted(PACKAGE.rglob("__init__.py")) if ENTRY.search(door.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("door", LISTS, ids=lambda door: door.parent.name)
def test_the_table_of_contents_is_complete_and_sorted(door):
    listed = ENTRY.findall(door.read_text(encoding="utf-8"))
    inside = {path.stem for path in door.parent.glob("*.py")} | {path.parent.name for path in door.parent.glob("*/__init__.py")}
    assert listed == sorted(inside - {"__init__"})


def test_the_large_rooms_have_one():
    assert {"diagnosis", "identification", "plants", "replay", "robot", "simulation"} <= {door.parent.name for door in LISTS}
