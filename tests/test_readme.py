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


def commands():
    """Every command of README's table and of its blocks for a shell, but for those that install and test."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"```bash\n(.*?)```", text, re.DOTALL)).replace(".venv/bin/", "")
    lines = [line.rpartition("&& ")[2] for line in blocks.splitlines() if line and "pytest" not in line]
    return [*lines, *re.findall(r"\| `(hsr-[^`]+)` \|\n", text)]


def test_every_command_of_the_readme_runs_as_typed_in_a_bare_clone(tmp_path):
    (tmp_path / "data").symlink_to(ROOT / "data")
    asked = commands()
    assert len(asked) > 10 and {line.split()[0] for line in asked} > {"hsr-sim", "hsr-diagnose", "hsr-export"}
    for line in asked:
        name, *arguments = line.split()
        if name != "hsr-view":  # serves a page until it is ended
            done = subprocess.run(
                [Path(sys.executable).parent / name, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
            )
            assert (done.returncode, done.stderr.count("error")) == (0, 0), (line, done.stderr)


def test_the_program_in_the_readme_runs(tmp_path):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (tmp_path / "script.py").write_text(program, encoding="utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "is missing from the model" in done.stdout and (tmp_path / "valve-arm.html").exists()
