"""Recordings of hardware are edited as described without revealing it, and each truth follows from its edit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.blind.cases import Case
from hsr_pin.blind.kinds import KINDS, kinds_of
from hsr_pin.blind.real import edits
from hsr_pin.blind.real.build import build_real, drawn_amount, plan_real, reference
from hsr_pin.blind.real.recipes import OTHER_KINDS, RECIPES
from hsr_pin.cli.blind import command
from hsr_pin.cli.command import run
from hsr_pin.errors import InputError
from hsr_pin.recordings.read import read_dataset
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

RECORDINGS = Path(__file__).resolve().parents[3] / "shared" / "recordings"
needs_recordings = pytest.mark.skipif(not RECORDINGS.is_dir(), reason="the recordings of hardware are not beside this checkout")

LENGTH, MARKERS = 0.3, (Marker("base", 0.0), Marker("mid", 0.15), Marker("tip", 0.3))


def arc(mount: str = "hanging") -> Dataset:
    """Return an arm that bends as a circle, increasingly, after a time at rest."""
    t = np.arange(200) * 0.02
    phi = np.maximum(t - 1.0, 0.0) * 0.3 + 1e-9
    s = np.array([marker.arc_length for marker in MARKERS])
    angle = phi[:, None] * s / LENGTH
    x, z = (1 - np.cos(angle)) * LENGTH / phi[:, None], np.sin(angle) * LENGTH / phi[:, None]
    flat = np.zeros_like(x)
    points = np.stack([x, flat, -z] if mount == "hanging" else [z, flat, -x], axis=-1)
    track = Trajectory(t, MARKERS, points, torque=phi)
    return Dataset("arc", LENGTH, 0.2, 0.05, mount, (Trial("trial_01", track, 1.0, tip_mass=0.05),))


def points(dataset):
    return dataset.trials[0].trajectory.positions


@pytest.mark.parametrize("mount", ["hanging", "horizontal"])
def test_the_direction_of_an_arc_is_found_from_its_markers(mount):
    dataset = arc(mount)
    ex, ez = {"hanging": ((1, 0, 0), (0, 0, -1)), "horizontal": ((0, 0, -1), (1, 0, 0))}[mount]
    found = edits.directions(dataset.trials[0].trajectory, np.array(ex, float), np.array(ez, float))
    phi = dataset.trials[0].trajectory.torque
    assert np.allclose(found, phi[:, None] * [0.0, 0.5, 1.0], atol=1e-6)


@pytest.mark.parametrize("mount", ["hanging", "horizontal"])
def test_moved_markers_stand_off_at_right_angles_to_the_arm(mount):
    dataset = arc(mount)
    away = points(edits.move_markers(dataset, 0.01)) - points(dataset)
    assert np.allclose(np.linalg.norm(away, axis=2), 0.01)
    ahead = np.gradient(points(dataset)[-1], axis=0)[1]
    assert abs(away[-1, 1] @ ahead) < 1e-6
    assert np.allclose(away[0, 2], [0.01, 0, 0] if mount == "hanging" else [0, 0, -0.01])


@pytest.mark.parametrize("mount", ["hanging", "horizontal"])
def test_a_turned_frame_turns_every_marker_about_the_base_towards_positive_bending(mount):
    dataset = arc(mount)
    turned = points(edits.turn_frame(dataset, 0.1))
    assert np.allclose(np.linalg.norm(turned, axis=2), np.linalg.norm(points(dataset), axis=2))
    sideways = turned[0, 2, 0] if mount == "hanging" else -turned[0, 2, 2]
    assert sideways == pytest.approx(0.3 * np.sin(0.1), rel=1e-6)
    assert np.allclose(points(edits.turn_frame(edits.turn_frame(dataset, 0.1), -0.1)), points(dataset))


def test_delayed_motion_starts_at_rest_and_comes_late():
    dataset, late = arc(), edits.delay_motion(arc(), 0.5)
    assert np.allclose(points(late)[:25], points(dataset)[0])
    assert np.allclose(points(late)[25:], points(dataset)[:-25])
    assert np.array_equal(late.trials[0].trajectory.torque, dataset.trials[0].trajectory.torque)


def test_declarations_are_changed_and_the_recording_is_not():
    dataset = arc()
    for edit, amount in ((edits.declare_mass, 0.4), (edits.declare_payload, 0.03), (edits.declare_middle, 0.2)):
        assert np.array_equal(points(edit(dataset, amount)), points(dataset))
    assert edits.declare_mass(dataset, 0.4).mass == pytest.approx(0.12)
    assert edits.declare_payload(dataset, 0.03).trials[0].tip_mass == pytest.approx(0.02)
    assert edits.declare_payload(dataset, 0.3).trials[0].tip_mass == 0.0
    assert [m.arc_length for m in edits.declare_middle(dataset, 0.2).markers] == pytest.approx([0.0, 0.12, 0.3])


def test_every_recipe_has_a_truth_whose_kinds_its_names_are_of():
    assert len(RECIPES) >= 24
    for recipe in RECIPES.values():
        assert recipe.recording in OTHER_KINDS and set(recipe.truth.kinds) <= set(KINDS)
        assert all(kinds_of(name)[0] in recipe.truth.kinds for name in recipe.truth.names)
    assert len({(r.recording, r.trials, r.edit, r.amount) for r in RECIPES.values()}) == len(RECIPES)


def test_amounts_follow_from_the_seed_and_go_either_way_where_that_makes_sense():
    frame, mass = RECIPES["trunk-frame-a"], RECIPES["beam-mass-a"]
    amounts = [drawn_amount(frame, seed) for seed in range(40)]
    assert min(amounts) < 0 < max(amounts) and all(0.9 <= abs(a) / frame.amount <= 1.2 for a in amounts)
    assert all(drawn_amount(mass, seed) > 0 for seed in range(40))
    assert drawn_amount(frame, 3) == drawn_amount(frame, 3)


def test_without_recordings_the_error_names_the_missing_option(tmp_path):
    case = Case("case_001", "real", (next(iter(RECIPES)),), (), "", "", "real-beam", "", 1, "real")
    with pytest.raises(InputError, match="--real"):
        build_real(case, tmp_path / "case_001", None)
    assert not (tmp_path / "case_001").exists()


def test_a_folder_without_them_is_refused_before_anything_is_made(tmp_path, capsys):
    said = run(command, ["make", "--seed", "1", "--real", str(tmp_path), "--tier", "clean=1", "-o", str(tmp_path / "check")])
    assert said == 2 and "real-beam/dataset.toml" in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


def test_pressures_that_are_no_pressures_are_refused(tmp_path):
    (tmp_path / "pressures").mkdir()
    (tmp_path / "pressures" / "trial_01.csv").write_text("t,a\n0,1\n1,2\n")
    with pytest.raises(InputError, match="measured1A"):
        edits.measured_torque(replace(arc(), path=tmp_path))


@needs_recordings
@pytest.mark.parametrize("name", ["beam-payload", "pneumatic-late-a", "pneumatic-command-b", "trunk-markers-a"])
def test_a_real_case_is_a_whole_dataset_that_does_not_reveal_its_source(name, tmp_path):
    case = next(replace(case, name="case_007") for case in plan_real(2, RECORDINGS) if case.effects == (name,))
    answer = build_real(case, tmp_path / "case_007", RECORDINGS)
    made = read_dataset(tmp_path / "case_007")
    assert len(made.trials) == len(RECIPES[name].trials) and made.name == "case_007"
    assert answer.tier == answer.kind == "real" and answer.kinds == (RECIPES[name].truth.kinds,)
    text = "".join(path.read_text() for path in (tmp_path / "case_007").iterdir()).lower()
    assert not [word for word in ("real", "beam", "trunk", "pneumatic", "seed", name, "#  ") if word in text]
    assert sorted(path.name for path in (tmp_path / "case_007").iterdir())[0] == "dataset.toml"


@needs_recordings
def test_measured_pressures_follow_the_command_late():
    recipe = RECIPES["pneumatic-late-a"]
    measured, commanded = reference(recipe, RECORDINGS).trials[0], reference(RECIPES["pneumatic-command-b"], RECORDINGS).trials[0]
    t, half = measured.trajectory.time, 0.5 * commanded.trajectory.torque.max()
    rise = [float(t[np.argmax(trial.trajectory.torque > half)]) for trial in (commanded, measured)]
    assert 0.2 < rise[1] - rise[0] < 1.5


@needs_recordings
def test_all_real_cases_can_be_planned_and_no_other_case_is_one():
    cases = plan_real(5, RECORDINGS)
    assert {case.effects[0] for case in cases} == set(RECIPES) and {case.tier for case in cases} == {"real"}
    assert all(isinstance(case, Case) for case in cases)
