"""The allowed import directions between the packages of hsr_pin, read from the import statements without importing anything."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "hsr_pin"

#: Each room may import itself and the rooms before it.
FOUNDATION = ["collector", "errors", "loopback", "resources", "output", "parallel", "parameters", "obstacles", "trajectory"]
WAY = [*FOUNDATION, "robot", "effects", "simulation", "inference", "identification", "diagnosis"]
#: What else a command may call.
MAY_SHOW = ["report", "explain", "robots"]
#: What knows no arm: anybody's model is judged by it.
ANY_MODEL = [*FOUNDATION, "inference", "report"]
MAY_IMPORT = {room: {*WAY[: i + 1]} for i, room in enumerate(WAY)} | {
    "identification": {*WAY[: WAY.index("identification") + 1], "recordings"},
    "inference": {*ANY_MODEL} - {"report"},
    "report": {*ANY_MODEL},
    "explain": {*ANY_MODEL, "recordings", "explain"},
    "robots": {*ANY_MODEL, "recordings", "explain", "robots"},
    "diagnosis": {*WAY, "recordings", "report"},
    "recordings": {*FOUNDATION, "recordings"},
    "replay": {*FOUNDATION, "robot", "replay"},
    "control": {*FOUNDATION, "robot", "effects", "simulation", "control"},
    "export": {*WAY[: WAY.index("identification") + 1], "recordings", "export"},
    "view": {*WAY[: WAY.index("identification") + 1], "recordings", "export", "view"},
    "blind": {*WAY, "recordings", "report", "replay", "control", "blind", "blind.plants"},
    "blind.plants": {"errors", "blind.plants"},  # an independent plant shares nothing with the model
    "cli": {*WAY, *MAY_SHOW, "recordings", "replay", "control", "export", "view", "blind", "blind.plants", "cli"},
}

#: What costs time, or may be absent, is imported where it is used.
ON_USE_ONLY = {"matplotlib", "meshcat", "mujoco", "elastica", "pybullet", "rosbags", "rich", "viser"}
FREE_TO_LOAD = {"cli", "replay"}


def room_of(module: str) -> str:
    """Return the package of a module: ``robot`` for ``hsr_pin.robot.urdf``."""
    parts = module.split(".")[1:]
    return "blind.plants" if parts[:2] == ["blind", "plants"] else parts[0] if parts else ""


def imports(module: str, text: str) -> list[tuple[str, bool]]:
    """Return every module that ``text`` imports, and whether loading ``module`` loads it."""
    found = []

    def visit(node: ast.AST, loads: bool) -> None:
        never_run = isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")
        if never_run or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            loads = False
        elif isinstance(node, ast.Import):
            found.extend((alias.name, loads) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(module.split(".")[: -node.level]) if node.level else ""
            source = ".".join(part for part in (base, node.module) if part)
            if source in ("hsr_pin", "hsr_pin.blind"):  # from hsr_pin import output: the name tells the room
                found.extend((f"{source}.{alias.name}", loads) for alias in node.names)
            else:
                found.append((source, loads))
        for child in ast.iter_child_nodes(node):
            visit(child, loads)

    visit(ast.parse(text), True)
    return found


def offences(module: str, text: str) -> list[str]:
    """Return the forbidden imports of ``module``."""
    room = room_of(module)
    wrong = []
    for target, loads in imports(module, text):
        if target.split(".")[0] == "hsr_pin":
            if room_of(target) not in MAY_IMPORT[room]:
                wrong.append(f"{module} imports {target}")
        elif loads and target.split(".")[0] in ON_USE_ONLY and room not in FREE_TO_LOAD:
            wrong.append(f"{module} loads {target}")
    return wrong


def modules() -> dict[str, str]:
    """Return name and text of every module except the top-level ``__init__``."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts)] = path.read_text(encoding="utf-8")
    del found["hsr_pin.__init__"]
    return found


def test_imports_run_one_way_through_the_rooms():
    found = modules()
    assert len(found) > 20
    assert [offence for module, text in found.items() for offence in offences(module, text)] == []


def test_every_room_has_its_place_on_the_way():
    assert {room_of(module) for module in modules()} <= MAY_IMPORT.keys()


@pytest.mark.parametrize(
    ("module", "text"),
    [
        ("hsr_pin.robot.model", "from hsr_pin.effects.effect import Effect"),
        ("hsr_pin.robot.model", "def late():\n    import hsr_pin.simulation.batch"),
        ("hsr_pin.trajectory", "from .robot import model"),
        ("hsr_pin.effects.lag", "from ..simulation.batch import simulate_batch"),
        ("hsr_pin.effects.lag", "from hsr_pin import simulate"),
        ("hsr_pin.effects.lag", "from hsr_pin import simulation"),
        ("hsr_pin.recordings.read", "from hsr_pin.robot.specification import ArmSpecification"),
        ("hsr_pin.replay.plots", "from hsr_pin.recordings.read import read_dataset"),
        ("hsr_pin.diagnosis.report", "from hsr_pin.cli.command import command"),
        ("hsr_pin.inference.fit", "from hsr_pin.control.stepping import ArmSimulator"),
        ("hsr_pin.blind.plants.arm", "from hsr_pin.robot.specification import ArmSpecification"),
        ("hsr_pin.blind.plants.arm", "from hsr_pin.blind import harness"),
        ("hsr_pin.blind.plants.arm", "import mujoco"),
        ("hsr_pin.simulation.result", "import matplotlib.pyplot as plt"),
        ("hsr_pin.simulation.result", "try:\n    from rich.table import Table\nexcept ImportError:\n    pass"),
    ],
)
def test_an_import_against_the_way_is_caught(module, text):
    assert offences(module, text)


@pytest.mark.parametrize(
    ("module", "text"),
    [
        ("hsr_pin.simulation.batch", "from hsr_pin.effects.effect import Effect\nfrom hsr_pin.trajectory import Array"),
        ("hsr_pin.recordings.c3d", "def read():\n    import rosbags"),
        ("hsr_pin.recordings.c3d", "if TYPE_CHECKING:\n    import rosbags"),
        ("hsr_pin.replay.plots", "from matplotlib.figure import Figure"),
        ("hsr_pin.blind.plants.arm", "from hsr_pin.blind.plants.laws import mounting\nfrom hsr_pin.errors import HsrError"),
        ("hsr_pin.blind.harness", "from hsr_pin.diagnosis.verdict import Verdict\nfrom hsr_pin.blind.plants import arm"),
    ],
)
def test_an_import_along_the_way_is_not(module, text):
    assert offences(module, text) == []


#: Plants by other authors, each one module written in its own way.
OTHERS = "hsr_pin.blind.plants.others."


def test_no_file_is_longer_than_400_lines():
    own = {module: text for module, text in modules().items() if not module.startswith(OTHERS)}
    assert {module: n for module, text in own.items() if (n := len(text.splitlines())) > 400} == {}
