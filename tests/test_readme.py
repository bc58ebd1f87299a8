"""README.md shows what its commands print."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "scripts" / "readme.py"


def test_the_outputs_of_quick_commands_are_current():
    done = subprocess.run([sys.executable, SCRIPT, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_stale_output_is_found(tmp_path):
    copy = tmp_path / "scripts" / "readme.py"
    copy.parent.mkdir()
    copy.write_text(SCRIPT.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "README.md").write_text(
        "<!-- output of: python -c 'print(2)' -->\n```text\n1\n```\n<!-- end of output -->\n", encoding="utf-8"
    )
    done = subprocess.run([sys.executable, copy, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "not current: python -c 'print(2)'" in done.stdout


@pytest.mark.parametrize("picture", re.findall(r"!\[.*?\]\((.*?)\)", (ROOT / "README.md").read_text(encoding="utf-8")))
def test_every_picture_is_there(picture):
    assert (ROOT / picture).is_file()
