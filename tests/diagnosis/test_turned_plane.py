"""A rotated plane of bending is detected and corrected."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.verdict import turned_plane
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.identify import identify
from hsr_pin.identification.plane import plane_of, with_plane_corrected
from hsr_pin.inference.verdict import Verdict
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Dataset, Trajectory, Trial

TIME = np.arange(0, 2, 0.01)
#: The straight arm as a world axis on each mount.
ALONG = {"hanging": 2, "upright": 2, "horizontal": 0}


def rotation(mount, degrees):
    """Return the rotation matrix (3, 3) about the straight arm, from the transverse axis in the plane towards y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix, across = np.eye(3), 2 - ALONG[mount]
    matrix[across, across], matrix[across, 1], matrix[1, across], matrix[1, 1] = c, -s, s, c
    return matrix


def recorded(mount, degrees=0.0, beside=0.0, released=False, noise=1e-4):
    """Return recordings of the declared arm seen in a rotated plane, which passes at this distance [m] from the base."""
    rng = np.random.default_rng(5)
    arm = ArmSpecification(links=8, placement="mid", keq=2.33, damping=0.05, mount=mount)
    torques = [0 * TIME if released else np.where(TIME < 0.2, 0.0, size) for size in (0.5, 0.9, -0.7)]
    starts = [Settled(angle) for angle in (0.5, 0.9, -0.7)] if released else [Settled(0.0)] * 3
    results = simulate_batch([Scenario(arm, TIME, torque, start) for torque, start in zip(torques, starts, strict=True)])
    trials = []
    for k, result in enumerate(results):
        seen = result.trajectory.positions @ rotation(mount, degrees).T + [0.0, beside, 0.0]
        seen = seen + noise * rng.standard_normal(seen.shape)
        motion = Trajectory(TIME, result.trajectory.markers, seen, torque=None if released else torques[k])
        trials.append(Trial(f"trial_{k}", motion, arm.keq, arm.damping, t_start=0.0 if released else None))
    return Dataset("turned", arm.length, arm.mass, arm.diameter, mount, tuple(trials))


@pytest.mark.parametrize("mount", ALONG)
@pytest.mark.parametrize("released", [False, True], ids=["driven", "released"])
def test_a_turned_plane_is_told_and_turned_back(mount, released):
    truth, seen = (prepare(recorded(mount, *turn, released=released)) for turn in ((), (-14.0, 0.02)))
    back, found = with_plane_corrected(seen)
    turn = np.degrees(found.turn.value)
    assert turn == pytest.approx(-14.0, abs=0.3)
    assert f"rotated by {turn:.1f} degrees" in found.sentence and back.notes[-1] == found.sentence
    for run, own in zip(back.runs, truth.runs, strict=True):
        np.testing.assert_allclose(run.measured[..., run.axes], own.measured[..., run.axes], atol=1e-3)
        assert np.nanmax(np.abs(run.trial.trajectory.positions[..., 1] - 0.02)) < 1e-3
        if released:
            np.testing.assert_allclose(run.start_pose[:, run.axes], own.start_pose[:, run.axes], atol=1e-3)
    assert with_plane_corrected(back) == (back, None)


def test_the_declared_plane_and_a_small_turn_are_left_alone():
    for degrees in (0.0, 1.0):
        seen = prepare(recorded("hanging", degrees))
        assert with_plane_corrected(seen) == (seen, None)


def test_a_diagnosis_tells_it_and_its_stiffness_does_not_suffer():
    found = diagnose(recorded("hanging", 20.0), effects=(), jobs=1)
    assert (found.verdict.status, found.verdict.kinds, found.verdict.effects) == ("partly_identified", ("measurement",), ())
    assert found.indicators.named("out_of_plane").plane.sentence in found.verdict.sentence
    fit = found.search.best.fit if found.search else None
    assert fit is not None and fit.named["keq_scale"] == pytest.approx(1.0, abs=0.01)  # 6 % of a chord, seen at an angle
    assert found.indicators.kinds.count("measurement") == 1


def test_a_fit_turns_it_back_and_says_so():
    found = identify(recorded("upright", -20.0))
    assert found.fit.named["keq_scale"] == pytest.approx(1.0, abs=0.01)
    assert any("is rotated by -20" in note or "is rotated by -19.9" in note for note in found.experiment.notes)


def test_a_verdict_that_names_keeps_its_names():
    plane = plane_of(prepare(recorded("upright", 9.0)))
    named = Verdict("identified", ("stiffening",), (), "So it is.", ("elastic",))
    said = turned_plane(named, plane)
    assert (said.status, said.effects, said.kinds) == ("identified", ("stiffening",), ("elastic", "measurement"))
    assert said.sentence.startswith("So it is. ")
    assert turned_plane(named, None) is named
    assert turned_plane(replace(named, status="no_gap", effects=()), plane).status == "partly_identified"
