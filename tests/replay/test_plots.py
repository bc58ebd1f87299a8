"""A picture shows the numbers it is made from, with units, and is written whole or not at all."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex

from hsr_pin.errors import OutputError
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.plots import COLOURS, comparison_figure, constant_curvature, save, tip_figure
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

ROOT = Path(__file__).resolve().parents[2]


def line(axes, label):
    (found,) = [line for line in axes.get_lines() if line.get_label() == label]
    return found


@pytest.fixture(scope="module")
def runs(run_of):
    return [run_of(torque=torque, label=f"{torque} N m") for torque in (0.2, 0.8, 0.5)]


def test_every_run_is_drawn_where_its_tip_went(runs):
    (axes,) = tip_figure(runs).axes
    for run in runs:
        drawn = line(axes, run.label).get_xydata()
        went = 1e3 * run.simulated.marker("tip")[:, [0, 2]]
        assert drawn[::5] == pytest.approx(went, abs=1e-9)


def test_the_plane_is_drawn_true_to_scale_and_labelled_with_units(runs):
    (axes,) = tip_figure(runs).axes
    assert axes.get_aspect() == 1.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [mm]", "z [mm]")


def test_every_run_has_a_colour_and_a_name_of_its_own_in_the_order_given(runs):
    (axes,) = tip_figure(runs).axes
    assert len({to_hex(line(axes, run.label).get_color()) for run in runs}) == 3
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == [*(run.label for run in runs), "tip of a constant-curvature arm"]


def test_in_grey_every_run_and_every_marker_has_dashes_of_its_own(runs, run_of):
    (axes,) = tip_figure(runs).axes
    looks = {(curve._unscaled_dash_pattern, curve.get_marker()) for curve in (line(axes, run.label) for run in runs)}
    assert len({repr(dashes) for dashes, _ in looks}) == len({end for _, end in looks}) == 3
    across = comparison_figure(run_of(measured=(0.003, 0.0, 0.004))).axes[1]
    lines = [curve for curve in across.get_lines() if curve.get_marker() != "."]
    assert len({repr(curve._unscaled_dash_pattern) for curve in lines}) == len(lines) == 2


def test_the_arm_at_its_end_reaches_from_base_to_tip(runs):
    (axes,) = tip_figure(runs[:1]).axes
    shapes = [shape.get_xydata() for shape in axes.get_lines() if len(shape.get_xydata()) == 6]
    (shape,) = shapes
    assert shape[0] == pytest.approx([0, 0], abs=1e-9)
    assert shape[-1] == pytest.approx(1e3 * runs[0].simulated.marker("tip")[-1, [0, 2]], abs=1e-9)


@pytest.mark.parametrize(
    ("mount", "along", "across"), [("hanging", (0, -1), (1, 0)), ("upright", (0, 1), (1, 0)), ("horizontal", (1, 0), (0, -1))]
)
def test_the_reference_is_the_closed_form_of_constant_curvature(mount, along, across):
    bending = np.array([-2.0, -0.3, 0.4, 1.5, 3.0])
    arc = constant_curvature(ArmSpecification(mount=mount), bending)
    straight, sideways = 0.24 * np.sin(bending) / bending, 0.24 * (1 - np.cos(bending)) / bending
    assert arc == pytest.approx(np.outer(straight, along) + np.outer(sideways, across), abs=1e-12)


def test_a_straight_arm_of_constant_curvature_is_straight():
    assert constant_curvature(ArmSpecification(), np.zeros(1)) == pytest.approx(np.array([[0, -0.24]]), abs=1e-15)


def test_a_fine_chain_without_load_bends_along_the_reference():
    light = ArmSpecification(links=100, placement="mid", mass=1e-9)
    tip = 0.8 / 1.11
    ends = constant_curvature(light, np.array([tip]))[0]
    settled = simulate(Scenario(light, np.array([0.0, 0.01]), np.full(2, 0.8), Settled(0.8)))
    assert settled.trajectory.marker("tip")[0, [0, 2]] == pytest.approx(ends, abs=1e-5)


def test_the_error_is_the_distance_between_the_markers(run_of):
    run = run_of(measured=(0.003, 0.0, 0.004))
    figure = comparison_figure(run)
    error = figure.axes[3]
    assert error.get_ylabel() == "distance [mm]"
    for curve in error.get_lines():
        values = curve.get_ydata()
        assert values[np.isfinite(values)] == pytest.approx(5.0, abs=1e-9)
    assert [np.isnan(curve.get_ydata()).sum() for curve in error.get_lines()] == [0, 11]


def test_measured_markers_are_dots_at_their_places_and_gaps_stay_gaps(run_of):
    run = run_of(measured=(0.003, 0.0, 0.004))
    across = comparison_figure(run).axes[1]
    dots = [curve for curve in across.get_lines() if curve.get_marker() == "."]
    assert len(dots) == 2
    assert dots[1].get_ydata() == pytest.approx(1e3 * run.measured.marker("tip")[:, 0], nan_ok=True)
    assert {curve.get_linestyle() for curve in dots} == {"None"}


def test_a_marker_at_the_base_is_not_compared(run_of):
    assert [marker.name for marker in run_of(measured=(0, 0, 0)).moving] == ["mid", "tip"]


def test_times_that_differ_are_compared_at_the_measured_ones(run_of):
    run = run_of(measured=(0.0, 0.0, 0.002))
    other = run.measured
    half = type(other)(other.time[10:40:3], other.markers, other.positions[10:40:3])
    assert Drawn("later", run.arm, run.simulated, half).gap("tip") == pytest.approx(0.002, abs=1e-9)


def test_a_motion_of_another_arm_is_refused(run_of):
    with pytest.raises(ValueError, match="expected a simulated motion with 5 joint angles"):
        Drawn("wrong", ArmSpecification(links=5), run_of().simulated)


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("PNG", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_the_ending_of_the_name_decides_the_format(runs, tmp_path, ending, start):
    save(tip_figure(runs), tmp_path / f"tips.{ending}")
    assert (tmp_path / f"tips.{ending}").read_bytes().startswith(start)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("name", ["tips.bmp", "tips", "tips.png/tips.png"])
def test_a_picture_that_cannot_be_written_is_refused(runs, tmp_path, name):
    (tmp_path / "tips.png").write_text("mine")
    with pytest.raises(OutputError):
        save(tip_figure(runs), tmp_path / name)
    assert (tmp_path / "tips.png").read_text() == "mine"


def test_the_same_runs_give_the_same_picture(runs, tmp_path):
    for name in ("a.svg", "b.svg"):
        save(tip_figure(runs), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_colours_can_be_told_apart_by_brightness_or_by_the_colour_blind():
    """Viénot, Brettel and Mollon's red-blind and green-blind views keep the first three apart (1999)."""
    srgb = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in COLOURS[:3]]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    red_blind = [[0.1121, 0.8853, -0.0005], [0.1127, 0.8897, -0.0001], [0.0045, 0.0, 1.0]]
    green_blind = [[0.292, 0.7055, -0.0003], [0.2934, 0.7089, 0.0], [-0.021, 0.0256, 1.0]]
    for view in (red_blind, green_blind):
        seen = linear @ np.array(view).T
        apart = [np.linalg.norm(seen[i] - seen[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
        assert min(apart) > 0.1


def test_no_global_state_of_matplotlib_is_touched():
    code = (
        "import sys, matplotlib, hsr_pin.replay.plots as plots, io\n"
        "before = dict(dict.items(matplotlib.rcParams))  # past the look-up that would load a backend\n"
        "from hsr_pin.simulation.scenario import step_scenario\n"
        "from hsr_pin.simulation.simulate import simulate\nfrom hsr_pin.replay.drawn import Drawn\n"
        "from hsr_pin.robot.specification import ArmSpecification as Arm\n"
        "plots.tip_figure([Drawn('a', Arm(), simulate(step_scenario(Arm(), 0.5)).trajectory)]).savefig(io.BytesIO())\n"
        "assert dict(dict.items(matplotlib.rcParams)) == before\nassert 'matplotlib.pyplot' not in sys.modules"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    environment.pop("DISPLAY", None)
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
