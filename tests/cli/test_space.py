"""The commands over recordings of arms in space: what they fit, find, show and write, and what they refuse in one line."""

import json

import numpy as np
import pytest

from hsr_pin.cli import diagnose, export, fit, replay, sim
from hsr_pin.cli.command import run
from hsr_pin.effects import parse_effect
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import load_urdf
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Dataset, Marker

from ..filmed import filmed

MARKERS = (Marker("mid", 0.12), Marker("side", 0.24, 0.03, 0.5))
WAYS = ((0.6, 0.0), (-0.2, 0.5), (0.3, -0.5))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three steps of an arm whose axes of actuation are turned by 0.2 rad; declared a tenth too soft."""
    time, law = np.arange(81) * 0.01, parse_effect("turned_actuation:angle=0.2")
    arm = ArmSpecification(10, keq=1.2, damping=0.05, placement="mid", bending="space")
    ways = [np.where(time[:, None] < 0.1, 0.0, way) for way in WAYS]
    results = simulate_batch([Scenario(arm, time, u, effects=(law,), markers=MARKERS) for u in ways])
    trials = filmed([result.raise_on_failure().trajectory for result in results], 1e-4, 0)
    path = tmp_path_factory.mktemp("recordings") / "wide"
    write_dataset(Dataset("wide", 0.24, 0.15, 0.04, "hanging", trials, bending="space"), path)
    return path


@pytest.fixture
def answered(capsys):
    """``answered(command, ...)``: the exit code, what is printed and what is said."""

    def call(module, *arguments):
        code = run(module.command, list(map(str, arguments)))
        return code, *capsys.readouterr()

    return call


def test_a_fit_tells_of_an_arm_in_space(folder, answered, tmp_path):
    free = ("--free", "keq,damping,turned_actuation", "--links", 6)
    files = ("--json", tmp_path / "fit.json", "--plot", tmp_path / "fit.svg", "--urdf", tmp_path / "arm.urdf")
    code, out, _ = answered(fit, folder, *free, *files)
    assert code == 0 and "turned_actuation.angle" in out
    document = json.loads((tmp_path / "fit.json").read_text())
    assert document["parameters"]["turned_actuation.angle"]["value"] == pytest.approx(0.2, abs=0.01)
    assert (document["arm"]["bending"], document["arm"]["torsion"]) == ("space", None)
    assert document["arm"]["markers"][1] == {"name": "side", "arc_length": 0.24, "radius": 0.03, "angle": 0.5}
    assert load_urdf(tmp_path / "arm.urdf").bending == "space"
    assert "y [mm]" in (tmp_path / "fit.svg").read_text() or "x [mm]" in (tmp_path / "fit.svg").read_text()


def test_a_diagnosis_names_what_only_space_has(folder, answered, tmp_path):
    few = ("--effects", "turned_actuation,unequal_stiffness,tip_mass", "--links", 6, "--jobs", 1)
    code, out, _ = answered(diagnose, folder, *few, "--json", tmp_path / "d.json", "--html", tmp_path / "d.html")
    assert code == 0 and "turned_actuation is missing" in out
    assert json.loads((tmp_path / "d.json").read_text())["verdict"]["effects"] == ["turned_actuation"]
    page = (tmp_path / "d.html").read_text()
    assert "turned actuation" in page and "direction of bending" in page


def test_a_trial_is_replayed_with_all_its_coordinates(folder, answered, tmp_path):
    asked = ("--links", 6, "--placement", "mid", "--trial", 2)
    code, out, _ = answered(replay, folder, *asked, "--plot", tmp_path / "r.svg", "--html", tmp_path / "r.html", "--json")
    assert code == 0 and {each["marker"] for each in json.loads(out)["trials"][0]["errors"]} == {"mid", "side", "all"}
    drawn = (tmp_path / "r.svg").read_text()
    assert all(f"{axis} [mm]" in drawn for axis in "xyz")
    assert (tmp_path / "r.html").stat().st_size > 1e5
    code, better, _ = answered(sim, "--against", folder, *asked[:4], "--effect", "turned_actuation:angle=0.2", "--json")
    plain = next(each for each in json.loads(out)["trials"][0]["errors"] if each["marker"] == "all")["rms"]
    known = json.loads(better)["trials"][1]["errors"][-1]["rms"]
    assert code == 0 and known < plain


@pytest.mark.parametrize(
    ("module", "arguments", "word"),
    [
        (fit, ("--free", "torque_bias,preset_bend,restraint"), "laws that are defined for arms in space, got restraint"),
        (diagnose, ("--effects", "restraint"), "laws that hold about two axes"),
    ],
)
def test_what_is_for_arms_in_a_plane_is_refused_in_one_line(folder, answered, module, arguments, word):
    code, out, said = answered(module, folder, *(each.format(folder=folder) for each in arguments))
    assert code == 2 and out == "" and said.count("\n") == 1 and word in said


def test_a_fit_in_space_is_exported_with_what_it_found(folder, answered, tmp_path):
    free = ("--free", "keq,damping,turned_actuation", "--links", 10, "--json", tmp_path / "fit.json")
    assert answered(fit, folder, *free)[0] == 0
    code, out, _ = answered(export, "--from", tmp_path / "fit.json", "--to", "mjcf", "-o", tmp_path / "arm.xml")
    assert code == 0 and "turned_actuation: coefficients of the tendon of the actuator" in out
    assert "not in it: joints: hinges in series" in out and "10 links are enough" in out
    text = (tmp_path / "arm.xml").read_text()
    assert text.count("<general ") == 2 and 'name="joint_10_y"' in text and "twist" not in text
    code, _, said = answered(
        export, "--from", tmp_path / "fit.json", "--bending", "space", "--to", "sdf", "-o", tmp_path / "arm.sdf"
    )
    assert code == 2 and "--from: expected only --keq, --links" in said and "got --bending" in said
