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
from collections.abc import Mapping
from functools import partial
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


def _renewed(fresh: Mapping[str, str], match: re.Match[str]) -> str:
    """Return a block with its new output, if there is one."""
    return match[1] + fresh[match["command"]] + match[3] if match["command"] in fresh else match[0]


def main() -> int:
    """Run the command line, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare the quick blocks instead of rewriting all")
    parser.add_argument("--quick", action="store_true", help="rewrite the blocks of quick commands only")
    parser.add_argument("--only", default="", metavar="TEXT", help="only the commands that contain this text")
    chosen = parser.parse_args()
    checking, wanted = chosen.check, chosen.only
    stale = []

    def is_asked(command: str) -> bool:
        left_alone = is_slow(command) and (checking or chosen.quick)
        return wanted in command and not left_alone and (SHARED not in command or (ROOT / SHARED).is_dir())

    for page in PAGES:
        commands = [match["command"] for match in BLOCK.finditer(page.read_text(encoding="utf-8"))]
        fresh = {command: block_of(command) for command in commands if is_asked(command)}
        text = page.read_text(encoding="utf-8")  # again: commands take minutes, in which the page may have been edited
        renewed = BLOCK.sub(partial(_renewed, fresh), text)
        blocks = zip(BLOCK.finditer(text), BLOCK.finditer(renewed), strict=True)
        stale += [old["command"] for old, new in blocks if old[0] != new[0]]
        if not checking and renewed != text:
            page.write_text(renewed, encoding="utf-8")
    for command in stale:
        print(f"not current: {command}" if checking else f"renewed: {command}")
    return 1 if checking and stale else 0


if __name__ == "__main__":
    sys.exit(main())
