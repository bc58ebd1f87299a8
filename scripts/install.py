"""Install hsr_pin from this checkout into .venv, with uv and every dependency as pinned in constraints.txt, hashes verified.

The inner loops of the simulation are compiled too, once for this machine. A Python with pip, or uv, is needed. Names of
dependency groups may follow: python3 scripts/install.py test. With --no-compile the first simulation compiles the loops.
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
    """Return the path of uv; if it is missing, pip installs the pinned version into .uv, which no system policy forbids."""
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


#: Programs that compile the loops, run in parallel.
LOOPS = (
    "from hsr_pin.simulation.compiled import loops; loops()",
    "from hsr_pin.simulation.compiled import marker_projector, precompile_laws; "
    "from hsr_pin.effects.catalogue import laws; marker_projector(); "
    "precompile_laws(laws(space=False))",
)


def compile_loops() -> None:
    """Compile the inner loops into numba's cache; if this fails, the first simulation compiles them, and reports an error."""
    python = ROOT / ".venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    started = [subprocess.Popen([python, "-c", code], cwd=ROOT, stderr=subprocess.DEVNULL) for code in LOOPS]
    for process in started:
        process.wait()


def main() -> None:
    """Create .venv if it is missing, and update its packages."""
    asked = sys.argv[1:]
    uv, groups = find_uv(), ",".join(word for word in asked if word != "--no-compile")
    pins = ["--constraints", "constraints.txt", "--build-constraints", "constraints.txt"]
    for command in (
        ["venv", "--allow-existing", ".venv"],
        ["pip", "install", "--python", ".venv", "--compile-bytecode", *pins, "--editable", f".[{groups}]" if groups else "."],
    ):
        subprocess.run([uv, *command[:1], "--quiet", *command[1:]], check=True, cwd=ROOT)
    if "--no-compile" not in asked:
        print("compiling the inner loops, once for this machine (half a minute)", flush=True)
        compile_loops()


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode)  # pip or uv has printed the reason
