"""Bring the outputs that README.md and the pages in docs/ show up to date, or check that they are.

There, a block of output stands between two lines::

    <!-- output of: hsr-sim --links 4 --keq 1.11 -->
    <!-- end of output -->

A command that reads ``../shared`` needs that folder; it is left alone where the folder is absent.

    python scripts/readme.py            rewrite every block (about a quarter of an hour)
    python scripts/readme.py --quick    rewrite the blocks of quick commands (a minute)
    python scripts/readme.py --check    compare the blocks of quick commands; exit code 1 if one is not current
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
BLOCK = re.compile(r"(<!-- output of: (?P<command>.+?) -->\n).*?(<!-- end of output -->\n)", re.DOTALL)
SHARED = "../shared"


def is_slow(command: str) -> bool:
    """Diagnoses take minutes, examples are run by tests of their own; everything else takes a second."""
    diagnoses = command.startswith("hsr-diagnose") and "--help" not in command
    return diagnoses or any(word in command for word in (SHARED, "examples/", "self_test", "benchmarks/"))


def output_of(command: str) -> str:
    """What a command prints in a pipe 100 columns wide, run from the root of the repository."""
    words = shlex.split(command)
    if words[0] == "python":
        words[0] = sys.executable
    else:
        words[0] = str(Path(sys.executable).with_name(words[0]))
    environment = os.environ | {"COLUMNS": "100", "NO_COLOR": "1"}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def block_of(command: str) -> str:
    """The block as it should stand on a page: a table as it is, anything else fenced."""
    text = output_of(command)
    return text if text.startswith("|") else f"```text\n{text}```\n"


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare the quick blocks instead of rewriting all")
    parser.add_argument("--quick", action="store_true", help="rewrite the blocks of quick commands alone")
    parser.add_argument("--only", default="", metavar="TEXT", help="only the commands with this text in them")
    chosen = parser.parse_args()
    checking, wanted = chosen.check, chosen.only
    stale = []

    def current(match: re.Match[str]) -> str:
        command = match["command"]
        if (
            (is_slow(command) and (checking or chosen.quick))
            or (SHARED in command and not (ROOT / SHARED).is_dir())
            or wanted not in command
        ):
            return match[0]
        fresh = match[1] + block_of(command) + match[3]
        if fresh != match[0]:
            stale.append(command)
        return fresh

    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        renewed = BLOCK.sub(current, text)
        if not checking and renewed != text:
            page.write_text(renewed, encoding="utf-8")
    for command in stale:
        print(f"not current: {command}" if checking else f"renewed: {command}")
    return 1 if checking and stale else 0


if __name__ == "__main__":
    sys.exit(main())
