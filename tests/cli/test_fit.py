"""hsr-fit: values with intervals, errors in and out of sample, files; bad input is one line and exit code 2."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.fit import command
from hsr_pin.effects import EFFECTS
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import load_urdf
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Pose, Scenario, step_scenario
from hsr_pin.trajectory import Dataset, Marker

from ..filmed import filmed

TRUE = {1.11: 1.2, 2.33: 0.9}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two steps at two stiffness levels; the true stiffness is 1.2 and 0.9 times the declared one."""
    arms = [ArmSpecification(links=24, placement="mid", keq=factor * keq, damping=0.05) for keq, factor in TRUE.items()]
    results = simulate_batch([step_scenario(arm, 0.5 * arm.keq, duration=0.8) for arm in arms])
    trials = filmed([result.trajectory for result in results], 3e-4, 0, [(keq, 0.05) for keq in TRUE])
    path = tmp_path_factory.mktemp("recordings") / "known"
    write_dataset(Dataset("known", 0.24, 0.15, 0.04, "hanging", trials), path)
    return path


@pytest.fixture(scope="module")
def still(folder, tmp_path_factory):
    """The same, released without an input: no muscle acts, and no joint goes far enough to meet a stop."""
    time, markers = 0.01 * np.arange(61), (Marker("base", 0.0), Marker("mid", 0.12), Marker("tip", 0.24))
    arm = ArmSpecification(links=24, placement="mid", keq=1.2, damping=0.05)
    bent = [Pose(np.full(24, bend / 24)) for bend in (0.15, -0.1)]
    results = simulate_batch([Scenario(arm, time, np.zeros(61), pose, markers=markers) for pose in bent])
    trials = filmed([result.trajectory for result in results], 1e-4, 1, driven=False)
    path = tmp_path_factory.mktemp("recordings") / "still"
    write_dataset(Dataset("still", 0.24, 0.15, 0.04, "hanging", trials), path)
    return path


@pytest.fixture(scope="module")
def outcome(folder, tmp_path_factory):
    """Everything at once, carried out once: exit code, printed text, JSON document, folder of the files."""
    made = tmp_path_factory.mktemp("made")
    program = "import sys; from hsr_pin.cli.fit import main; main()"
    arguments = [folder, "--by-level", "--profile", "--paper", "--json", made / "fit.json", "--plot", made / "fit.svg"]
    arguments += ["--urdf", made / "arm.urdf"]
    done = subprocess.run([sys.executable, "-W", "error", "-c", program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done, json.loads((made / "fit.json").read_text()), made


def test_the_document_holds_what_the_schema_promises(outcome):
    _, document, _ = outcome
    assert document["schema"] == 1
    assert document["dataset"] == "known"
    for name, value in (("keq_scale@1.11", 1.2), ("keq_scale@2.33", 0.9)):
        facts = document["parameters"][name]
        assert facts["unit"] == "1"
        assert facts["ci95"][0] < facts["value"] < facts["ci95"][1]
        assert facts["value"] == pytest.approx(value, rel=0.01)
        assert facts["profile"]["ci95"] == pytest.approx(facts["ci95"], rel=0.01)
    errors = document["rms_mm"]
    assert errors["after"] == pytest.approx(0.3 * 2**0.5, rel=0.1)  # noise in the plane
    assert errors["before"] > 3 * errors["after"]
    assert document["noise_floor_mm"] == pytest.approx(0.3 * 2**0.5, rel=0.2)
    assert document["heldout"] == "leave one out"
    assert document["paper_procedure"]["links"] == 4
    assert [trial["trial"] for trial in document["trials"]] == ["trial_01", "trial_02"]


def test_the_table_shows_values_intervals_and_errors_and_nothing_else_goes_to_stderr(outcome):
    done, _, made = outcome
    assert done.stderr == ""
    for words in ("keq_scale@1.11", "95 % interval", "by profile", "fitted trials, tip", "noise alone", "by brute force"):
        assert words in done.stdout
    assert f"wrote {made / 'fit.json'}" in done.stdout


def test_the_fitted_arm_of_each_level_is_written(outcome):
    _, document, made = outcome
    for keq in TRUE:
        arm = load_urdf(made / f"arm_keq{keq:g}.urdf")
        assert arm.keq == pytest.approx(keq * document["parameters"][f"keq_scale@{keq:g}"]["value"])
        assert (arm.links, arm.placement) == (16, "mid")


def test_the_picture_is_drawn(outcome):
    assert "<svg" in (outcome[2] / "fit.svg").read_text()


def test_trials_can_be_set_aside_and_the_document_goes_to_standard_output(folder, capsys):
    assert run(command, [str(folder), "--free", "keq", "--train", "trial_01", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["heldout"] == "set aside"
    assert document["parameters"]["keq_scale"]["value"] == pytest.approx(1.2, rel=0.01)
    assert document["rms_mm"]["heldout"] > 5 * document["rms_mm"]["after"]
    assert [trial["fitted"] for trial in document["trials"]] == [True, False]


@pytest.mark.parametrize("effect", ["bending_stop", "actuator_lag", "torque_map"])
def test_a_parameter_that_the_data_do_not_move_is_told(still, capsys, effect):
    assert run(command, [str(still), "--free", effect]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert f"not determined by these data: {effect}" in shown and "is hardly determined by these data" in shown


@pytest.mark.parametrize("effect", ["actuator_lag", "torque_map", "torque_decay", "dead_time"])
def test_beside_others_that_they_do_it_is_as_unsure_as_its_bounds_and_the_others_are_not(still, capsys, effect):
    assert run(command, [str(still), "--free", f"keq,damping,{effect}", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert any(words.startswith(effect) for words in document["not_told"])
    for name, facts in document["parameters"].items():
        if name.startswith(effect):
            (fact,) = (p for p in EFFECTS[effect].parameters() if name == f"{effect}.{p.name}")
            assert facts["ci95"] == [fact.lower, fact.upper]
        else:
            assert facts["ci95"][1] - facts["ci95"][0] < 0.3


def test_a_trial_that_cannot_be_simulated_is_told_by_its_name(folder, tmp_path, capsys):
    """As where the pressures of one are in other units."""
    known = read_dataset(folder)
    second = known.trials[1]
    mad = replace(second, trajectory=replace(second.trajectory, torque=1000 * second.trajectory.torque))
    write_dataset(replace(known, trials=(known.trials[0], mad)), tmp_path / "mad")
    assert run(command, [str(tmp_path / "mad")]) == 0
    assert "trial_02 cannot be simulated with these values; check its input." in capsys.readouterr().out
    assert run(command, [str(tmp_path / "mad"), "--by-level", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["failed"] == ["trial_02"]
    assert any("keq_scale@2.33" in words for words in document["not_told"])


BAD = [
    (["--free", "stiffness"], "parameter to fit"),
    (["--free", ""], "at least one"),
    (["--free", "keq@9"], "1.11, 2.33"),
    (["--effect", "magic"], "magic"),
    (["--effect", "stiffening:cubic=many"], "a number"),
    (["--train", "trial_9"], "trial_01, trial_02"),
    (["--test", "trial_*"], "at least one"),
    (["--links", "0"], "0"),
    (["--links", "many"], "many"),
    (["--placement", "end"], "end"),
    (["--delay", "-1"], "-1"),
    (["--plot", "fit.doc"], ".png"),
    (["--json", "missing/folder/fit.json"], "cannot write"),
    (["--json", "one.file", "--urdf", "one.file"], "different files"),
]


@pytest.mark.parametrize(("arguments", "said"), BAD)
def test_bad_input_is_one_line_and_exit_code_two(folder, capsys, arguments, said):
    assert run(command, [str(folder), *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("hsr-fit: error: ")
    assert said in err


def test_a_dataset_that_is_not_there_or_empty_is_one_line_and_exit_code_two(tmp_path, capsys):
    assert run(command, [str(tmp_path / "gone")]) == 2
    assert run(command, [str(tmp_path)]) == 2
    (tmp_path / "dataset.toml").write_text("")
    assert run(command, [str(tmp_path)]) == 2
    assert run(command, []) == 2
    assert capsys.readouterr().err.count("\n") == 4


def test_help_does_not_wait_for_numpy():
    program = (
        "import sys; from hsr_pin.cli.fit import main; sys.argv[1:] = ['--help']\n"
        "try: main()\n"
        "finally: print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "--free" in done.stdout
    assert done.stdout.strip().endswith("False")
