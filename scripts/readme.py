"""Update the command outputs in README.md and on the pages in docs/, or check that they are current.

A block of output stands between two lines::

    <!-- output of: hsr-sim --links 4 --keq 1.11 -->
    <!-- end of output -->

A command that reads ``../shared`` needs that folder; its block is left unchanged if the folder is absent.

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
    """Return whether a command takes more than about a second, or is run by tests of its own, such as diagnoses and examples."""
    diagnoses = command.startswith("hsr-diagnose") and "--help" not in command
    return diagnoses or any(word in command for word in (SHARED, "examples/", "self_test", "benchmarks/"))


def output_of(command: str) -> str:
    """Return the output of a command in a pipe 100 columns wide, run from the root of the repository."""
    words = shlex.split(command)
    if words[0] == "python":
        words[0] = sys.executable
    else:
        words[0] = str(Path(sys.executable).with_name(words[0]))
    environment = os.environ | {"COLUMNS": "100", "NO_COLOR": "1"}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines()) + "\n"


def block_of(command: str) -> str:
    """Return the content of a block: a table unchanged, other output in a fenced block."""
    text = output_of(command)
    return text if text.startswith("|") else f"```text\n{text}```\n"


def main() -> int:
    """Run the command line, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare the quick blocks instead of rewriting all")
    parser.add_argument("--quick", action="store_true", help="rewrite the blocks of quick commands only")
    parser.add_argument("--only", default="", metavar="TEXT", help="only the commands that contain this text")
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
