"""`hsr-diagnose` gives a verdict on one screen and in files, or says in one line why not."""

import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.diagnose import _OTHER_STAGES, command
from hsr_pin.cli.diagnose_report import LINES, screen
from hsr_pin.cli.judging import progress
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json
from hsr_pin.errors import IdentificationError
from hsr_pin.inference.estimates import estimates
from hsr_pin.inference.verdict import Verdict
from hsr_pin.output import PAGE_SIGNATURE
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

#: As installers write it, but for the name of the interpreter.
SCRIPT = "import sys\nfrom hsr_pin.cli.diagnose import main\nif __name__ == '__main__':\n    sys.exit(main())\n"


@pytest.fixture(scope="module")
def recordings(heavy_tip, tmp_path_factory):
    """The dataset in a folder."""
    folder = tmp_path_factory.mktemp("recordings") / "heavy-tip"
    write_dataset(heavy_tip, folder)
    return folder


@pytest.fixture(scope="module")
def diagnosis(recordings):
    """What the command line below asks for, in this process."""
    return diagnose(read_dataset(recordings), effects=["tip_mass"], max_effects=1, jobs=1, seed=3)


@pytest.fixture(scope="module")
def outcome(recordings, tmp_path_factory):
    """The console script, with two processes: how it ended, what it printed, what it wrote."""
    folder = tmp_path_factory.mktemp("outcome")
    (folder / "hsr-diagnose").write_text(SCRIPT)
    options = "--effects tip_mass --max-effects 1 --jobs 2 --seed 3 --json found.json --html found.html"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2]), "COLUMNS": "80"}
    ended = subprocess.run(
        [sys.executable, "hsr-diagnose", recordings, *options.split()],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    return ended, folder


def test_any_verdict_is_exit_code_zero_and_a_pipe_gets_no_progress_bar(outcome):
    ended, _ = outcome
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_screen_says_verdict_ladder_best_model_where_and_what_next(outcome):
    lines = outcome[0].stdout.splitlines()
    assert lines[0] == "heavy-tip: Missing physics identified"
    assert lines[1].startswith("tip_mass is missing from the model")
    for start in ("declared model", "finer discretisation", "tip_mass", "noise floor", "  tip_mass.mass", "where: ", "next: "):
        assert any(line.startswith(start) for line in lines), start
    assert lines[-1] == "wrote found.json, found.html"
    assert len(lines) <= 23
    assert max(map(len, lines)) <= 80


def test_both_files_are_written_whole_and_nothing_else(outcome):
    _, folder = outcome
    assert sorted(path.name for path in folder.iterdir()) == ["found.html", "found.json", "hsr-diagnose"]
    assert (folder / "found.html").read_text(encoding="utf-8").rstrip().endswith("</html>")


def test_same_seed_same_answer_with_one_process_or_two(outcome, diagnosis):
    assert json.loads((outcome[1] / "found.json").read_text(encoding="utf-8")) == to_json(diagnosis)


def test_it_fits_a_screen_however_much_there_is_to_say(diagnosis, monkeypatch):
    monkeypatch.setattr("hsr_pin.cli.diagnose_report.estimates", lambda fit: 6 * estimates(fit))
    rungs = (
        *diagnosis.ladder[:3],
        *[replace(diagnosis.ladder[3], name="quadratic_damping + stiffness_gradient")] * 3,
        diagnosis.ladder[-1],
    )
    experiment = replace(diagnosis.experiment, notes=("trial_09 is left out: fewer than 10 positions were seen",) * 3)
    verdict = Verdict("unexplained", (), (), "Of the gap, much is left. " * 40)
    long = replace(diagnosis, ladder=rungs, experiment=experiment, verdict=verdict)
    lines = [line.plain for line in screen(long, 80, ["a.json", "b.html"])]
    assert len(lines) <= LINES
    assert max(map(len, lines)) <= 80
    assert any("see --html or --json" in line for line in lines)
    assert any("and 2 more notes" in line for line in lines)


def test_too_few_trials_are_a_verdict_too_and_a_dash_prints_json(heavy_tip, tmp_path, capsys):
    write_dataset(replace(heavy_tip, trials=heavy_tip.trials[:1]), tmp_path / "one")
    assert run(command, [str(tmp_path / "one"), "--jobs", "1"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("heavy-tip: Not enough data")
    assert "next:  Record next: " in shown
    assert run(command, [str(tmp_path / "one"), "--jobs", "1", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"]["status"] == "insufficient"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["absent"], "absent"),
        (["{data}", "--effects", "tip_mas"], "did you mean tip_mass?"),
        (["{data}", "--effects", ""], "effect: expected stiffness_gradient"),
        (["{data}", "--effects", "tip_mass,,dead_time"], "got ''"),
        (["{data}", "--max-effects", "-1"], "--max-effects"),
        (["{data}", "--links", "0"], "--links"),
        (["{data}", "--jobs", "0"], "--jobs"),
        (["{data}", "--seed", "x"], "--seed"),
        (["{data}", "--delay", "-1"], "--delay"),
        (["{data}", "--json", "absent/found.json"], "absent/found.json: cannot write the file"),
        (["{data}", "--html", "."], "cannot write the file"),
        (["{data}", "--html", "found", "--json", "./found"], "expected two files"),
        ([], "DATASET"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two_before_any_work(recordings, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.diagnose", lambda *_, **__: pytest.fail("the work has begun"))
    assert run(command, [argument.format(data=recordings) for argument in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hsr-diagnose: error: ") and err.count("\n") == 1
    assert said in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["--train", "trial_9"],
            "trials: expected a name or pattern among trial_01, trial_02, trial_03, trial_04, got 'trial_9'",
        ),
        (["--test", "trial_*"], "at least one, got all trials set aside"),
        (["--train", "trial_01", "--test", "trial_0[13]"], "trial_01 in both"),
        (["--cluster", "nowhere:1"], "cluster: expected the address of a Dask scheduler that answers, got nowhere:1"),
    ],
)
def test_what_the_recordings_or_the_machines_refuse_is_one_line_too(recordings, capsys, arguments, said):
    if "--cluster" in arguments:
        pytest.importorskip("distributed", reason="needs dask.distributed")
    assert run(command, [str(recordings), "--effects", "tip_mass", "--max-effects", "1", "--jobs", "1", *arguments]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert said in err


def test_the_ladder_is_told_on_the_trials_that_are_set_aside(recordings, capsys):
    arguments = ["--effects", "tip_mass", "--max-effects", "1", "--jobs", "1", "--test", "trial_0[34]", "--json", "-"]
    assert run(command, [str(recordings), *arguments]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["verdict"]["effects"] == ["tip_mass"]
    assert "the ladder uses held-out trials, to which nothing was fitted: trial_03, trial_04" in document["notes"]
    assert [part["label"] for part in document["where"]["trials"]["bins"]] == ["trial_01", "trial_02"]


def test_an_older_report_stays_where_the_diagnosis_fails(recordings, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise IdentificationError("trials", expected="at least one that can be used", received="none")

    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.diagnose", fail)
    old = tmp_path / "old.html"
    old.write_text(f"old {PAGE_SIGNATURE}")
    assert run(command, [str(recordings), "--html", str(old)]) == 2
    assert capsys.readouterr().err == "hsr-diagnose: error: trials: expected at least one that can be used, got none\n"
    assert old.read_text().startswith("old")


def test_a_terminal_gets_a_bar_that_only_moves_on_and_is_gone_at_the_end(monkeypatch):
    stream = io.StringIO()
    stream.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    seen = []
    monkeypatch.setattr("rich.progress.Progress.update", lambda *_, completed, **__: seen.append(completed))
    with progress(2 + _OTHER_STAGES) as (tell, advance):
        for stage in ("reading the recordings", "stiffness and damping", "effect 1", "effect 2", "where"):
            tell(stage)
            for _ in range(30 if "effect" in stage else 0):
                advance()
    assert seen == sorted(seen)
    assert 3 < seen[-2] < 4 == seen[-1]
    assert stream.getvalue().endswith("\x1b[2K")


def test_help_does_not_wait_for_the_numbers(tmp_path):
    program = "import sys\nfrom hsr_pin.cli.diagnose import command\nfrom hsr_pin.cli.command import run\n"
    program += "run(command, ['--help'])\nassert not {'numpy', 'rich', 'matplotlib'} & {*sys.modules}"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    ended = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert "--max-effects" in ended.stdout
