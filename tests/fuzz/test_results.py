"""Whatever a result looks like that is read back (`--from`), hsr-export and hsr-view end: with a model, or with one line."""

import copy
import json
from random import Random
from types import SimpleNamespace

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from hsr_pin.cli.command import run
from hsr_pin.cli.export import command as export
from hsr_pin.cli.view import command as view

from ..export.test_document import ARM, BEST, diagnosis, in_sections
from .drafts import draft_of
from .judging import PATIENCE, SETTINGS, at_most, interrupted, judge, judge_files
from .trees import damaged

FITTED = {
    "keq_scale": {"value": 1.1},
    "damping_scale": {"value": 0.8},
    "torque_gain": {"value": 1.05},
    "tip_mass.mass": {"value": 0.02},
}
_TIP = {"name": "tip_mass", "parameters": {"mass": 0.02}, "options": {}}
#: By kind.
RESULTS = {
    "diagnosis": diagnosis(),
    "open": diagnosis("ambiguous", (), candidates=[{**BEST, "resized": ["hysteresis"]}]),
    "fit": {
        "schema": 1,
        "dataset": "x",
        "parameters": FITTED,
        "effects": ["tip_mass"],
        "links": 4,
        "arm": {**ARM, "effects": [_TIP]},
    },
    "sections": in_sections(torsion=0.7),
}
SEEDS = st.integers(0, 1 << 30)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return draft_of("torque").write(tmp_path_factory.mktemp("data") / "data")


@pytest.fixture
def end(data, tmp_path, monkeypatch, capsys):
    """``end(kind, seed)``: read a damaged result and look at how the command ends, in a word."""
    count = 0

    def one(kind, seed, text=None):
        nonlocal count
        count += 1
        place, random = tmp_path / str(count), Random(seed)
        place.mkdir()
        monkeypatch.chdir(place)
        monkeypatch.setattr("hsr_pin.cli.view.time", SimpleNamespace(sleep=interrupted))  # the page is up
        text = json.dumps(damaged(RESULTS[kind], random)) if text is None else text
        (place / "found.json").write_text(text, encoding="utf-8", errors="surrogatepass")
        command, arguments = _call(random, str(data))
        capsys.readouterr()
        with at_most(PATIENCE):
            code = run(command, arguments)
        out, err = capsys.readouterr()
        judge(command.name, code, out, err, document=False)
        judge_files(place, code)
        return f"{command.name}: exit code {code}"

    return one


def _call(random, data):
    """A command and its arguments."""
    dataset = ["--dataset", data] if random.random() < 0.2 else []
    if random.random() < 0.15:
        pytest.importorskip("viser", reason="needs viser (group view)")
        return view, [data, "--no-open", "--from", "found.json"]
    target = random.choice(("mjcf", "urdf", "sdf"))
    keq = random.choice((["--keq", "1.11"], ["--keq", "1.11", "--links", "3"], []))
    return export, ["--to", target, "--from", "found.json", "-o", f"out.{'xml' if target == 'mjcf' else target}", *keq, *dataset]


@settings(SETTINGS, max_examples=200)
@given(st.sampled_from(list(RESULTS)), SEEDS)
def test_of_200_damaged_results_each_ends_in_a_model_or_one_line(end, kind, seed):
    event(end(kind, seed))


@pytest.mark.long
@settings(SETTINGS, max_examples=2000)
@given(st.sampled_from(list(RESULTS)), SEEDS)
def test_of_2000_damaged_results_each_ends_in_a_model_or_one_line(end, kind, seed):
    event(end(kind, seed))


@settings(SETTINGS, max_examples=50)
@given(st.sampled_from(list(RESULTS)), SEEDS, st.floats(0, 1), st.sampled_from(["", "\0", '"', "}", "[", "1e999", "NaN,"]))
def test_a_result_with_letters_changed_ends_so_too(end, kind, seed, at, letters):
    text = json.dumps(RESULTS[kind])
    place = int(at * len(text))
    event(end(kind, seed, text[:place] + letters + text[place + 1 :]))


@pytest.mark.parametrize("kind", RESULTS)
def test_a_result_without_a_fault_is_exported(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "found.json").write_text(json.dumps(copy.deepcopy(RESULTS[kind])), encoding="utf-8")
    assert run(export, ["--to", "mjcf", "--from", "found.json", "--keq", "1.11", "-o", "out.xml"]) == 0
    judge_files(tmp_path, 0)
