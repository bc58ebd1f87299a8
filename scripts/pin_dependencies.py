"""Write constraints.txt: every dependency of every group, for Python 3.10 to 3.13, pinned by version and hash.

Existing pins are kept as long as pyproject.toml allows them; --upgrade takes the newest version of everything. Arguments are
passed to uv. Only the public index is used, whatever this machine is configured for, and its address is not written.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HEADER = "# Every dependency, all groups, Python 3.10 to 3.13. Written by: python scripts/pin_dependencies.py\n"
COMPILE = (
    "-m uv pip compile pyproject.toml --all-extras --universal --python-version 3.10 --generate-hashes"
    " --output-file constraints.txt --no-config --no-emit-index-url --no-emit-find-links --no-header --no-annotate --quiet"
)


def main() -> None:
    """Run uv, which must be installed (group test), then write the header."""
    target = ROOT / "constraints.txt"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("UV_")}
    subprocess.run([sys.executable, *shlex.split(COMPILE), *sys.argv[1:]], check=True, cwd=ROOT, env=environment)
    pins = target.read_text(encoding="utf-8").removeprefix(HEADER)
    if "://" in pins:
        sys.exit("constraints.txt contains an address: a dependency is pinned by a URL instead of by a version")
    target.write_text(HEADER + pins, encoding="utf-8")


if __name__ == "__main__":
    main()
