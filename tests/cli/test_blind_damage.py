"""A check whose files were damaged, or lie on two file systems, goes on, or says in one line what to do."""

import errno
import json
import os
import shutil

import pytest

import hsr_pin.diagnosis.diagnose as diagnosis
from hsr_pin.blind.answers import SEAL, Answer, seal
from hsr_pin.blind.make import make
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.tiers import plan, shuffled
from hsr_pin.blind.workshop import Workshop
from hsr_pin.cli.blind import command
from hsr_pin.cli.command import run
from hsr_pin.errors import RecordingError
from hsr_pin.output import write_text

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

COARSE = ChainPlant(elements=4, step=1e-3)
QUICK = Workshop({"chain": COARSE, "rod": COARSE}, COARSE, COARSE, ("steps",))
#: As `hsr-blind make --seed 5 --tier clean=2` plans them.
CASES = shuffled(5, plan(5, {"clean": 2}, QUICK.programs))
SAID = {
    "schema": 1,
    "dataset": "x",
    "verdict": {"status": "parameters", "effects": [], "alternatives": [], "sentence": "Stiffness explains it."},
    "ladder": [{"rung": name, "heldout_rms_mm": 1.0} for name in ("declared model", "stiffness and damping", "noise floor")],
}
DAMAGE = {
    "truncated": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "empty": lambda path: path.write_bytes(b""),
    "no text": lambda path: path.write_bytes(b"\xff\xfe\x00"),
    "a list": lambda path: path.write_bytes(b"[1, 2]"),
    "nested": lambda path: path.write_bytes(b"[" * 100_000),
    "another document": lambda path: path.write_bytes(b'{"verdict": 3}'),
}


@pytest.fixture(scope="module")
def sealed(tmp_path_factory):
    """Two cases, sealed."""
    folder = tmp_path_factory.mktemp("sealed") / "check"
    return folder, make(folder, 5, CASES, workshop=QUICK)


@pytest.fixture
def check(sealed, tmp_path, monkeypatch):
    """A copy of them with verdicts."""
    monkeypatch.setattr("hsr_pin.blind.workshop.Workshop", lambda **_: QUICK)
    folder, answers = sealed
    shutil.copytree(folder, tmp_path / "check")
    shutil.copy(answers, tmp_path / "check-answers.json")
    verdicts = tmp_path / "check" / "verdicts"
    verdicts.mkdir()
    for name in ("case_001", "case_002"):
        (verdicts / f"{name}.json").write_text(json.dumps(SAID))
    return tmp_path / "check"


def told(capsys, arguments, code=2):
    """The one line of an error."""
    assert run(command, [str(argument) for argument in arguments]) == code
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and err.startswith("hsr-blind: error: ")
    return err


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_verdict_is_named_by_the_score_and_diagnosed_again(check, monkeypatch, capsys, damage):
    file = check / "verdicts" / "case_002.json"
    DAMAGE[damage](file)
    assert "case_002" in told(capsys, ["score", check]) or damage == "another document"
    monkeypatch.setattr(diagnosis, "diagnose", lambda dataset, jobs, seed: dataset.name)
    monkeypatch.setattr("hsr_pin.diagnosis.document.to_json", lambda name: SAID)
    if damage == "another document":
        file.unlink()  # it stands, as far as `run` can tell
    assert run(command, ["run", str(check)]) == 0
    assert json.loads(file.read_text()) == SAID
    assert run(command, ["score", str(check)]) == 0
    assert "2 cases diagnosed" in capsys.readouterr().out


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("name", ["SEALED.txt", "../check-answers.json", "oracle/case_001.json"])
def test_a_damaged_seal_answers_or_oracle_are_one_line(check, capsys, name, damage):
    (check / "oracle").mkdir()
    (check / "oracle" / "case_001.json").write_text('{"effects": ["tip_mass"], "heldout_rms_mm": 0.5}')
    assert run(command, ["score", str(check)]) == 0
    capsys.readouterr()
    DAMAGE[damage]((check / name).resolve())
    assert (check / name).resolve().name in told(capsys, ["score", check])


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_score_is_one_line(check, tmp_path, capsys, damage):
    file = tmp_path / "score.json"
    assert run(command, ["score", str(check), "--json", str(file)]) == 0
    capsys.readouterr()
    DAMAGE[damage](file)
    assert "score" in told(capsys, ["show", file])


@pytest.fixture
def interrupted(tmp_path, monkeypatch):
    """A check of two cases, of which one is recorded."""
    monkeypatch.setattr("hsr_pin.blind.workshop.Workshop", lambda **_: QUICK)

    def give_up():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "check", 5, CASES, workshop=QUICK, advance=give_up)
    return tmp_path / "check"


MAKE = ["make", "--seed", "5", "--tier", "clean=2", "-o"]


@pytest.mark.parametrize("damage", ["truncated", "no text"])
def test_a_damaged_plan_is_one_line(interrupted, capsys, damage):
    DAMAGE[damage](interrupted.with_name("check-answers.json.draft") / "plan.json")
    assert "expected the check begun in it" in told(capsys, [*MAKE, interrupted])


def test_a_case_whose_answer_was_damaged_before_the_seal_is_recorded_again(interrupted, sealed):
    DAMAGE["truncated"](interrupted.with_name("check-answers.json.draft") / "case_001.json")
    assert run(command, [*MAKE, str(interrupted)]) == 0
    assert json.loads(interrupted.with_name("check-answers.json").read_text()) == json.loads(sealed[1].read_text())
    for path in sealed[0].rglob("trial_01.csv"):
        assert (interrupted / path.relative_to(sealed[0])).read_text() == path.read_text()


def test_answers_on_another_file_system_are_no_hindrance_and_no_part_stays(interrupted, sealed, monkeypatch):
    replace = os.replace

    def across(source, target):
        if source.parent.suffix == ".draft" and target.parent != source.parent:
            raise OSError(errno.EXDEV, "Invalid cross-device link")
        replace(source, target)

    monkeypatch.setattr(os, "replace", across)
    left = interrupted / ".case_002.part"  # as a process leaves it that is killed while it copies
    left.mkdir()
    (left / "trial_01.csv").write_text("half")
    assert run(command, [*MAKE, str(interrupted)]) == 0
    assert json.loads(interrupted.with_name("check-answers.json").read_text()) == json.loads(sealed[1].read_text())
    assert sorted(path.name for path in interrupted.iterdir()) == [SEAL, "case_001", "case_002"]
    assert sorted(path.name for path in interrupted.parent.iterdir()) == ["check", "check-answers.json"]
    assert (interrupted / "case_002" / "trial_01.csv").read_text() == (sealed[0] / "case_002" / "trial_01.csv").read_text()


def test_answers_are_not_written_over_a_file_unless_told_to(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("hsr_pin.blind.workshop.Workshop", lambda **_: QUICK)
    mine = tmp_path / "mine.json"
    mine.write_text("mine")
    arguments = ["make", "--seed", "5", "--tier", "clean=1", "-o", str(tmp_path / "check"), "--answers", str(mine)]
    assert "mine.json: will not replace the file" in told(capsys, arguments)
    assert mine.read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.json"]
    assert run(command, [*arguments, "--force"]) == 0
    assert json.loads(mine.read_text())["seed"] == 5


def test_answers_that_were_written_but_not_sealed_are_sealed(tmp_path, monkeypatch):
    monkeypatch.setattr("hsr_pin.blind.workshop.Workshop", lambda **_: QUICK)

    def killed(path, text):
        if path.name == SEAL:
            raise KeyboardInterrupt
        write_text(path, text)

    arguments = ["make", "--seed", "5", "--tier", "clean=1", "-o", str(tmp_path / "check")]
    with monkeypatch.context() as patched:
        patched.setattr("hsr_pin.blind.answers.write_text", killed)
        assert run(command, arguments) == 130
    assert (tmp_path / "check-answers.json").exists()
    assert run(command, arguments) == 0
    assert (tmp_path / "check" / SEAL).exists()


@pytest.mark.parametrize("place", ["check-answers.json", "check/SEALED.txt", "check/verdicts/case_001.json"])
@pytest.mark.parametrize("option", ["--json", "--plot", "--reliability"])
def test_a_score_is_not_written_over_what_it_is_made_of(check, monkeypatch, capsys, place, option):
    monkeypatch.setattr("hsr_pin.replay.plots.picture_format", lambda path: "png")
    file = check.parent / place
    before = file.read_bytes()
    assert "will not write over what is read" in told(capsys, ["score", check, option, file, "--force"])
    assert file.read_bytes() == before


def test_when_every_case_fails_the_run_fails_and_says_why(check, monkeypatch, capsys):
    def fail(*_, **__):
        raise RecordingError("cannot read the file", received="a fault", file="trial_01.csv")

    shutil.rmtree(check / "verdicts")
    monkeypatch.setattr(diagnosis, "diagnose", fail)
    said = told(capsys, ["run", check])
    assert "no case could be diagnosed" in said and "case_001: RecordingError: trial_01.csv" in said


def test_when_one_case_fails_the_run_says_so(check, monkeypatch, capsys):
    def fail(*_, **__):
        raise ZeroDivisionError("by zero")

    (check / "verdicts" / "case_002.json").unlink()
    monkeypatch.setattr(diagnosis, "diagnose", fail)
    assert run(command, ["run", str(check)]) == 0
    err = capsys.readouterr().err
    assert err == "1 of 2 cases could not be diagnosed, and count as errors: case_002: ZeroDivisionError: by zero\n"


@pytest.mark.parametrize(
    "said",
    [
        {"verdict": 3},
        {"verdict": {"status": "unchanged", "confidence": {"tip_mass": 7}}},
        {"verdict": {"status": "identified", "effects": ["tip_mass"], "changes": [3]}},
        {"verdict": {"status": "identified", "effects": ["tip_mass"], "changes": [{"name": "tip_mass", "parameter": "mass"}]}},
    ],
)
def test_a_damaged_verdict_on_a_pair_of_recordings_is_one_line(tmp_path, capsys, said):
    folder = tmp_path / "pairs"
    (folder / "verdicts").mkdir(parents=True)
    change = {"change": {"name": "tip_mass", "from": 0.0, "to": 0.01}}
    seal(folder, tmp_path / "pairs-answers.json", 1, [Answer("case_001", "appears", ("tip_mass",), "large", change, "change")])
    (folder / "verdicts" / "case_001.json").write_text(json.dumps(said))
    assert "case_001" in told(capsys, ["score", folder, "--json", tmp_path / "score.json"])
    assert not (tmp_path / "score.json").exists()
