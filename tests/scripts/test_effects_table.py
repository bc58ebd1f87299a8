"""The table of effects is generated, and the check tells a current README from a stale one."""

import importlib.util
import sys
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


def test_the_table_has_one_row_for_each_effect_in_order(script, capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["effects_table.py"])
    script.main()
    rows = capsys.readouterr().out.splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(EFFECTS)
    assert all(row.count("|") == 5 for row in rows)


def test_the_check_passes_a_current_readme_and_refuses_a_stale_one(script, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["effects_table.py", "--check"])
    monkeypatch.setattr(script, "ROOT", tmp_path)
    readme = tmp_path / "README.md"
    readme.write_text("# hsr_pin\n\n" + script.table() + "\nmore\n", encoding="utf-8")
    script.main()
    readme.write_text(readme.read_text(encoding="utf-8").replace("backlash", "play"), encoding="utf-8")
    with pytest.raises(SystemExit, match="not current"):
        script.main()
