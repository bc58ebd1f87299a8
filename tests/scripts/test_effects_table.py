"""The table of effects in the README is made from the catalogue."""

import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.spatial import SPATIAL

SCRIPT = "effects_table"


@pytest.mark.parametrize("effects", [EFFECTS, SPATIAL], ids=["any arm", "in space"])
def test_the_table_has_one_row_for_each_effect_in_order(script, effects):
    rows = script.table(effects.values()).splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(effects)
    assert all(row.count("|") == 5 for row in rows)
