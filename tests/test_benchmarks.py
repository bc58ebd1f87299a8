"""The benchmarks compare like with like, run, and are shown as they were written. Nothing here asserts how fast anything is."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from hsr_pin.robot.specification import ArmSpecification

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "benchmarks"
MEASUREMENTS = ("work_precision", "growth", "throughput", "latency", "startup", "diagnosis", "space")
ROW = re.compile(r"\| (?P<task>.+) \| (?P<ours>.+) \| (?P<peer>.+): (?P<theirs>.+) \| (?P<ratio>.+) \| .*\|")


@pytest.fixture
def bench(monkeypatch):
    """``bench(name)``: a module of the benchmarks."""
    monkeypatch.syspath_prepend(FOLDER)
    return importlib.import_module


def test_every_line_of_the_table_was_written_with_a_number_and_a_ratio(bench):
    written = (FOLDER / "results.md").read_text(encoding="utf-8")
    table, _, conditions = written.partition("\n\n")
    assert table.startswith(bench("rows").HEADER)
    rows = [ROW.fullmatch(line) for line in table.splitlines()[2:]]
    titles = [title for name in MEASUREMENTS for title in bench(name).titles()]
    assert [(row["task"], row["peer"]) for row in rows] == [(title.task, title.peer) for title in titles]
    for row in rows:
        assert re.search(r"\d", row["ours"])
        assert re.fullmatch(r"(over )?[\d.]+( \(peer ahead\))?", row["ratio"]) or row["theirs"] == "not installed", row[0]
    assert re.search(r"\d cores .* mujoco \d", conditions)


def test_the_page_shows_what_was_written():
    page = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    written = (FOLDER / "results.md").read_text(encoding="utf-8")
    assert f"<!-- output of: python benchmarks/run.py --show -->\n{written}<!-- end of output -->" in page


def test_all_measurements_are_run(bench):
    assert bench("run").MEASUREMENTS == MEASUREMENTS


#: Its commands take half a minute, even few of them.
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name == "diagnosis")) for name in MEASUREMENTS])
def test_a_measurement_runs(name, bench, capfd, request):
    if name in ("space", "diagnosis"):
        request.getfixturevalue("shared")
    if name not in ("space", "startup"):
        pytest.importorskip("mujoco", reason="compares with MuJoCo: python3 scripts/install.py bench")
    rows = list(bench(name).measure(quick=True))
    assert rows
    assert all(ROW.fullmatch(str(row).strip()) and row.ratio > 0 for row in rows)


# The peers solve the same problem


@pytest.mark.parametrize("links", [4, 16])
def test_ours_and_scipy_agree_to_a_ten_thousandth_of_a_millimetre(links, bench):
    exact, arm = bench("exact"), ArmSpecification(links=links)
    ours = bench("ours").Ours([arm], exact.FINE).run()
    assert bench("problem").tip_error([arm], ours, exact.exact_motion(links)) < 1e-4


def test_ours_keeps_to_what_is_asked_at_every_tolerance(bench):
    """A line of the table is as accurate as it says only where a finer tolerance helps."""
    arm, ours, exact = ArmSpecification(), bench("ours"), bench("exact").exact_motion(4)
    errors = [
        bench("problem").tip_error([arm], ours.tolerant([arm], "extrapolated4", t).run(), exact) for t in (1e-3, 1e-4, 1e-5)
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_ours_never_asks_pinocchio_for_its_workspace(bench, monkeypatch):
    """Whose memory grows with the cube of the links."""

    def refuse(*_):
        raise AssertionError("pin.Data was asked for")

    for name in ("buildModelFromXML", "Data"):
        monkeypatch.setattr(pinocchio, name, refuse)
    monkeypatch.setattr(pinocchio.Model, "createData", refuse)
    arm = ArmSpecification(links=500, tip_mass=0.0123)
    assert np.isfinite(bench("ours").tolerant([arm], "extrapolated4", 1e-3).run()).all()


@pytest.mark.parametrize("method", ["Euler", "discrete"])
@pytest.mark.parametrize("links", [4, 16])
def test_mujoco_extrapolated_to_step_zero_agrees_within_a_thousandth(links, method, bench):
    pytest.importorskip("mujoco")
    problem, peer, arm = bench("problem"), bench("peer_mujoco"), ArmSpecification(links=links)
    if method not in peer.METHODS:
        pytest.skip(f"this MuJoCo has no integrator {method}")
    coarse, fine = (peer.MujocoChain(arm, method, count).run() for count in (160, 320))
    assert problem.tip_error([arm], 2 * fine - coarse, bench("exact").exact_motion(links)) < 1e-3


def test_every_integrator_of_mujoco_is_tried(bench):
    mujoco = pytest.importorskip("mujoco")
    there = {getattr(mujoco.mjtIntegrator, name) for name in dir(mujoco.mjtIntegrator) if name.startswith("mjINT_")}
    assert {*bench("peer_mujoco").METHODS.values()} == there


def test_a_rollout_of_many_arms_is_each_arm_alone(bench):
    pytest.importorskip("mujoco")
    peer, problem = bench("peer_mujoco"), bench("problem")
    arms = bench("throughput").FLEETS[-1].extremes()[:5]
    together = peer.MujocoRollout(arms, 2, "Euler", 10).run()
    for place, arm in enumerate(arms):
        alone = peer.MujocoChain(arm, "Euler", 10).run()
        assert problem.tip_error([arm], together[:, place : place + 1], alone) < 1e-9


def test_mujoco_and_scipy_fit_what_hsr_fit_fits(bench, shared):
    pytest.importorskip("mujoco")
    from hsr_pin.identification.experiment import prepare, restricted
    from hsr_pin.identification.hypothesis import Hypothesis
    from hsr_pin.inference.fit import fit

    whole = prepare(bench("diagnosis").recordings())
    experiment = restricted(whole, [run.trial.name for run in whole.runs[2:4]])
    peer, ours = bench("peer_fit").MujocoFit(experiment, "Euler", 16), fit(experiment, Hypothesis())
    np.testing.assert_allclose(peer.run(), ours.values, rtol=0.01)


def test_pybullet_converges_to_the_same_motion(bench):
    pytest.importorskip("pybullet", reason="needs PyBullet: python3 scripts/install.py bench")
    problem, arm = bench("problem"), ArmSpecification()
    coarse, fine = (bench("peer_pybullet").PybulletChain(arm, count).run() for count in (400, 800))
    assert problem.tip_error([arm], 2 * fine - coarse, bench("exact").exact_motion(4)) < 5e-3


def test_arms_in_threads_come_back_in_their_order(bench):
    ours, arms = bench("ours"), bench("throughput").FLEETS[-1].arms(5)
    apart, together = (ours.tolerant(arms, "extrapolated4", 1e-4, threads=threads).run() for threads in (2, 1))
    assert np.array_equal(apart, together)
    assert len({*together[-1, :, 0]}) == 5


def test_the_table_is_shown_without_loading_anything_heavy():
    code = "import run, sys; run.main(); print(*sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code, "--show"], cwd=FOLDER, capture_output=True, text=True, check=True).stdout
    assert not {"mujoco", "pybullet", "numpy", "numba"} & {*shown.splitlines()[-1].split()}


def test_arms_against_a_post_are_timed_beside_mujoco(bench):
    pytest.importorskip("mujoco", reason="compares with MuJoCo: python3 scripts/install.py bench")
    (row,) = bench("contact").measure(quick=True)
    assert ROW.fullmatch(str(row).strip()) and row.ratio > 0
