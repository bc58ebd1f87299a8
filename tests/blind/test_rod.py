"""The PyElastica plant agrees with closed forms and with the MuJoCo plant, with which it shares the laws only."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from hsr_pin.blind.plants.arm import Arm
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws.actuation import ActuatorLag, TorqueDecay, TorqueMap
from hsr_pin.blind.plants.laws.dissipative import DampingGradient, DryFriction, Hysteresis, QuadraticDamping, Viscoelastic
from hsr_pin.blind.plants.laws.elastic import Backlash, BendingStop, SoftSpot, Stiffening, StiffnessGradient
from hsr_pin.blind.plants.laws.mounting import AddedMass, GravityTilt, TipMass
from hsr_pin.blind.plants.laws.outside import BaseShake, TipGust, Wall
from hsr_pin.blind.plants.program import Trial, program
from hsr_pin.blind.plants.rod import RodPlant
from hsr_pin.errors import EffectError, MissingDependencyError

from .motions import tip_rms

KEQ, C = 1.11, 0.05


def step_to(tau: float, duration: float, keq: float = KEQ) -> Trial:
    return Trial(keq, 0.045 * keq, duration, (0.0,) * 2 + (tau,) * (round(100 * duration) - 1))


@pytest.mark.long  # like all tests that run the rod: PyElastica compiles for about a minute at its first use
def test_without_gravity_a_uniform_moment_gives_the_arc(engines):
    phi = 0.9
    trial = Trial(KEQ, C, 0.0, (KEQ * phi,))
    motion = RodPlant(16, 5e-5, Arm(g=0.0)).simulate(trial)
    assert motion.x[0, -1] == pytest.approx(0.24 * (1 - np.cos(phi)) / phi, abs=1e-4)
    assert motion.z[0, -1] == pytest.approx(0.24 * np.sin(phi) / phi, abs=1e-4)


@pytest.mark.long
def test_a_step_moves_it_as_it_moves_the_chain(engines):
    trial = step_to(1.0, 0.2)
    assert tip_rms(RodPlant(16).simulate(trial), ChainPlant().simulate(trial)) < 0.3


def test_laws_of_contact_are_refused():
    with pytest.raises(EffectError, match="chain plant"):
        RodPlant(8).simulate(step_to(0.5, 0.02), (Wall(0.2),))


@pytest.mark.parametrize(("package", "plant"), [("mujoco", ChainPlant(8)), ("elastica", RodPlant(8))])
def test_a_missing_engine_names_its_dependency_group(package, plant, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependencyError, match="blind"):
        plant.simulate(step_to(0.5, 0.02))


LAWS = [
    (),
    (ActuatorLag(0.05),),
    (TorqueDecay(0.4),),
    (TorqueMap(0.15),),
    (DampingGradient(1.0),),
    (DryFriction(0.06),),
    (DryFriction(0.06, "prandtl"),),
    (Hysteresis(0.4),),
    (QuadraticDamping(0.02),),
    (QuadraticDamping(0.02, "drag"),),
    (Viscoelastic(0.4, 0.3),),
    (Backlash(0.1),),
    (BendingStop(0.5, 2.0),),
    (SoftSpot(0.4, 0.5, 0.1),),
    (Stiffening(0.1),),
    (StiffnessGradient(-0.8),),
    (AddedMass(0.05),),
    (GravityTilt(0.2),),
    (TipMass(0.05),),
    (BaseShake(0.01),),
    (TipGust(0.5),),
]


@pytest.mark.long
@pytest.mark.parametrize("laws", LAWS, ids=lambda laws: "+".join(law.name for law in laws) or "none")
def test_under_every_law_both_plants_agree(engines, laws):
    trial = step_to(1.0, 0.5)
    rod, chain = RodPlant().simulate(trial, laws), ChainPlant().simulate(trial, laws)
    assert tip_rms(rod, chain) < 0.3
    if laws:
        assert tip_rms(chain, ChainPlant().simulate(trial)) > 0.3


@pytest.mark.long
def test_over_whole_trials_both_plants_agree(engines):
    for trial in program("steps+releases").trials[2:5]:
        assert tip_rms(RodPlant().simulate(trial), ChainPlant().simulate(trial)) < 0.3
