"""Machine code is made once for a machine, is never out of date, and does without a folder to keep it in."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hsr_pin
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.compiled import loops
from hsr_pin.simulation.scenario import step_scenario

PACKAGE = Path(hsr_pin.__file__).parent

#: Run in a copy of the package: compile (or load) a law, and the loops if asked to, and tell what came from the cache.
PROGRAM = """
import json, sys
from hsr_pin.effects import parse_effect
from hsr_pin.simulation import laws
law = parse_effect("dry_friction:level=0.1")
address = laws.address(law, "update")
code = laws._compiled(type(law), "update", law.options, False)
found = {"law": code.cache_hits > 0, "address": address != 0}
if "loops" in sys.argv:
    from hsr_pin.simulation.compiled import loops
    found["loops"] = [sum(loop.stats.cache_hits.values()) > 0 for loop in loops()]
    from hsr_pin.robot.specification import ArmSpecification
    from hsr_pin.simulation.batch import simulate_batch
    from hsr_pin.simulation.scenario import step_scenario
    (run,) = simulate_batch([step_scenario(ArmSpecification(), 0.5, effects=(law,))])
    found["tip"] = run.trajectory.positions[-1, -1].tolist()
print(json.dumps(found))
"""


class Installation:
    """A copy of the package, and processes that use it."""

    def __init__(self, folder):
        self.folder, self.home = folder, folder / "home"
        shutil.copytree(PACKAGE, folder / "hsr_pin", ignore=shutil.ignore_patterns("__pycache__"))
        self.home.mkdir()

    def start(self, *arguments, home=None, limit=None):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA", "XDG"))}
        environment |= {"PYTHONPATH": str(self.folder), "HOME": str(home or self.home), "PYTHONDONTWRITEBYTECODE": "1"}
        limited = "" if limit is None else f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))"
        command = [sys.executable, "-c", limited + PROGRAM, *arguments]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen(command, env=environment, cwd=self.folder, text=True, **pipes)  # away from the other package

    def run(self, *arguments, **how):
        return self.ended(self.start(*arguments, **how))

    @staticmethod
    def ended(process):
        """What a process found, and what it said on standard error."""
        out, err = process.communicate(timeout=600)
        assert process.returncode == 0, err
        return json.loads(out), err

    def lock(self):
        """Leave no place beside the sources: a file stands where each folder for the cache would be (root minds no mode)."""
        for folder in {path.parent for path in (self.folder / "hsr_pin").rglob("*.py")}:
            (folder / "__pycache__").write_text("")

    def edit(self, name, old, new):
        path = self.folder / "hsr_pin" / name
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")

    def kept(self, where):
        return sorted(path.name for path in where.rglob("*.nbi"))


@pytest.fixture
def installation(tmp_path):
    return Installation(tmp_path)


def test_a_second_process_finds_the_law_that_the_first_compiled(installation):
    assert [installation.run()[0]["law"] for _ in range(2)] == [False, True]
    assert installation.kept(installation.folder / "hsr_pin" / "effects")
    assert not installation.kept(installation.home)


def test_where_the_installation_cannot_be_written_to_the_users_cache_is_used(installation):
    installation.lock()
    assert [installation.run()[0]["law"] for _ in range(2)] == [False, True]
    assert installation.kept(installation.home)


def test_without_any_folder_to_keep_it_in_a_law_is_compiled_in_every_process(installation):
    installation.lock()
    nowhere = installation.folder / "hsr_pin" / "__init__.py" / "home"  # beneath a file
    for _ in range(2):
        assert installation.run(home=nowhere)[0] == {"law": False, "address": True}


@pytest.mark.parametrize("part", [pytest.param("loops", marks=pytest.mark.long), "law"])
@pytest.mark.parametrize(
    "damage",
    [
        "half an index",
        "a folder",
        *(pytest.param(each, marks=pytest.mark.long) for each in ("empty index", "half the code", "no pickle")),
    ],
)
def test_a_damaged_cache_is_told_once_and_made_anew(installation, damage, part):
    installation.run(part)
    for path in installation.folder.rglob("*.nbc" if damage == "half the code" else "*.nbi"):
        content = path.read_bytes()
        path.unlink()
        if damage == "a folder":
            path.mkdir()
        else:
            path.write_bytes({"empty index": b"", "no pickle": b"\0no pickle" * 9}.get(damage, content[: len(content) // 2]))
    found, said = installation.run(part)
    assert not found["law"] and found["address"]
    assert said.count("is damaged and is compiled again") == 1
    again, silent = installation.run(part)
    if damage == "a folder":  # which stands in the way for good
        assert "cannot save machine code in" in silent
    else:
        assert (again["law"], silent) == (True, "")


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
@pytest.mark.parametrize("part", [pytest.param("loops", marks=pytest.mark.long), "law"])
def test_a_full_disk_is_told_once_and_what_was_written_is_mended(installation, part):
    found, said = installation.run(part, limit=1000)
    assert found["address"]
    (line,) = [line for line in said.splitlines() if "compiling" not in line]
    folder = installation.folder / "hsr_pin" / "effects" / "__pycache__"  # of the law, which is compiled first
    assert line.startswith(f"hsr_pin: cannot save machine code in {folder} (File too large), so every process compiles it")
    assert line.endswith("free some space there, or set NUMBA_CACHE_DIR to another folder")
    assert [installation.run(part)[0]["law"] for _ in range(2)] == [False, True]


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("effects/dry_friction.py", "SHORTEST, CONTACT = 0.005, 25.0", "SHORTEST, CONTACT = 0.006, 25.0"),
        ("effects/vector.py", "_NOTHING = 1e-300", "_NOTHING = 1e-299"),
        ("simulation/laws.py", "out[m] = 1.0 * law", "out[m] = 1.00 * law"),
    ],
)
def test_a_change_of_what_a_law_is_made_from_makes_new_code(installation, name, old, new):
    installation.run()
    stamp = (installation.folder / "hsr_pin" / name).stat()
    installation.edit(name, old, new)
    os.utime(installation.folder / "hsr_pin" / name, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # as some copies do
    assert [installation.run()[0]["law"] for _ in range(2)] == [False, True]


@pytest.mark.long
@pytest.mark.parametrize("how", ["kept", "locked"])
def test_the_loops_are_compiled_once_and_that_is_said_once(installation, how):
    if how == "locked":
        installation.lock()
    first, second = installation.run("loops"), installation.run("loops")
    assert first[0]["loops"] == [False] * 4
    assert second[0]["loops"] == [True] * 4
    assert first[0]["tip"] == second[0]["tip"]
    assert first[1].count("compiling") == 1
    assert "once on this machine" in first[1]
    assert second[1] == ""


@pytest.mark.long
def test_the_loops_without_a_folder_say_that_every_process_compiles_them(installation):
    installation.lock()
    found, said = installation.run("loops", home=installation.folder / "hsr_pin" / "__init__.py")
    assert found["loops"] == [False] * 4
    assert said.count("compiling") == 1
    assert "NUMBA_CACHE_DIR" in said


@pytest.mark.long
def test_a_change_of_the_loops_makes_new_code(installation):
    installation.run("loops")
    installation.edit("simulation/kernel.py", "y = 1.0 - x", "y = 1.00 - x")
    assert installation.run("loops")[0]["loops"] == [False] * 4


def test_processes_that_compile_at_once_do_no_harm(installation):
    processes = [installation.start() for _ in range(4)]
    assert all(installation.ended(process)[0]["address"] for process in processes)
    assert installation.run()[0]["law"]


@pytest.mark.long
def test_processes_that_compile_the_loops_at_once_do_no_harm(installation):
    found = [installation.ended(process)[0] for process in [installation.start("loops") for _ in range(2)]]
    assert found[0]["tip"] == found[1]["tip"]
    assert all(installation.run("loops")[0]["loops"])


def test_threads_that_ask_at_once_get_the_same_loops():
    scenarios = [step_scenario(ArmSpecification(keq=1 + i / 10), 0.5, duration=0.3) for i in range(6)]
    together, alone = simulate_batch(scenarios, threads=3), simulate_batch(scenarios)
    for one, other in zip(together, alone, strict=True):
        np.testing.assert_array_equal(one.trajectory.positions, other.trajectory.positions)
    assert loops() is loops()


@pytest.mark.parametrize(
    "code",
    [
        "import hsr_pin",
        "from hsr_pin.cli.sim import command\nfrom hsr_pin.cli.command import run\nassert run(command, ['--json']) == 0",
        "from hsr_pin.simulation.simulate import simulate\nimport hsr_pin.simulation.sensitivity, hsr_pin.simulation.inverse",
    ],
    ids=["import", "hsr-sim", "modules"],
)
def test_what_does_without_machine_code_does_not_load_its_compiler(code):
    result = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys\nprint(sorted({{'numba', 'llvmlite'}} & {{*sys.modules}}), file=sys.stderr)"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert result.stderr == "[]\n"
