"""No command writes over what it reads, nor over what another program wrote unless told to; what it wrote itself it replaces."""

import json
import os
from dataclasses import replace

import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.diagnose import command as diagnose
from hsr_pin.cli.export import command as export
from hsr_pin.cli.fit import command as fit
from hsr_pin.cli.replay import command as replay
from hsr_pin.cli.sim import command as sim
from hsr_pin.cli.urdf import command as urdf
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

STEP = ["--torque", "0.5", "--duration", "0.3"]
#: Command, what it is given beside the file, the options that name a file, its ending.
WRITERS = [
    (sim, STEP, "--html", "html"),
    (sim, STEP, "--plot", "png"),
    (sim, STEP, "--plot", "pdf"),
    (sim, STEP, "--plot", "svg"),
    (urdf, [], "--output", "urdf"),
    *((export, ["--to", target, "--links", "2"], "--output", target) for target in ("mjcf", "urdf", "sdf")),
    (replay, ["data", "--links", "2"], "--html", "html"),
    (replay, ["data", "--links", "2"], "--plot", "png"),
    (fit, ["data", "--links", "2", "--free", "keq"], "--json", "json"),
    (fit, ["data", "--links", "2", "--free", "keq"], "--plot", "png"),
    (fit, ["data", "--links", "2", "--free", "keq"], "--urdf", "urdf"),
    (diagnose, ["data", "--links", "2", "--effects", "tip_mass", "--max-effects", "0", "--jobs", "1"], "--json", "json"),
    (diagnose, ["data", "--links", "2", "--effects", "tip_mass", "--max-effects", "0", "--jobs", "1"], "--html", "html"),
]
NAMED = [f"{command.name} {option} {ending}" for command, _, option, ending in WRITERS]


@pytest.fixture(scope="module")
def recorded(heavy_tip, tmp_path_factory):
    """Recordings that no command may touch."""
    folder = tmp_path_factory.mktemp("recorded") / "data"
    write_dataset(heavy_tip, folder)
    return folder


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, recorded):
    """A working folder with the recordings in it, as ``data``."""
    monkeypatch.chdir(tmp_path)
    write_dataset(read_dataset(recorded), tmp_path / "data")
    before = contents(tmp_path / "data")
    yield tmp_path
    assert contents(tmp_path / "data") == before


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def refused(capsys, command, arguments, said):
    """That a command says one line and leaves everything as it was."""
    assert run(command, arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1 and said in err


@pytest.mark.parametrize(("command", "given", "option", "ending"), WRITERS, ids=NAMED)
def test_another_programs_file_is_replaced_only_by_force_and_ones_own_always_and_modes_stay(
    here, capsys, command, given, option, ending
):
    file = here / f"out.{ending}"
    file.write_text("mine, in which hsr_pin is but mentioned")
    refused(capsys, command, [*given, option, file.name], "will not replace the file: expected a new file, or one that hsr_pin")
    assert file.read_text().startswith("mine")
    file.chmod(0o640)
    assert run(command, [*given, option, file.name, "--force"]) == 0
    assert run(command, [*given, option, file.name]) == 0
    assert not file.read_bytes().startswith(b"mine")
    assert file.stat().st_mode & 0o777 == 0o640
    assert sorted(path.name for path in here.iterdir()) == ["data", file.name]


@pytest.mark.parametrize("force", [[], ["--force"]])
@pytest.mark.parametrize("place", ["data/dataset.toml", "data/trial_01.csv", "way/trial_02.csv"])
@pytest.mark.parametrize(
    ("command", "option"), [(diagnose, "--json"), (diagnose, "--html"), (fit, "--json"), (fit, "--urdf"), (replay, "--html")]
)
def test_what_is_read_is_never_written_over(here, capsys, command, option, place, force):
    os.symlink("data", here / "way")
    refused(capsys, command, ["data", option, place, *force], f"{place}: will not write over what is read")
    refused(capsys, command, ["data/dataset.toml", option, place, *force], f"{place}: will not write over what is read")


@pytest.mark.parametrize("force", [[], ["--force"]])
def test_a_command_file_is_never_written_over(here, capsys, force):
    (here / "in.csv").write_text("t,tau\n0,0\n0.5,0.3\n1,0.3\n")
    refused(capsys, sim, ["--input", "in.csv", "--html", "in.csv", *force], "in.csv: will not write over what is read")
    assert (here / "in.csv").read_text().startswith("t,tau")


def test_an_export_never_writes_over_the_result_the_recordings_or_another_programs_module(here, capsys):
    assert run(fit, ["data", "--links", "2", "--json", "fit.json"]) == 0
    before = (here / "fit.json").read_bytes()
    capsys.readouterr()
    result = ["--to", "mjcf", "--from", "fit.json", "--dataset", "data", "--force"]
    refused(capsys, export, [*result, "-o", "fit.json"], "fit.json: will not write over what is read")
    refused(capsys, export, [*result, "-o", "data/dataset.toml"], "data/dataset.toml: will not write over what is read")
    assert (here / "fit.json").read_bytes() == before
    arguments = ["--to", "mjcf", "--links", "2", "--effect", "viscoelastic:ratio=0.3", "-o", "arm.xml"]
    (here / "arm_laws.py").write_text("print('mine')")
    refused(capsys, export, arguments, "arm_laws.py: will not replace the file")
    assert not (here / "arm.xml").exists()
    for force in (["--force"], []):
        assert run(export, [*arguments, *force]) == 0
    assert "mine" not in (here / "arm_laws.py").read_text()


def test_a_report_in_the_folder_of_the_recordings_may_be_renewed(here, capsys):
    for _ in range(2):
        assert run(replay, ["data", "--links", "2", "--html", "data/run.html"]) == 0
    (here / "data" / "run.html").unlink()


def test_a_simulation_replaces_a_simulation_but_recordings_only_by_force(here, capsys):
    for _ in range(2):
        assert run(sim, [*STEP, "--csv", "simulated"]) == 0
        capsys.readouterr()
    expected = "a new or empty folder, or a dataset written by hsr-sim"
    refused(capsys, sim, [*STEP, "--csv", "data"], f"data: will not replace the dataset: expected {expected}")
    write_dataset(read_dataset("data"), here / "other")
    assert run(sim, [*STEP, "--csv", "other", "--force"]) == 0
    assert read_dataset("other").name == "simulation"


def test_a_table_beside_a_simulation_is_not_lost(here, capsys):
    assert run(sim, [*STEP, "--csv", "simulated"]) == 0
    capsys.readouterr()
    (here / "simulated" / "precious.csv").write_text("mine")
    refused(capsys, sim, [*STEP, "--csv", "simulated"], "will not replace the dataset")
    assert (here / "simulated" / "precious.csv").read_text() == "mine"


def test_the_input_is_not_in_the_folder_that_is_replaced(here, capsys):
    assert run(sim, [*STEP, "--csv", "simulated"]) == 0
    capsys.readouterr()
    (here / "simulated" / "in.csv").write_text("t,tau\n0,0\n0.5,0.3\n1,0.3\n")
    arguments = ["--input", "simulated/in.csv", "--csv", "simulated", "--force"]
    refused(capsys, sim, arguments, "the output folder contains an input file")


def test_a_urdf_for_each_stiffness_stops_at_another_programs_file(here, capsys):
    dataset = read_dataset("data")
    trials = (*dataset.trials[:2], *(replace(trial, keq=2.33, damping=0.1) for trial in dataset.trials[2:]))
    write_dataset(replace(dataset, trials=trials), here / "two")
    (here / "arm_keq2.33.urdf").write_text("mine")
    assert run(fit, ["two", "--links", "2", "--free", "keq", "--urdf", "arm.urdf"]) == 2
    out, err = capsys.readouterr()
    assert "keq_scale" in out  # what was found is not lost
    assert out.splitlines()[-1] == "wrote arm_keq1.11.urdf"
    assert "arm_keq2.33.urdf: will not replace the file" in err
    assert (here / "arm_keq2.33.urdf").read_text() == "mine"


def test_two_outputs_are_two_files(here, capsys):
    refused(capsys, sim, [*STEP, "--html", "a.png", "--plot", "./a.png"], "--plot and --html: expected two files")
    refused(capsys, replay, ["data", "--html", "a.png", "--plot", "a.png"], "expected two files")


def test_a_document_names_only_the_files_that_were_written(here, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    arguments = [*STEP, "--json", "--plot", "a.png", "--html", "a.html"]
    assert run(sim, arguments) == 0
    assert json.loads(capsys.readouterr().out)["written"] == ["a.png", "a.html"]
    monkeypatch.setattr("hsr_pin.output.os.replace", full)
    assert run(sim, arguments) == 2
    out, err = capsys.readouterr()
    assert json.loads(out)["written"] == []
    assert err.count("\n") == 1 and "No space left" in err
