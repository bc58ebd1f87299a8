"""`hsr-blind` makes, runs and scores a sealed check, and refuses in one line what it cannot use."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import pytest

import hsr_pin.blind.diagnoses as diagnoses
import hsr_pin.diagnosis.diagnose as diagnosis
from hsr_pin.blind.background import Background
from hsr_pin.blind.cases import plan_clean
from hsr_pin.blind.make import make
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws.mounting import TipMass
from hsr_pin.blind.workshop import Workshop
from hsr_pin.cli.blind import command
from hsr_pin.cli.command import run
from hsr_pin.recordings.write import write_dataset

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

COARSE = ChainPlant(elements=12, step=5e-4)
QUICK = Workshop({"chain": COARSE, "rod": COARSE}, COARSE, COARSE, ("steps",))
ROOT = Path(__file__).resolve().parents[2]
#: Candidates in the quick run; the long one has the whole catalogue.
FEW = ("tip_mass", "torque_map")


def check(folder, seed, count):
    """Make, run and score in this process: exit codes and the score."""
    codes = [run(command, ["make", "--seed", str(seed), "--tier", f"clean={count}", "-o", str(folder)])]
    codes.append(run(command, ["run", str(folder)]))
    codes.append(run(command, ["score", str(folder), "--json", str(folder / "score.json"), "--plot", str(folder / "score.png")]))
    return codes, json.loads((folder / "score.json").read_text())


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr("hsr_pin.blind.workshop.Workshop", lambda **_: QUICK)


def test_a_small_sealed_run_is_made_diagnosed_and_scored(tmp_path, monkeypatch, quick, capsys):
    monkeypatch.setattr(diagnosis, "diagnose", partial(diagnosis.diagnose, effects=FEW, max_effects=1))
    codes, score = check(tmp_path / "check", 5, 2)
    assert codes == [0, 0, 0]
    assert score["cases"] == 2 and score["missing"] == []
    assert not any(outcome["status"] == "error" for outcome in score["outcomes"])
    for outcome in score["outcomes"]:
        ladder = json.loads((tmp_path / "check" / "verdicts" / f"{outcome['name']}.json").read_text())["ladder"]
        rms = {rung["rung"]: rung["heldout_rms_mm"] for rung in ladder if not rung["rung"].startswith("noise floor")}
        assert outcome["shrinkage"] == pytest.approx(1 - list(rms.values())[-1] / rms["stiffness and damping"])
    assert (tmp_path / "check" / "score.png").stat().st_size > 10_000
    printed = capsys.readouterr().out
    assert "2 cases diagnosed" in printed and "wrong names, all cases" in printed
    assert run(command, ["show", str(tmp_path / "check" / "score.json")]) == 0
    again = capsys.readouterr().out
    assert again.splitlines() == [line for line in printed.splitlines() if not line.startswith("wrote ")]


@pytest.mark.long
def test_a_small_sealed_run_with_the_whole_catalogue_names_nothing_wrong(tmp_path, quick):
    codes, score = check(tmp_path / "check", 2, 4)
    assert codes == [0, 0, 0]
    assert score["cases"] == 4
    assert score["rates"]["wrong names, all cases"]["hits"] == 0


@pytest.fixture
def recorded(tmp_path, heavy_tip):
    """Three recordings."""
    folder = tmp_path / "check"
    folder.mkdir()
    for number in (1, 2, 3):
        write_dataset(heavy_tip, folder / f"case_{number:03d}")
    return folder


def test_a_case_that_raises_is_an_error_of_that_case_and_is_tried_again(recorded, monkeypatch):
    tried = []

    def diagnose(dataset, jobs, seed):
        tried.append((dataset.path.name, jobs, seed))
        if dataset.path.name == "case_002":
            raise ZeroDivisionError("by zero")
        return dataset.path.name

    monkeypatch.setattr(diagnosis, "diagnose", diagnose)
    monkeypatch.setattr("hsr_pin.diagnosis.document.to_json", lambda name: {"dataset": name})
    assert run(command, ["run", str(recorded), "--seed", "4"]) == 0
    assert tried == [("case_001", 1, 4), ("case_002", 1, 4), ("case_003", 1, 4)]
    said = diagnoses.read_verdicts(recorded / "verdicts")
    assert [list(document) for document in said.values()] == [["dataset"], ["dataset", "error", "traceback"], ["dataset"]]
    assert said["case_002"]["error"] == "ZeroDivisionError: by zero"
    assert run(command, ["run", str(recorded)]) == 0
    assert [name for name, *_ in tried[3:]] == ["case_002"]


def test_cases_are_diagnosed_side_by_side_too(recorded):
    (recorded / "case_003" / "trial_01.csv").write_text("t\n")  # which cannot be read: quick
    (recorded / "case_002" / "trial_01.csv").write_text("t\n")
    (recorded / "case_001" / "trial_01.csv").write_text("t\n")
    assert run(command, ["run", str(recorded), "--jobs", "2", "-o", str(recorded / "said")]) == 2
    said = diagnoses.read_verdicts(recorded / "said")
    assert sorted(said) == ["case_001", "case_002", "case_003"]
    assert all("RecordingError" in document["error"] for document in said.values())


def test_tampered_answers_are_refused_in_one_line(tmp_path, capsys):
    folder = tmp_path / "check"
    answers = make(folder, 5, plan_clean(5, 1, QUICK.programs), workshop=QUICK)
    answers.write_text(answers.read_text().replace('"seed": 5', '"seed": 6'))
    assert run(command, ["score", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("hsr-blind: error: ") and "hash" in error and error.count("\n") == 1


@pytest.mark.long
def test_pairs_of_recordings_are_made_and_scored(tmp_path, quick, monkeypatch, capsys):
    monkeypatch.setattr("hsr_pin.blind.workshop.background", lambda *_: Background((TipMass(2e-4),), (0.1,), 0.1))
    folder = tmp_path / "pairs"
    assert run(command, ["make", "--seed", "3", "--change", "1", "-o", str(folder)]) == 0
    assert sorted(path.name for path in (folder / "case_001").iterdir()) == ["new", "old"]
    kind = json.loads((tmp_path / "pairs-answers.json").read_text())["cases"][0]["kind"]
    (folder / "verdicts").mkdir()
    said = {"status": "unchanged", "sentence": "Nothing has changed.", "effects": [], "alternatives": []}
    (folder / "verdicts" / "case_001.json").write_text(json.dumps({"verdict": said}))
    assert run(command, ["score", str(folder), "--json", str(tmp_path / "score.json")]) == 0
    score = json.loads((tmp_path / "score.json").read_text())
    assert score["rates"]["unchanged, nothing has changed"]["of"] == (kind == "nothing")
    assert "1 pairs diagnosed" in capsys.readouterr().out
    assert run(command, ["score", str(folder), "--plot", str(tmp_path / "no.png")]) == 2
    assert not (tmp_path / "no.png").exists()


def test_a_picture_of_confidence_needs_confidence(tmp_path, capsys):
    score = json.loads((ROOT / "data" / "blind_465312.json").read_text())
    for outcome in score["outcomes"]:
        outcome["confidence"] = {}
    file = tmp_path / "score.json"
    file.write_text(json.dumps(score))
    assert run(command, ["show", str(file), "--reliability", str(tmp_path / "trust.png")]) == 2
    assert "state a confidence" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "nowhere"], "nowhere"),
        (["score", "nowhere"], "SEALED.txt"),
        (["make", "-o", "check"], "--seed"),
        (["make", "--seed", "1", "--cases", "0", "-o", "check"], "--cases"),
        (["make", "--seed", "1", "-o", "check", "--answers", "check/in.json"], "outside"),
        (["make", "--seed", "1", "-o", "check", "--tier", "messy"], "messy=160"),
        (["make", "--seed", "1", "-o", "check", "--tier", "tidy=3"], "clean or messy or forms"),
        (["make", "--seed", "1", "-o", "check", "--tier", "clean=0"], "one or more"),
        (["make", "--seed", "1", "-o", "check", "--tier", "clean=2", "--cases", "2"], "both"),
        (["make", "--seed", "1", "-o", "check", "--change", "2", "--cases", "2"], "--change"),
        (["guess"], "guess"),
        (["show", "nowhere.json"], "nowhere.json"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(command, arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
