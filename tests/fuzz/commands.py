"""The mix of commands: how often each is run, and with what. One table."""

from __future__ import annotations

import json
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from hsr_pin.cli.blind import command as blind
from hsr_pin.cli.diagnose import command as diagnose
from hsr_pin.cli.export import command as export
from hsr_pin.cli.fit import command as fit
from hsr_pin.cli.import_ import command as import_
from hsr_pin.cli.replay import command as replay
from hsr_pin.cli.sim import command as sim
from hsr_pin.cli.view import command as view

from .drafts import Draft, draft_of

#: A chain of few links, and one candidate: a diagnosis takes seconds as it is.
_FEW = ["--links", "2"]
_ONE = [*_FEW, "--jobs", "1", "--effects", "tip_mass"]


def _rows(data: Path) -> list[list[str]]:
    """What stands in a trial's file, whatever it is."""
    file = data / "trial_01.csv"
    text = file.read_text(encoding="utf-8", errors="surrogateescape") if file.exists() else ""
    return [line.split(",") for line in text.split("\n")]


def _written(file: Path, rows: list[list[str]]) -> str:
    file.write_text("\n".join(",".join(row) for row in rows), encoding="utf-8", errors="surrogateescape")
    return str(file)


def _commanded(data: Path) -> str:
    """The times and inputs of a trial as a file of commands."""
    rows = _rows(data)
    columns = [place for place, name in enumerate(rows[0]) if name in ("t", "tau", "P1", "P2")]
    return _written(data.parent / "in.csv", [[row[place] for place in columns if place < len(row)] for row in rows])


def _captured(data: Path) -> str:
    """The markers of a trial as Vicon Nexus would write them."""
    header, *rows = _rows(data)
    points = [name.removesuffix("_x") for name in header if name.endswith("_x")]
    tops = [["Trajectories"], ["40"], ["", *(cell for name in points for cell in ("", f"Arm:{name}", ""))]]
    tops += [["Frame", "Sub Frame", *["X", "Y", "Z"] * len(points)], ["", "", *["m"] * 3 * len(points)]]
    body = [[str(number), "0", *row[-3 * len(points) :]] for number, row in enumerate(rows, 1) if any(row)]
    return _written(data.parent / "take.csv", [*tops, *body])


def _checked(data: Path) -> str:
    """A folder for `hsr-blind` with the dataset as its only case, diagnosed already."""
    check = data.parent / "check"
    check.mkdir()
    (check / "case_001").symlink_to(data)
    (check / "verdicts").mkdir()
    (check / "verdicts" / "case_001.json").write_text(json.dumps({"dataset": "x", "verdict": {}}))
    return str(check)


@lru_cache(maxsize=1)
def _sound() -> Draft:
    return draft_of("torque")


def _other(data: Path) -> str:
    """Recordings of the same arm without a fault."""
    return str(_sound().write(data.parent / "sound"))


def _mapped(data: Path) -> list[str]:
    """A trial as a table of one's own, with a mapping of its times, markers and inputs."""
    header = [name for name in _rows(data)[0] if name.isprintable()]
    points = [name.removesuffix("_x") for name in header if name.endswith("_x")]
    rows = [f"{json.dumps(name)} = {json.dumps([f'{name}_{axis}' for axis in 'xyz'])}" for name in points]
    inputs = [f'{name} = "{name}"' for name in header if name in ("tau", "P1", "P2")]
    parts = ["[time]", 'column = "t"', "[space]", 'up = "+z"', "[points]", *rows, *(["[input]", *inputs] if inputs else [])]
    return [str(data / "trial_01.csv"), "--map", _written(data.parent / "map.toml", [[line] for line in parts])]


def _found(data: Path) -> str:
    """A result, of these recordings."""
    numbers = {"keq_scale": 1.1, "tip_mass.mass": 0.02}
    candidate = {"effects": ["tip_mass"], "options": {}, "parameters": {name: {"value": v} for name, v in numbers.items()}}
    verdict = {"status": "identified", "effects": ["tip_mass"], "sentence": "tip_mass is missing from the model."}
    result = {"schema": 1, "dataset": "x", "verdict": verdict, "candidates": [candidate]}
    path = data.parent / "found.json"
    path.write_text(json.dumps(result))
    return str(path)


#: What `hsr-import` must be told.
_ARM = ["--mass", "0.15", "--diameter", "0.04", "--keq", "1.11", "--base", "base", "-m", "tip@0.24=Arm:tip"]

#: So many of all, the command, its arguments for a dataset, whether its output is one JSON document.
TABLE = (
    (5, sim, lambda data: ["--against", str(data), *_FEW, "--json"], True),
    (2, sim, lambda data: ["--against", str(data)], False),
    (1, sim, lambda data: ["--against", str(data), *_FEW, "--effect", "dry_friction:level=0.05", "--json"], True),
    (1, sim, lambda data: ["--input", _commanded(data), "--csv", "out", "--json"], True),
    (3, replay, lambda data: [str(data), *_FEW, "--json"], True),
    (1, replay, lambda data: [str(data), *_FEW, "--html", "out.html"], False),
    (1, replay, lambda data: [str(data), *_FEW, "--plot", "out.png"], False),
    (2, fit, lambda data: [str(data), *_FEW, "--json", "-"], True),
    (1, fit, lambda data: [str(data), *_FEW, "--free", "keq,tip_mass", "--json", "-"], True),
    (1, fit, lambda data: [str(data), *_FEW, "--plot", "out.svg", "--urdf", "out.urdf", "--json", "out.json"], False),
    (1, import_, lambda data: [_captured(data), "--list"], False),
    (1, import_, lambda data: [_captured(data), "-o", "out", *_ARM], False),
    (1, import_, lambda data: ["-o", "out", *_ARM[:-1], "tip@0.24=tip", *_mapped(data)], False),
    (1, export, lambda data: ["--to", "mjcf", "--from", _found(data), "--dataset", str(data), "-o", "out.xml"], False),
    (1, export, lambda data: ["--to", "urdf", "--from", _found(data), "--dataset", str(data), "-o", "out.urdf"], False),
    *([(1, view, lambda data: [str(data), "--no-open", "--from", _found(data)], False)] if find_spec("viser") else []),
    (1, blind, lambda data: ["run", _checked(data)], False),
    (1, diagnose, lambda data: [str(data), *_ONE, "--max-effects", "1", "--json", "-"], True),
    (1, diagnose, lambda data: [str(data), "--since", _other(data), *_ONE, "--json", "-"], True),
    (1, diagnose, lambda data: [_other(data), "--since", str(data), *_ONE, "--json", "out.json", "--html", "out.html"], False),
)
