"""Apparent damping changes from a change of frequency are distinguished from real ones, by the natural frequency."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.diagnosis.change.hypotheses import ChangeHypothesis
from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.swing import apparent_damping_range, natural_frequency
from hsr_pin.diagnosis.change.verdict import ChangeEvidence
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.robot.chain import Arms, chain_of, weight_matrix
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification

from ..made import made

MODEL = Hypothesis(links=40)
HEAVIER = MODEL.with_part(Part("tip_mass", EFFECTS["tip_mass"]()))


@pytest.fixture(scope="module")
def experiment():
    return prepare(made(trials=((1.11, 0.05, (0.5, 0.15)),)))


@pytest.mark.parametrize("mount", ["hanging", "upright"])
def test_what_gravity_makes_stiffer_is_the_slope_of_its_torque(mount):
    arm = ArmSpecification(mount=mount, links=6, tip_mass=0.1)
    model = build_model(arm).model
    slope = pin.computeGeneralizedGravityDerivatives(model, model.createData(), np.zeros(model.nq))
    np.testing.assert_allclose(weight_matrix(chain_of(Arms.of([arm]))), slope, rtol=1e-9, atol=1e-12)


def test_in_space_it_swings_as_in_a_plane_and_a_tilt_to_any_side_makes_it_slower(experiment):
    trials = (replace(trial, trajectory=_to_two_sides(trial.trajectory)) for trial in experiment.dataset.trials)
    space = prepare(replace(experiment.dataset, bending="space", trials=tuple(trials)))
    (flat,), (run,), straight = experiment.runs, space.runs, np.array([1.0, 0.02])
    assert natural_frequency(space, run, MODEL, straight) == pytest.approx(natural_frequency(experiment, flat, MODEL, straight))
    tilted = MODEL.with_part(Part("base_tilt", SPATIAL["base_tilt"]()))
    aside = [natural_frequency(space, run, tilted, np.append(straight, tilt)) for tilt in ((0.5, 0.0), (0.0, 0.5))]
    assert aside[0] == pytest.approx(aside[1])
    assert 0 < aside[0] < 0.999 * natural_frequency(space, run, MODEL, straight)


def _to_two_sides(trajectory):
    return replace(trajectory, torque=np.column_stack([trajectory.torque, 0 * trajectory.torque]))


def test_an_arm_without_weight_swings_as_a_cantilever(experiment):
    light = replace(experiment, dataset=replace(experiment.dataset, mount="horizontal"))
    (run,), arm = light.runs, light.dataset
    cantilever = 1.8751**2 * np.sqrt(run.trial.keq * arm.length / (arm.mass * arm.length**3))
    run.declared.clear()
    assert natural_frequency(light, run, MODEL, np.array([1.0, 1e-3])) == pytest.approx(cantilever, rel=0.02)
    run.declared.clear()


def test_an_arm_that_creeps_does_not_swing_nor_one_that_falls(experiment):
    (run,) = experiment.runs
    assert natural_frequency(experiment, run, MODEL, np.array([1.0, 0.02])) > 0
    assert natural_frequency(experiment, run, MODEL, np.array([1.0, 50.0])) == 0


def _fitted(damping, after):
    change = ChangeHypothesis(
        ("damping_scale", "tip_mass"), HEAVIER, np.array([1.0, damping, 0.0]), ("damping_scale", "tip_mass.mass")
    )
    return SimpleNamespace(change=change, after=np.array(after))


def test_damping_is_free_by_the_square_of_how_much_slower_an_arm_swings(experiment):
    pair = SimpleNamespace(experiment=experiment, old=experiment, new=experiment)
    (run,) = experiment.runs
    was, is_ = (natural_frequency(experiment, run, HEAVIER, np.array([1.0, 0.02, mass])) for mass in (0.0, 0.1))
    assert apparent_damping_range(pair, _fitted(0.02, (0.02, 0.1))) == pytest.approx((1.0, (was / is_) ** 2))
    assert apparent_damping_range(pair, _fitted(0.02, (0.04, 0.0))) == pytest.approx((1.0, 1.0), abs=1e-6)
    assert apparent_damping_range(pair, _fitted(50.0, (50.0, 0.1))) == (1.0, 1.0)


@pytest.mark.parametrize("times", [(0.01,), (3.0,), (0.02, 0.3, 2.0)])
def test_no_sum_of_maxwell_elements_leaves_these_bounds(times):
    w = np.geomspace(0.1, 100, 50)
    c = sum(t / (1 + (w * t) ** 2) for t in times)
    assert (np.diff(c) <= 0).all()
    assert (np.diff(c * w**2) >= 0).all()


@pytest.mark.parametrize("step, said", [((1.1, 1.3), {"tip_mass"}), ((2.9, 3.4), {"damping_scale", "tip_mass"})])
def test_only_damping_beyond_them_is_reported(experiment, step, said, monkeypatch):
    monkeypatch.setattr("hsr_pin.diagnosis.change.verdict.apparent_damping_range", lambda pair, fitted: (1.0, 2.0))
    fitted = _fitted(0.02, (0.03, 0.1))
    sizes = (
        Size("damping_scale", "damping_scale", "1", 0.02, 0.03, (0.02, 0.02), (0.02, 0.04), step),
        Size("tip_mass", "tip_mass.mass", "kg", 0.0, 0.1, (0.0, 0.0), (0.09, 0.11), (0.09, 0.11)),
    )
    found = SimpleNamespace(sizes={fitted.change.names: sizes}, frame=SimpleNamespace(pair=None))
    assert {size.name for size in ChangeEvidence.reported(found, fitted)} == said
