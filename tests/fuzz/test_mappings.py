"""Whatever a mapping looks like (`hsr-import --map`), the import ends: with a dataset, or with one line."""

import json
from random import Random

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from hsr_pin.cli.command import run
from hsr_pin.cli.import_ import command

from .drafts import draft_of
from .judging import PATIENCE, SETTINGS, at_most, judge, judge_files
from .trees import damaged

_POINTS = {name: [f"{name}_{axis}" for axis in "xyz"] for name in ("base", "mid", "tip")}
_ROBOT = {"length": 0.24, "mass": 0.15, "diameter": 0.04, "keq": 1.11, "damping": 0.05}
_MARKERS = [{"name": name, "arc_length": arc} for name, arc in (("base", 0.0), ("mid", 0.12), ("tip", 0.24))]
#: By what the arm of the table is; each says all that an import must know.
MAPPINGS = {
    "torque": {
        "file": {"header": 1, "separator": ",", "decimal": "."},
        "time": {"column": "t", "unit": "s"},
        "space": {"unit": "m", "up": "+z"},
        "points": _POINTS,
        "input": {"tau": "tau", "unit": "Nm"},
        "robot": _ROBOT,
        "marker": _MARKERS,
    },
    "pressures": {
        "time": {"rate": 40.0},
        "space": {"unit": 1.0, "up": "+z", "x": "+x"},
        "points": {"tip": [10, 11, 12], "mid": ["mid_x", "", "mid_z"], "base": [4, 5, 6]},
        "input": {"P1": "P1", "P2": 3, "unit": "bar"},
        "robot": _ROBOT,
        "marker": _MARKERS,
    },
    "sections": {
        "time": {"column": ["t", "t"], "unit": ["s", "ns"]},
        "space": {"up": "+z", "x": "+x", "origin": [0.0, 0.0, 0.0]},
        "points": _POINTS,
        "input": [
            {
                "columns": [f"{name}{k}" for k in (1, 2, 3)],
                "from": [f"{name}{k}" for k in (1, 2, 3)],
                "section": part,
                "gain": 0.4,
            }
            for part, name in enumerate("PQ", 1)
        ],
        "section": [{"length": 0.14, "mass": 0.09, "keq": 2.0}, {"length": 0.1, "mass": 0.06, "keq": 2.6}],
        "robot": {"length": 0.24, "mass": 0.15, "diameter": 0.04, "bending": "space", "mount": "hanging", "torsion": 0.7},
        "marker": [_MARKERS[0], {**_MARKERS[1], "radius": 0.02, "angle": 1.0}, _MARKERS[2]],
    },
}


def toml(tree):
    """A tree of two levels as TOML; what it cannot hold, such as null, becomes a text that is none."""
    lines = []
    for name, part in tree.items():
        if isinstance(part, dict):
            lines += [f"[{_key(name)}]", *_entries(part)]
        elif isinstance(part, list) and part and all(isinstance(each, dict) for each in part):
            lines += [line for each in part for line in (f"[[{_key(name)}]]", *_entries(each))]
        else:
            lines[:0] = [f"{_key(name)} = {_value(part)}"]
    return "\n".join(lines)


def _entries(table):
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items()]


def _key(name):
    return json.dumps(name, ensure_ascii=False)


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(_entries(value)) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """A recording for each of the mappings."""
    folder = tmp_path_factory.mktemp("tables")
    return {kind: draft_of(kind).write(folder / kind) / "trial_01.csv" for kind in MAPPINGS}


@pytest.fixture
def end(tables, tmp_path, monkeypatch, capsys):
    """``end(kind, mapping)``: import with a mapping and look at how it ends, in a word."""
    count = 0

    def one(kind, mapping):
        nonlocal count
        count += 1
        place = tmp_path / str(count)
        place.mkdir()
        monkeypatch.chdir(place)
        (place / "map.toml").write_text(toml(mapping), encoding="utf-8", errors="surrogatepass")
        capsys.readouterr()
        with at_most(PATIENCE):
            code = run(command, [str(tables[kind]), "-o", "out", "--map", "map.toml"])
        out, err = capsys.readouterr()
        judge(command.name, code, out, err, document=False)
        judge_files(place, code)
        return f"{kind}: exit code {code}"

    return one


@pytest.mark.parametrize("kind", MAPPINGS)
def test_a_mapping_without_a_fault_makes_a_dataset(end, kind):
    assert end(kind, MAPPINGS[kind]).endswith("exit code 0")


@settings(SETTINGS, max_examples=200)
@given(st.sampled_from(list(MAPPINGS)), st.integers(0, 1 << 30))
def test_of_200_damaged_mappings_each_ends_in_a_dataset_or_one_line(end, kind, seed):
    event(end(kind, damaged(MAPPINGS[kind], Random(seed))))


@pytest.mark.long
@settings(SETTINGS, max_examples=2000)
@given(st.sampled_from(list(MAPPINGS)), st.integers(0, 1 << 30))
def test_of_2000_damaged_mappings_each_ends_in_a_dataset_or_one_line(end, kind, seed):
    event(end(kind, damaged(MAPPINGS[kind], Random(seed))))
