"""The table of effects in the README is made from the catalogue."""

import importlib.util
from pathlib import Path

import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.spatial import SPATIAL


@pytest.fixture
def script():
    path = Path(__file__).resolve().parents[2] / "scripts" / "effects_table.py"
    specification = importlib.util.spec_from_file_location("effects_table", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize("effects", [EFFECTS, SPATIAL], ids=["any arm", "in space"])
def test_the_table_has_one_row_for_each_effect_in_order(script, effects):
    rows = script.table(effects.values()).splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(effects)
    assert all(row.count("|") == 5 for row in rows)
