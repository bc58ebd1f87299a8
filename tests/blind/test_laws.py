"""Every law of the plants is neutral at zero, moves the arm otherwise, and agrees with its source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

from hsr_pin.blind.plants import laws
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws.actuation import ActuatorLag, DeadTime
from hsr_pin.blind.plants.laws.dissipative import DryFriction, Hysteresis, QuadraticDamping, Viscoelastic
from hsr_pin.blind.plants.laws.elastic import StiffnessGradient
from hsr_pin.blind.plants.laws.law import Joints, State
from hsr_pin.blind.plants.laws.mounting import GravityTilt
from hsr_pin.blind.plants.laws.outside import Wall
from hsr_pin.blind.plants.program import Program, program
from hsr_pin.errors import EffectError

TRIAL = replace(program().trials[2], command=(0.0,) * 5 + (1.0,) * 36, duration=0.4)
SHORT = Program("hanging", (TRIAL,))
PLANT = ChainPlant(elements=8, step=5e-4)
JOINTS = Joints(np.array([0.5]), 1.0, np.array([1.0]))


def watched(*effects, program=SHORT):
    return PLANT.watch(program, effects)[0]


def bent(bend: float, rate: float, dt: float = 1e-3, rest: bool = False) -> State:
    return State(np.array([bend]), np.array([rate]), 0.0, dt, 0.0, 0.0, rest)


def test_the_catalogue_holds_nineteen_and_outside_is_apart():
    assert len(laws.CATALOGUE) == 19
    assert len(laws.OUTSIDE) >= 5
    assert not set(laws.CATALOGUE) & set(laws.OUTSIDE)


@pytest.mark.parametrize("name", [*laws.CATALOGUE, *laws.OUTSIDE])
def test_a_neutral_law_is_the_nominal_plant_and_a_drawn_one_is_not(name):
    law = laws.draw(name, np.random.default_rng(3))
    nominal = watched()
    assert np.allclose(watched(law.scaled(0.0)), nominal, rtol=0, atol=1e-12)
    if name not in ("wall", "gravity_tilt"):  # as drawn, they are too far away or too weak
        assert np.abs(watched(law) - nominal).max() > 1e-5
    assert np.all(np.isfinite(watched(law.scaled(1e6))))


@pytest.mark.parametrize(
    "law",
    [
        DryFriction(0.1, "prandtl"),
        DryFriction(0.1, breakaway=1.2),
        Hysteresis(0.5, form="iwan"),
        QuadraticDamping(0.02, "drag"),
        GravityTilt(0.1, "frame"),
        Wall(0.22),
    ],
)
def test_the_other_forms_move_the_arm_too(law):
    assert np.abs(watched(law) - watched()).max() > 5e-4


def test_a_form_that_does_not_exist_is_refused():
    with pytest.raises(EffectError, match="lugre or prandtl"):
        DryFriction(0.1, "coulomb")


def test_both_forms_of_friction_agree_on_the_path_and_stick():
    path = [0.0] * 5 + [1.0] * 30 + [0.95] * 30
    trial = replace(TRIAL, command=tuple(path), duration=0.64)
    lugre, prandtl = (watched(DryFriction(0.1, form), program=Program("hanging", (trial,))) for form in ("lugre", "prandtl"))
    assert np.abs(lugre - prandtl).max() < 1.5e-3
    assert np.abs(lugre[-1] - lugre[34])[-1].max() < 4e-4  # a small step back does not release the friction


def test_friction_slides_at_its_level_whatever_the_rate():
    law, z = DryFriction(0.1), np.zeros(1)
    for rate in (0.1, 1.0, 30.0):
        for _ in range(2000):
            moment, z = law.moment(JOINTS, bent(0.0, rate), z)
        assert moment[0] == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("form", ["bouc_wen", "iwan"])
def test_a_hysteresis_loop_closes_takes_energy_and_knows_no_rate(form):
    law = Hysteresis(0.5, 0.1, form=form)

    def loop(dt: float) -> tuple[float, float]:
        memory, work, ends = law.memory(JOINTS), 0.0, []
        bend = 0.4 * np.sin(np.linspace(0, 6 * np.pi, 6001))
        for k, step in enumerate(np.diff(bend)):
            moment, memory = law.moment(JOINTS, bent(bend[k], step / dt, dt), memory)
            if k >= 4000:
                work += moment[0] * step
            if k % 2000 == 1999:
                ends.append(moment[0])
        assert ends[-1] == pytest.approx(ends[-2], rel=1e-2)
        return work, moment[0]

    assert loop(1e-3)[0] > 0
    assert loop(1e-3) == pytest.approx(loop(1e-4))


def test_a_maxwell_branch_relaxes_exponentially_and_is_relaxed_at_rest():
    law, anchor = Viscoelastic(0.3, 0.5), np.zeros(1)
    for _ in range(500):
        moment, anchor = law.moment(JOINTS, bent(1.0, 0.0), anchor)
    assert moment[0] == pytest.approx(0.3 * np.exp(-0.5 / 0.5))
    assert law.moment(JOINTS, bent(1.0, 0.0, rest=True), np.zeros(1))[0][0] == 0.0


def test_lag_and_dead_time_are_exact_for_held_commands():
    t = np.arange(-100, 1000) * 1e-4
    step = np.where(t >= 0, 1.0, 0.2)
    lagged = ActuatorLag(0.02).command(step, t, 1.0, 0.0)
    after = t > 1e-4
    assert np.allclose(lagged[after], 1 - 0.8 * np.exp(-t[after] / 0.02), atol=1e-9)
    late = DeadTime(0.01234).command(step, t, 1.0, 0.0)
    assert np.sum(1.0 - late[t >= 0]) * 1e-4 == pytest.approx(0.8 * 0.01234)


def test_a_gradient_keeps_the_compliance_of_the_whole():
    s = (np.arange(1000) + 0.5) / 1000
    assert np.mean(1 / StiffnessGradient(1.2).stiffness(s)) == pytest.approx(1.0, rel=1e-5)


def test_the_two_forms_of_tilt_differ_by_a_turn_of_the_picture():
    mount, frame = watched(GravityTilt(0.2)), watched(GravityTilt(0.2, "frame"))
    c, s = np.cos(0.2), np.sin(0.2)
    x, z = frame[..., 0], frame[..., 2]
    assert np.allclose(mount[..., 0], c * x - s * z, atol=1e-12)
    assert np.allclose(mount[..., 2], s * x + c * z, atol=1e-12)


def test_a_wall_holds_the_arm_off():
    assert watched(Wall(0.22))[:, 2, 0].max() == pytest.approx(0.3 - 0.22 - 0.02, abs=2e-3)
