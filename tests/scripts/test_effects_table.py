"""The table of effects in the README is made from the catalogue."""

import importlib.util
from pathlib import Path

import pytest

from hsr_pin.effects import EFFECTS


@pytest.fixture
def script():
    path = Path(__file__).resolve().parents[2] / "scripts" / "effects_table.py"
    specification = importlib.util.spec_from_file_location("effects_table", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_table_has_one_row_for_each_effect_in_order(script):
    rows = script.table().splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(EFFECTS)
    assert all(row.count("|") == 5 for row in rows)
