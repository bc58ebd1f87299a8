"""``hsr-sim``: what it prints is what was simulated; bad input is one line and leaves nothing behind."""

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.sim import command
from hsr_pin.identification.comparison import compare
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.combinations import combinations
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def sim(capsys):
    """``sim(*arguments)``: exit code, stdout, stderr."""

    def call(*arguments):
        code = run(command, [str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def facts(sim):
    """``facts(*arguments)``: the JSON document of a run that ends well."""

    def call(*arguments):
        code, out, err = sim(*arguments, "--json")
        assert (code, err) == (0, "")
        return json.loads(out)

    return call


def program(*arguments, **more):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **more.pop("environment", {})}
    code = "import sys; from hsr_pin.cli.sim import main; main()"
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, env=environment, **more)


def test_what_a_run_needs_is_loaded_when_it_is_needed():
    code = "import sys, hsr_pin.cli.sim_report; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "pinocchio" in loaded
    assert not {"scipy", "rich", "jinja2", "matplotlib", "meshcat"} & {*loaded}
    assert "hsr_pin.recordings" not in loaded


@pytest.mark.parametrize("keq", [1.11, 2.33])
def test_the_table_has_the_rows_of_table_ii(sim, keq):
    code, out, err = sim("--links", 4, "--keq", keq)
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines() if line.strip()[:1].isdigit() and "links" not in line]
    assert [row[:3] for row in rows] == [[f"{c.P1:.4f}", f"{c.P2:.4f}", f"{c.tau:.3f}"] for c in combinations(keq)]
    assert all(len(row) == 9 for row in rows)


@pytest.mark.parametrize(("links", "placement"), [(None, "mid"), (4, "base"), (16, "mid")])
def test_four_links_are_the_papers_chain_and_without_options_it_is_the_fitted_one(facts, links, placement):
    own = [] if links is None else ["--links", links]
    wanted = facts("--links", links or 16, "--placement", placement, "--keq", 1.11, "--damping", 0.05, "--mount", "hanging")
    assert facts(*own)["runs"] == wanted["runs"]


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
@pytest.mark.parametrize("placement", ["base", "mid"])
def test_tips_are_those_of_the_simulation(facts, mount, placement):
    document = facts("--links", 7, "--keq", 2.33, "--mount", mount, "--placement", placement)
    arm = ArmSpecification(7, 2.33, 0.1, placement, mount)
    for row, found in zip(combinations(2.33), document["runs"], strict=True):
        tip = simulate(step_scenario(arm, row.tau)).trajectory.marker("tip")[-1]
        assert (found["tip"]["x"], found["tip"]["z"]) == pytest.approx((tip[0], tip[2]), abs=1e-9)
        assert found["phi"] == pytest.approx(row.tau / 2.33)


def test_both_algorithms_give_the_same(facts):
    runs = [facts("--dynamics", dynamics)["runs"] for dynamics in ("aba", "rnea")]
    for one, other in zip(*runs, strict=True):
        assert one["tip"] == pytest.approx(other["tip"], abs=1e-9)
        assert one["settling_time"] == pytest.approx(other["settling_time"], abs=1e-6)


def test_very_many_links_are_simulated_by_the_compiled_loops_and_that_is_said(facts, sim):
    few, many = (facts("--links", links, "--torque", 0.4, "--duration", 0.5) for links in (64, 65))
    assert (few["dynamics"], many["dynamics"]) == ("aba", "compiled")
    assert few["runs"][0]["tip"]["x"] == pytest.approx(many["runs"][0]["tip"]["x"], abs=1e-3)
    assert "1000 links" in (out := sim("--links", 1000, "--torque", 0.4)[1]) and "COMPILED" in out
    asked = facts("--links", 65, "--torque", 0.4, "--duration", 0.5, "--dynamics", "aba")
    assert asked["dynamics"] == "aba"
    assert asked["runs"][0]["tip"] == pytest.approx(many["runs"][0]["tip"], abs=1e-9)


def test_a_motion_that_gains_energy_is_noted(facts, monkeypatch):
    monkeypatch.setattr("hsr_pin.simulation.integrator.RINGING", "extrapolated4")
    (run,) = facts("--links", 4, "--damping", 0, "--placement", "mid", "--torque", 0.5, "--duration", 3)["runs"]
    assert any("to the energy of the motion" in note for note in run["notes"])


def test_the_arm_that_is_asked_for_is_the_one_that_runs(facts):
    asked = {
        "links": 3,
        "keq": 2.0,
        "damping": 0.2,
        "placement": "mid",
        "mount": "upright",
        "length": 0.2,
        "mass": 0.1,
        "tip_mass": 0.02,
    }
    arguments = [text for name, value in asked.items() for text in (f"--{name.replace('_', '-')}", value)]
    arm = facts(*arguments, "--torque", 0.5)["runs"][0]["arm"]
    assert {name: arm[name] for name in asked} == asked


def test_pressures_alone_bring_their_own_stiffness(facts):
    (found,) = facts("--pressures", 2.0, 2.3)["runs"]
    assert found["arm"]["keq"] == pytest.approx(float(PAPER.stiffness((2.0, 2.3))))
    assert found["pressures"] == [2.0, 2.3]
    assert found["torque"] == pytest.approx(float(PAPER.torque((2.0, 2.3))))


def test_a_stiffness_that_is_not_that_of_the_pressures_is_used_and_said(facts):
    (found,) = facts("--pressures", 2.0, 2.3, "--keq", 1.0)["runs"]
    assert found["torque"] == pytest.approx(float(PAPER.bending((2.0, 2.3))))
    assert "Eq. (1) gives 2.3 Nm/rad; the run uses 1 Nm/rad" in found["notes"][0]


def test_torques_and_pressures_may_be_repeated_and_mixed(facts):
    runs = facts("--keq", 1.5, "--torque", 0.5, "--torque", -0.5, "--pressures", 1.2, 2.2)["runs"]
    assert [round(found["torque"], 3) for found in runs] == [round(1.5 * float(PAPER.bending((1.2, 2.2))), 3), 0.5, -0.5]


def test_a_slip_in_the_papers_table_is_said(facts):
    notes = [note for found in facts()["runs"] for note in found["notes"]]
    assert notes == ["Table II prints P1 = 0.3368 bar for 1.000 N m; Eqs. (1), (4) and (5) give 0.3386"]


def test_an_effect_changes_the_motion_and_is_named(facts, sim):
    plain, stiffer = facts("--torque", 0.8), facts("--torque", 0.8, "--effect", "torque_bias:bias=-0.2")
    assert stiffer["runs"][0]["tip"]["x"] < plain["runs"][0]["tip"]["x"] - 0.01
    assert stiffer["runs"][0]["effects"] == [{"name": "torque_bias", "bias": -0.2}]
    assert "torque_bias" in sim("--torque", 0.8, "--effect", "torque_bias:bias=-0.2")[1]


def test_a_file_drives_the_arm(facts, tmp_path):
    path = tmp_path / "input.csv"
    path.write_text("t,tau\n0,0\n0.1,0.6\n3,0.6\n")
    (followed,), (stepped,) = facts("--input", path)["runs"], facts("--torque", 0.6)["runs"]
    assert followed["tip"] == pytest.approx(stepped["tip"], abs=1e-9)
    assert followed["settling_time"] == pytest.approx(stepped["settling_time"], abs=1e-9)


def test_json_is_one_document_on_stdout_whatever_else_is_written(sim, tmp_path):
    code, out, err = sim("--json", "--csv", tmp_path / "d", "--plot", tmp_path / "p.png", "--html", tmp_path / "a.html")
    assert (code, err) == (0, "")
    assert json.loads(out)["written"] == [str(tmp_path / name) for name in ("d", "p.png", "a.html")]


def test_a_run_that_did_not_settle_says_so_and_json_has_null(sim, facts):
    out = sim("--duration", 0.2)[1]
    assert "did not settle within the run" in out
    assert [found["settling_time"] for found in facts("--duration", 0.2)["runs"]] == [None] * 3


def test_the_dataset_reads_back_as_it_was_simulated(sim, tmp_path):
    assert sim("--csv", tmp_path / "data", "--mount", "upright")[0] == 0
    dataset = read_dataset(tmp_path / "data")
    assert (dataset.mount, len(dataset.trials), dataset.chain) == ("upright", 3, (16, "mid"))
    for row, trial in zip(combinations(1.11), dataset.trials, strict=True):
        motion = simulate(step_scenario(ArmSpecification(16, placement="mid", mount="upright"), row.tau)).trajectory
        assert np.abs(trial.trajectory.positions - motion.positions).max() < 1e-12
        assert PAPER.torque(trial.trajectory.pressures, trial.keq)[-1] == pytest.approx(row.tau, abs=1e-12)


def test_a_dataset_that_it_wrote_compares_with_no_error(sim, tmp_path):
    assert sim("--csv", tmp_path / "data", "--mount", "horizontal")[0] == 0
    assert max(error.rms for error in compare(read_dataset(tmp_path / "data")).errors) < 1e-9


def test_pictures_and_pages_are_written(sim, tmp_path):
    code, out, _ = sim("--plot", tmp_path / "tips.png", "--html", tmp_path / "arms.html")
    assert code == 0
    assert (tmp_path / "tips.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "arms.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert out.count("wrote ") == 2
    assert len(list(tmp_path.iterdir())) == 2


BAD = {
    "no links": (["--links", "0"], "links: expected a whole number from 1 to 1000, got 0"),
    "half a link": (["--links", "2.5"], "links: expected a whole number from 1 to 1000"),
    "links that are no number": (["--links", "four"], "links: expected a whole number from 1 to 1000"),
    "negative stiffness": (["--keq", "-1", "--torque", "1"], "keq: expected a number, more than zero [Nm/rad], got -1"),
    "negative damping": (["--damping", "-1"], "damping: expected a number, zero or more [Nm s/rad], got -1"),
    "no stiffness": (["--keq", "nan", "--torque", "1"], "keq: expected a number, more than zero [Nm/rad], got nan"),
    "a pressure that is no number": (["--pressures", "nan", "2"], "pressures: expected finite numbers, got nan"),
    "a pressure out of range": (["--keq", "1", "--pressures", "1", "40"], "P2: expected a pressure from 0 to 4 bar, got 40"),
    "pressures without stiffness": (["--pressures", "0", "0"], "expected more than 0 and up to"),
    "half a pressure pair": (["--pressures", "1"], "--pressures"),
    "a torque that is no number": (["--torque", "nan"], "torque: expected a finite number [N m], got nan"),
    "a torque beyond the arm": (["--torque", "50"], "the arm bent beyond its limit"),
    "unknown mount": (["--mount", "sideways"], "mount: expected hanging or upright or horizontal or flat, got 'sideways'"),
    "unknown placement": (["--placement", "end"], "placement: expected base or mid or shifted, got 'end'"),
    "unknown dynamics": (["--dynamics", "euler"], "'euler' is not one of 'aba', 'rnea', 'compiled'"),
    "stiffness without pressures": (["--keq", "1.5"], "keq: expected 1.11 or 2.33 Nm/rad, whose pressure combinations the paper"),
    "unknown effect": (["--effect", "frictoin:level=1"], "expected stiffness_gradient, "),
    "an effect's parameter": (["--effect", "dry_friction:size=1"], "parameter of dry_friction: expected "),
    "the same effect twice": (
        ["--effect", "tip_mass:mass=0.1", "--effect", "tip_mass:mass=0.2"],
        "expected each effect at most once",
    ),
    "a duration too short": (["--duration", "0"], "duration: expected 0.2 to 3600 s"),
    "a duration without end": (["--duration", "inf"], "duration: expected 0.2 to 3600 s"),
    "a file and a torque": (["--input", "a.csv", "--torque", "1"], "--input: expected this option alone"),
    "a file that is not there": (["--input", "gone.csv"], "gone.csv: cannot read the file"),
    "a wrong header": (
        ["--input", "wrong.csv"],
        "wrong.csv:1:1: header: expected t,P1,P2 or t,tau or t,tau_x,tau_y, got time,force",
    ),
    "a wrong number": (["--input", "letters.csv"], "letters.csv:3:3: column tau: expected a finite number, got 'much'"),
    "an unknown picture": (["--plot", "tips.bmp"], "picture: expected a name ending in .png, .pdf, .svg, got tips.bmp"),
    "an unwritable picture": (["--plot", "wrong.csv/tips.png"], "wrong.csv/tips.png: cannot write the file"),
    "an unwritable page": (["--html", "gone/arm.html"], "gone/arm.html: cannot write the file"),
    "a page that is a folder": (["--html", "folder"], "folder: cannot write the file"),
    "an unwritable dataset": (["--csv", "wrong.csv/data"], "wrong.csv/data: cannot write the folder"),
    "a dataset where a file is": (["--csv", "wrong.csv"], "wrong.csv: cannot write the"),
    "a dataset in a strange folder": (["--csv", "folder"], "folder: will not replace the folder"),
    "an unknown option": (["--lnks", "4"], "No such option"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_leaves_nothing_behind(sim, tmp_path, monkeypatch, case):
    arguments, said = BAD[case]
    monkeypatch.chdir(tmp_path)
    Path("wrong.csv").write_text("time,force\n0,1\n1,2\n")
    Path("letters.csv").write_text("t,tau\n0,1\n1,much\n")
    Path("folder").mkdir()
    Path("folder/mine.txt").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    good = [] if "--csv" in arguments else ["--csv", "data"]
    good += [] if "--html" in arguments else ["--html", "arm.html"]
    code, out, err = sim(*arguments, *good)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert sorted(tmp_path.rglob("*")) == before


def test_what_cannot_be_written_is_refused_before_anything_is_simulated(sim, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise AssertionError("it was simulated")

    monkeypatch.setattr("hsr_pin.cli.sim_runs.simulate", fail)
    assert sim("--html", tmp_path / "gone" / "arm.html")[0] == 2
    assert sim("--csv", "/dev/null")[0] == 2
    with pytest.raises(AssertionError, match="it was simulated"):
        sim("--html", tmp_path / "arm.html")


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize(
    "arguments", [[], ["--pressures", "1.2", "2.2", "--pressures", "2", "2.5"], ["--torque", "-3.123", "--keq", "2.33"]]
)
def test_the_table_is_whole_at_usual_widths(sim, monkeypatch, columns, arguments):
    monkeypatch.setenv("COLUMNS", str(columns))
    out = sim(*arguments)[1]
    assert "…" not in out
    table = [line for line in out.splitlines() if line.startswith(" ")]
    assert max(map(len, table)) <= columns


def test_in_a_pipe_it_is_plain_text_without_a_bar():
    result = program("--links", "2")
    assert (result.returncode, result.stderr) == (0, "")
    assert "\x1b" not in result.stdout
    assert "1.2868" in result.stdout


def test_a_pipe_that_knows_only_ascii_will_do():
    result = program("--links", "2", environment={"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"})
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.isascii()


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals are POSIX's")
def test_on_a_terminal_it_is_coloured_and_the_bar_is_gone_at_the_end():
    ours, theirs = pty.openpty()
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm-256color"}
    environment.pop("NO_COLOR", None)
    code = "from hsr_pin.cli.sim import main; main()"
    process = subprocess.Popen([sys.executable, "-c", code], stdin=theirs, stdout=theirs, stderr=theirs, env=environment)
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # the other side has closed
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert process.wait() == 0
    text = shown.decode()
    assert "\x1b[1m16 links" in text
    assert "simulating" in text
    assert text.rfind("simulating") < text.find("1.2868")


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom hsr_pin.cli.sim import command\nfrom hsr_pin.cli.command import run\n"
        "code = run(command, ['--help'])\n"
        "heavy = {'pinocchio', 'numpy', 'scipy', 'matplotlib', 'meshcat', 'rich', 'jinja2'} & set(sys.modules)\n"
        "print(sorted(heavy), file=sys.stderr)\nsys.exit(code)"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert "--keq" in result.stdout
    assert result.stderr == "[]\n"


def test_obstacles_are_simulated_told_and_kept_with_the_recording(sim, tmp_path):
    folder = tmp_path / "made"
    code, out, err = sim("--torque", 1.5, "--post", 0.06, -0.14, 0.01, "--ground", -0.3, "--wall", -0.2, "--csv", folder)
    assert (code, err) == (0, "")
    words = " ".join(out.split())
    assert "obstacle 3 (cylinder): contact from" in words
    assert "obstacle 1 (half space): no contact" in words
    dataset = read_dataset(folder)
    assert [obstacle.shape for obstacle in dataset.obstacles] == ["half_space", "half_space", "cylinder"]
    assert max(error.rms for error in compare(dataset).errors) < 1e-4


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("--post", 0.06, -0.14, 0), "radius of an obstacle"), (("--ground", "nan"), "point"), (("--material", "wool"), "silicone")],
)
def test_a_wrong_obstacle_is_one_line(sim, arguments, words):
    code, out, err = sim("--torque", 1, *arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert words in err
