"""The distributed files: the public names, the wheel, the pinned versions, and files without machine-specific paths."""

import ast
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import hsr_pin
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import load_urdf

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def run(*command: object, cwd: Path = ROOT, **environment: str) -> str:
    """Run a command that must succeed, and return what it prints."""
    inherited = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run([str(part) for part in command], cwd=cwd, env=inherited | environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


# The front door


def test_every_public_name_resolves():
    names = {name: hsr_pin._MODULES[name].partition(":")[2] or name for name in hsr_pin.__all__}
    assert all(getattr(hsr_pin, name).__name__ == own for name, own in names.items())


def test_the_three_lists_of_the_front_door_agree():
    tree = ast.parse(Path(hsr_pin.__file__).read_text(encoding="utf-8"))
    (checked,) = [node.body for node in tree.body if isinstance(node, ast.If)]
    aliases = [(node.module, alias) for node in checked for alias in node.names]
    for_type_checkers = {
        alias.asname or alias.name: f"{module}:{alias.name}" if alias.asname else module for module, alias in aliases
    }
    assert for_type_checkers == {name: f"hsr_pin.{module}" for name, module in hsr_pin._MODULES.items()}
    assert sorted(for_type_checkers) == sorted(hsr_pin.__all__)


def test_the_version_is_that_of_the_project():
    assert hsr_pin.__version__ == PROJECT["version"]


def test_an_unknown_name_is_answered_with_those_on_offer():
    with pytest.raises(AttributeError, match="simulate_batch"):
        hsr_pin.simulate_bach  # noqa: B018


def test_importing_the_package_loads_nothing_heavy():
    loaded = run(sys.executable, "-c", "import hsr_pin, sys; print(*sys.modules)").split()
    assert "hsr_pin" in loaded
    assert not {"numpy", "scipy", "pinocchio", "matplotlib", "meshcat", "rich"} & {*loaded}


# The wheel


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built by the declared build backend without network access."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder)
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_carries_the_package_the_template_the_data_and_the_licence(wheel):
    names = {*zipfile.ZipFile(wheel).namelist()}
    for folder in ("urdf_templates", "data/samples"):
        shipped = {f"hsr_pin/{path.relative_to(ROOT).as_posix()}" for path in (ROOT / folder).rglob("*") if path.is_file()}
        assert shipped, folder
        assert shipped <= names
    assert [name for name in names if name.startswith("hsr_pin/data/") and "/samples/" not in name] == [
        "hsr_pin/data/hsr2022_table2.csv"
    ]
    modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / "hsr_pin").rglob("*.py")}
    assert modules <= names
    assert "hsr_pin/py.typed" in names
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert not [name for name in names if name.startswith("tests/")]


def test_the_wheel_works_in_a_clean_environment_from_another_folder(wheel, tmp_path):
    uv, environment = (sys.executable, "-m", "uv"), tmp_path / "environment"
    run(*uv, "venv", "--quiet", "--python", sys.executable, environment)
    install = (*uv, "pip", "install", "--quiet", "--python", environment, "--constraints", ROOT / "constraints.txt", wheel)
    try:
        run(*install, "--offline")  # all of it is in uv's cache where uv has made this environment
    except AssertionError:
        run(*install)
    run(environment / "bin" / "hsr-urdf", "--links", 3, "--output", "arm.urdf", cwd=tmp_path)
    assert load_urdf(tmp_path / "arm.urdf") == ArmSpecification(links=3, placement="mid")
    script = "import hsr_pin.robot.pressure as p; print(p.__file__, len(p.measured_rows()))"
    where, rows = run(environment / "bin" / "python", "-c", script, cwd=tmp_path).split()
    assert where.startswith(str(environment))
    assert rows == "16"


# The pins


def pins():
    """Return the versions pinned in constraints.txt by name, each with a hash."""
    found = {}
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    for entry in re.sub(r"\\\n\s+", "", text).splitlines():
        if entry.startswith("#"):
            continue
        matched = re.fullmatch(r"(\S+)==(\S+)( ; .*?)?((?: ?--hash=sha256:[0-9a-f]{64})+)", entry.rstrip())
        assert matched, f"not pinned by version and hash: {entry[:80]}"
        found.setdefault(matched[1], []).append(matched[2])
    return found


def test_every_declared_dependency_is_pinned_by_version_and_hash():
    groups = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    declared = [Requirement(line) for group in groups for line in group if not line.startswith("hsr_pin")]
    pinned = pins()
    assert len(declared) > 15
    for requirement in declared:
        versions = pinned[requirement.name.lower()]
        assert all(version in requirement.specifier for version in versions), requirement


# The files


def tracked():
    """Yield every text file under version control."""
    try:
        names = run("git", "ls-files", "-z").split("\0")[:-1]
    except (AssertionError, FileNotFoundError):
        pytest.skip("needs git and a checkout")
    for name in names:
        try:
            yield name, (ROOT / name).read_text(encoding="utf-8")
        except (UnicodeDecodeError, FileNotFoundError):  # a picture; a file about to be removed
            continue


#: A place on somebody's machine; an address that dependencies come from.
MACHINE_PATH = re.compile(r"(?<![\w.})~-])/(?:work|home|root|Users|opt|mnt)/\w")
PACKAGE_INDEX = re.compile(r"(?:index-url|find-links)[ =\"']+(?:\w+:|/)|:/[/]\S+/simple\b|python[h]osted")


def test_no_file_names_a_place_on_one_machine_or_a_package_index():
    files = dict(tracked())
    assert "uv.lock" not in files
    found = [name for name, text in files.items() if MACHINE_PATH.search(text) or PACKAGE_INDEX.search(text)]
    assert found == []


@pytest.mark.parametrize("text", ["see {}work/shared", "open('{}home/me/arm.urdf')", "file:{0}{0}{0}root/x"])
def test_a_place_on_one_machine_is_caught(text):
    assert MACHINE_PATH.search(text.format("/"))


@pytest.mark.parametrize("text", ["--index{}url={}", "extra-index{}url = {}", "--find{}links {}", "registry {}= '{}/simple'"])
def test_a_package_index_is_caught(text):
    assert PACKAGE_INDEX.search(text.format("-", "https://example.org"))


def test_the_version_is_the_same_everywhere():
    citation = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    changelog = re.search(r"^## \[(\d\S*)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert citation and changelog
    assert citation[1] == changelog[1] == PROJECT["version"]
