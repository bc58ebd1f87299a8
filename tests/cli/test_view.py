"""`hsr-view` serves a page until Ctrl-C; bad input is one line and exit code 2."""

import json
import signal
import subprocess
import sys
import urllib.request
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.view import command
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trial

PROGRAM = "import sys; from hsr_pin.cli.view import main; main()"
RESULT = {
    "schema": 1,
    "dataset": "one",
    "verdict": {"status": "identified", "effects": ["torque_bias"], "sentence": "Found."},
    "candidates": [{"effects": ["torque_bias"], "options": {}, "parameters": {"torque_bias.bias": {"value": 0.05}}}],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    motion = simulate(step_scenario(ArmSpecification(), 0.6, duration=0.6)).trajectory
    seen = replace(motion, positions=motion.positions + 3e-4 * np.random.default_rng(0).standard_normal(motion.positions.shape))
    path = tmp_path_factory.mktemp("recordings") / "one"
    write_dataset(Dataset("one", 0.24, 0.15, 0.04, "hanging", (Trial("trial_01", seen, 1.11, 0.05),)), path)
    return path


def test_a_page_is_served_to_this_machine_until_ctrl_c(folder, tmp_path):
    pytest.importorskip("viser", reason="needs viser (group view)")
    (tmp_path / "result.json").write_text(json.dumps(RESULT), encoding="utf-8")
    (tmp_path / "report.html").write_text("<!doctype html><html>the report</html>", encoding="utf-8")
    more = ["--no-open", "--from", str(tmp_path / "result.json"), "--report", str(tmp_path / "report.html"), "--links", "4"]
    command_line = [sys.executable, "-c", PROGRAM, str(folder), *more]
    with subprocess.Popen(command_line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        try:
            said = child.stdout.readline()
            assert said.startswith("http://127.0.0.1:"), child.stderr.read()
            assert said.endswith("  (Ctrl-C ends)\n")
            with urllib.request.urlopen(said.split()[0]) as answer:
                assert b"<html" in answer.read()
            child.send_signal(signal.SIGINT)
            out, err = child.communicate(timeout=60)
        finally:
            child.kill()
    assert (child.returncode, out.strip(), err) == (0, "", "")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "Missing argument 'DATASET'"),
        (["nowhere"], "nowhere"),
        (["FOLDER", "--links", "0"], "Invalid value for '--links'"),
        (["FOLDER", "--port", "99999"], "Invalid value for '--port'"),
        (["FOLDER", "--report", "nowhere.html"], "nowhere.html: cannot read the file"),
        (["FOLDER", "--report", "dataset.toml"], "--report: expected a page written by hsr-diagnose --html, got no HTML"),
        (["FOLDER", "--from", "nowhere.json"], "nowhere.json: cannot read the file"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, said, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert run(command, [str(folder) if word == "FOLDER" else word for word in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hsr-view: error: ")
    assert said in err
    assert err.count("\n") == 1


def test_without_viser_the_message_names_the_group(folder, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "viser", None)
    assert run(command, [str(folder), "--no-open"]) == 2
    assert (
        "viser is not installed; it comes with python3 scripts/install.py view, or pip install 'hsr_pin[view]'"
        in capsys.readouterr().err
    )


def test_help_loads_nothing_heavy():
    heavy = "print(sorted({'numpy', 'pinocchio', 'scipy', 'viser', 'numba'} & set(sys.modules)), file=sys.stderr)"
    program = f"import sys, atexit; atexit.register(lambda: {heavy}); {PROGRAM}"
    done = subprocess.run([sys.executable, "-c", program, "--help"], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"
