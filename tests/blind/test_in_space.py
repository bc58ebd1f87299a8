"""Cases of arms in space: laws about two axes act as described, and cases are planned, recorded and answered like others."""

import numpy as np
import pytest

from hsr_pin.blind.in_space import PROGRAMS, ROD_PROGRAMS, SHARES, draw, plan_in_space
from hsr_pin.blind.kinds import kinds_of
from hsr_pin.blind.plants.laws.law import Joints, State
from hsr_pin.blind.plants.nuisance import Nuisance
from hsr_pin.blind.plants.space.arm import SpaceArm
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.plants.space.program import program
from hsr_pin.blind.plants.space.writing import MARKERS
from hsr_pin.blind.tiers import by_shares, plan
from hsr_pin.blind.workshop import Workshop, build
from hsr_pin.effects import effect_named
from hsr_pin.errors import EffectError
from hsr_pin.recordings.read import read_dataset

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

COARSE = BallPlant(elements=8, step=1e-3)
TURN = np.exp(0.9j)
#: Laws with their own direction.
DIRECTED = {"unequal_stiffness", "bend_at_rest", "weak_chamber", "torque_offset", "supply_ripple"}


def random(*shape):
    generator = np.random.default_rng(7)
    return generator.normal(size=shape) + 1j * generator.normal(size=shape)


@pytest.mark.parametrize("name", [*CATALOGUE, *OUTSIDE])
def test_a_law_has_a_kind_and_a_name_that_diagnoses_know(name):
    assert kinds_of(name)
    if name in CATALOGUE:
        assert effect_named(name)


@pytest.mark.parametrize("name", sorted({*CATALOGUE, *OUTSIDE} - DIRECTED))
def test_a_rotated_state_gives_a_rotated_moment(name):
    law = draw(name, np.random.default_rng(1))
    joints = Joints(np.linspace(0.1, 0.9, 5), 1.0, np.ones(5))
    memory, bend, rate = law.memory(joints) * 0.1 * random(5), random(5), random(5)
    answers = []
    for turn in (1.0, TURN):
        state = State(turn * bend, turn * rate, 0.3, 1e-3, 5.0, 0.0, False)
        answers.append(np.concatenate([np.atleast_2d(part) for part in law.moment(joints, state, turn * memory)]))
        tau = turn * np.repeat(random(4), 10)
        answers[-1] = answers[-1].ravel(), law.command(tau, np.arange(40) * 0.01, 1.0, 0.0), law.viscous(joints, state)
    for plain, turned in zip(answers[0][:2], answers[1][:2], strict=True):
        np.testing.assert_allclose(turned, TURN * plain, atol=1e-12)
    np.testing.assert_allclose(answers[1][2], answers[0][2], atol=1e-12)


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_law_of_another_size_is_still_that_of_space(name):
    law = draw(name, np.random.default_rng(1))
    assert type(law) is type(law.scaled(0.5)) is CATALOGUE[name]


def test_a_chain_of_balls_is_bent_into_an_arc_by_a_couple():
    arm = BallPlant(elements=24, step=4e-4, bare=SpaceArm(g=0.0))
    trial = program("steps", keq=1.11).trials[0]
    motion = arm.simulate(trial)
    phi, way = trial.torque()[100] / 1.11, motion.position[125, :, -1]
    size = abs(phi)
    across, along = 0.24 * (1 - np.cos(size)) / size, 0.24 * np.sin(size) / size
    np.testing.assert_allclose(way, [across * (phi / size).real, across * (phi / size).imag, along], atol=2e-4)


def test_a_marker_off_the_backbone_rotates_with_its_section():
    motion = BallPlant(elements=12, step=1e-3, bare=SpaceArm(g=0.0)).simulate(program("steps").trials[1])
    tip, side = motion.at(0.24), motion.at(0.24, 0.03j)
    np.testing.assert_allclose(np.linalg.norm(side - tip, axis=1), 0.03, atol=1e-9)
    np.testing.assert_allclose(np.einsum("ti,ti->t", side - tip, motion.frames[:, -1, :, 2]), 0.0, atol=1e-9)


def test_gravity_falls_where_the_base_is_tilted_to():
    arm = SpaceArm(tilt=0.1, side_tilt=-0.2)
    np.testing.assert_allclose(arm.frame(seen=True) @ arm.gravity(), [0.0, 0.0, -9.81], atol=1e-12)
    away = arm.frame(seen=True)[:, 2] - np.array([0.0, 0.0, -1.0])
    assert away[0] == pytest.approx(0.1, abs=5e-3) and away[1] == pytest.approx(
        0.2, abs=5e-3
    )  # y of a hanging base is -y of the world


def test_a_plan_is_balanced_and_asked_for_by_name():
    cases = plan_in_space(np.random.default_rng(3), 60)
    assert {case.tier for case in cases} == {"space"} and {case.program for case in cases} == {*PROGRAMS}
    kinds = [case.kind for case in cases]
    assert {kind: kinds.count(kind) for kind in SHARES} == {"single": 42, "none": 8, "outside": 10}
    named = [case.effects[0] for case in cases if case.kind == "single"]
    assert {*named} == {*CATALOGUE} and max(map(named.count, named)) <= 3
    rods = [case for case in cases if case.plant == "space_rod"]
    assert len(rods) == 10 and {case.program for case in rods} <= {*ROD_PROGRAMS} and {"single"} < {case.kind for case in rods}
    assert {case.plant for case in cases} == {"balls", "space_rod"} < {*Workshop().plants}
    assert [case.tier for case in plan(1, {"space": 3})] == ["space"] * 3
    assert by_shares(300)["space"] == 0
    with pytest.raises(EffectError, match="law: expected"):
        draw("wall", np.random.default_rng(0))


def test_a_case_is_a_recording_of_version_two_that_does_not_reveal_its_law(tmp_path):
    wanted = ("tip_mass",), "balls"
    case = next(case for case in plan_in_space(np.random.default_rng(4), 60) if (case.effects, case.plant) == wanted)
    workshop = Workshop(plants={"balls": COARSE}, measured_in_space=COARSE)
    answer = build(case, tmp_path / "case_001", workshop)
    text = (tmp_path / "case_001" / "dataset.toml").read_text()
    assert "format = 2" in text and "tip_mass = 0.0" not in text and "law" not in text
    dataset = read_dataset(tmp_path / "case_001")
    assert dataset.bending == "space" and [m.name for m in dataset.markers] == [m.name for m in MARKERS]
    assert dataset.torsion == dataset.trials[0].keq and dataset.markers[-1].radius == 0.03
    assert answer.effects == ("tip_mass",) and answer.tier == "space" and answer.facts["reached"] == [True]


def test_a_recording_follows_from_its_seed(tmp_path):
    made = [COARSE.run(program("releases"), (), 3, tmp_path / f"{k}", Nuisance(noise=1e-4), MARKERS) for k in range(2)]
    first, second = ((folder / "trial_03.csv").read_text() for folder in made)
    assert first == second and "tau" not in first.splitlines()[0]
