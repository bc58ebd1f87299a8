"""Install hsr_pin from this checkout into .venv: uv and every dependency as pinned in constraints.txt, their hashes verified.

Needs a Python with pip, or uv. Names of dependency groups may follow: python3 scripts/install.py test
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def find_uv() -> str:
    """Return the path of uv; where it is missing, pip fetches the pinned one into .uv, which no system's rules forbid."""
    local = ROOT / ".uv" / "bin" / "uv"
    if not local.exists() and not shutil.which("uv"):
        quiet = {"PIP_ROOT_USER_ACTION": "ignore", "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_USER": "0"}
        pip = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(ROOT / ".uv"), "--no-deps", "--require-hashes"]
        with tempfile.TemporaryDirectory() as folder:
            requirement = Path(folder) / "uv.txt"
            requirement.write_text(pin("uv"), encoding="utf-8")
            subprocess.run([*pip, "--requirement", str(requirement)], check=True, env={**os.environ, **quiet})
    return str(local) if local.exists() else "uv"


def pin(package: str) -> str:
    """Return the lines of constraints.txt with the version and the hashes of a package."""
    pins = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    return re.search(rf"^{package}==.*(\n .*)*", pins, re.MULTILINE)[0]


def main() -> None:
    """Create .venv where it is missing, and bring what is in it up to date."""
    uv, groups = find_uv(), ",".join(sys.argv[1:])
    pins = ["--constraints", "constraints.txt", "--build-constraints", "constraints.txt"]
    for command in (
        ["venv", "--allow-existing", ".venv"],
        ["pip", "install", "--python", ".venv", "--compile-bytecode", *pins, "--editable", f".[{groups}]" if groups else "."],
    ):
        subprocess.run([uv, *command[:1], "--quiet", *command[1:]], check=True, cwd=ROOT)


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode)  # pip or uv has said why
