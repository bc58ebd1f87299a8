"""``hsr-replay``: the error it prints is the comparison's, what it draws is the trial that was asked for."""

import json
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.replay import command
from hsr_pin.cli.sim import command as simulate_command
from hsr_pin.identification.comparison import compare
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trajectory, Trial


@pytest.fixture
def replay(capsys):
    """``replay(*arguments)``: exit code, stdout, stderr."""

    def call(*arguments):
        code = run(command, [str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return call


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Two trials of the paper's arm, its markers measured 3 mm to the side of where the simulation has them."""
    trials = []
    for number, torque in enumerate((0.3, 0.8), 1):
        motion = simulate(step_scenario(ArmSpecification(), torque, duration=1.0)).trajectory
        noise = np.random.default_rng(number).normal(0.0, 1e-4, motion.positions.shape)
        beside = motion.positions + np.array([0.003, 0.0, 0.0]) * (np.array([0, 1, 1])[:, None]) + noise
        measured = Trajectory(motion.time, motion.markers, beside, torque=motion.torque)
        trials.append(Trial(f"trial_{number:02d}", measured, keq=1.11, damping=0.05))
    path = tmp_path_factory.mktemp("recording") / "beside"
    write_dataset(Dataset("beside", 0.24, 0.15, 0.04, "hanging", tuple(trials), chain=(4, "base")), path)
    return path


def test_the_errors_are_those_of_the_comparison(replay, recording):
    code, out, err = replay(recording, "--json")
    assert (code, err) == (0, "")
    facts, known = json.loads(out), compare(read_dataset(recording))
    assert [trial["trial"] for trial in facts["trials"]] == ["trial_01", "trial_02"]
    assert facts["errors"][-1]["rms"] == known.errors[-1].rms
    assert facts["errors"][-1]["rms"] == pytest.approx(0.003, rel=0.02)


def test_the_table_gives_mm_and_percent_of_the_length(replay, recording):
    out = replay(recording, "--no-live")[1]
    rows = [line.split() for line in out.splitlines() if " tip " in line]
    assert len(rows) == 3
    for row in rows:
        rms, percent = (float(cell) for cell in row[row.index("tip") + 1 :][:2])
        assert rms == pytest.approx(3.0, abs=0.05)
        assert percent == pytest.approx(100 * rms / 240, abs=0.01)


def test_hsr_sim_against_a_recording_prints_the_same_errors(replay, recording, capsys):
    _, replayed, _ = replay(recording, "--links", "6", "--placement", "mid", "--json")
    assert run(simulate_command, ["--against", str(recording), "--links", "6", "--placement", "mid", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["errors"] == json.loads(replayed)["errors"]


@pytest.mark.parametrize("more", [["--torque", "1"], ["--keq", "1.11"], ["--plot", "x.png"]])
def test_hsr_sim_against_a_recording_refuses_what_the_recording_tells(recording, capsys, more):
    assert run(simulate_command, ["--against", str(recording), *more]) == 2
    assert "only --links, --placement, --effect and --json" in capsys.readouterr().err


@pytest.mark.parametrize("trial", ["2", "trial_02"])
def test_one_trial_is_chosen_by_number_or_name(replay, recording, tmp_path, trial):
    code, out, _ = replay(recording, "--trial", trial, "--html", tmp_path / "run.html", "--plot", tmp_path / "run.png")
    assert code == 0
    assert "trial_02" in out
    assert "trial_01" not in out
    assert "beside, trial_02" in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_without_a_file_to_write_it_opens_the_browser_and_with_one_it_does_not(replay, recording, tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr("hsr_pin.replay.live.show", lambda runs: shown.append([run.label for run in runs]))
    replay(recording)
    assert shown == [["beside, trial_01"]]
    replay(recording, "--html", tmp_path / "run.html")
    replay(recording, "--json")
    assert len(shown) == 1
    replay(recording, "--json", "--live")
    assert len(shown) == 2


BAD = {
    "no dataset": (["gone"], "gone: no such dataset"),
    "a trial that is not there": (["data", "--trial", "3"], "--trial: expected 1 to 2, or one of trial_01, trial_02, got 3"),
    "trial zero": (["data", "--trial", "0"], "--trial: expected 1 to 2"),
    "no links": (["data", "--links", "0"], "'--links': 0 is not in the range 1<=x<=100"),
    "unknown placement": (["data", "--placement", "end"], "'--placement': 'end' is not one of 'mid', 'base'"),
    "unknown effect": (["data", "--effect", "friction"], "effect: expected stiffness_gradient, "),
    "an unwritable page": (["data", "--html", "gone/run.html"], "gone/run.html: cannot write the file"),
    "an unknown picture": (["data", "--plot", "run.bmp"], "picture: expected a name ending in .png, .pdf, .svg, got run.bmp"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_leaves_nothing_behind(replay, recording, tmp_path, monkeypatch, case):
    arguments, said = BAD[case]
    monkeypatch.chdir(tmp_path)
    Path("data").symlink_to(recording)
    good = [] if "--html" in arguments else ["--html", "run.html"]
    code, out, err = replay(*arguments, *good)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


@pytest.mark.parametrize("name", ["sample-steps", "real-beam", "real-trunk"])
def test_real_and_sample_recordings_run_through(replay, shared, tmp_path, name):
    code, out, err = replay(shared / "recordings" / name, "--trial", 1, "--html", tmp_path / "run.html", "--json")
    assert (code, err) == (0, "")
    (trial,) = json.loads(out)["trials"]
    assert 0 < trial["errors"][-1]["rms"] < 0.2
