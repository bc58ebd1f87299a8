"""README.md and the pages in docs/ show what their commands print, and lead somewhere."""

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


PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
LINKS = [
    (page, target)
    for page in PAGES
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    if "://" not in target
]


@pytest.mark.parametrize(("page", "target"), LINKS, ids=lambda value: getattr(value, "name", value))
def test_every_picture_and_page_that_is_linked_is_there(page, target):
    assert (page.parent / target).is_file()
