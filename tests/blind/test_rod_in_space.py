"""The rod in space agrees with closed forms and with the chain of ball joints, with which it shares the laws only."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.blind.in_space import draw
from hsr_pin.blind.plants.space.arm import SpaceArm
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.program import program
from hsr_pin.blind.plants.space.rod import SpaceRodPlant
from hsr_pin.errors import MissingDependencyError

STEP, COUPLE, PULL = program("steps").trials[0], *program("releases").trials[0::2]


def cut(trial, samples):
    """Return the first samples of a trial."""
    return replace(trial, command=trial.command[:samples] if trial.command else (), duration=(samples - 1) / 100)


@pytest.mark.long  # like all tests that run the rod: PyElastica compiles for about a minute at its first use
def test_without_gravity_a_couple_to_any_side_gives_the_arc(engines):
    phi = 0.9 * np.exp(2.2j)
    trial = replace(cut(STEP, 1), command=(STEP.keq * phi,))
    motion = SpaceRodPlant(bare=SpaceArm(g=0.0)).simulate(trial)
    towards = np.array([phi.real, phi.imag]) / 0.9
    place, end = [*(0.24 * (1 - np.cos(0.9)) / 0.9 * towards), 0.24 * np.sin(0.9) / 0.9], [*(np.sin(0.9) * towards), np.cos(0.9)]
    np.testing.assert_allclose(motion.position[0, :, -1], place, atol=1.5e-4)
    np.testing.assert_allclose(motion.frames[0, -1, :, 2], end, atol=2e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("trial", "laws"),
    [
        (STEP, ()),
        (COUPLE, ()),
        (PULL, ()),
        (STEP, ("quadratic_damping",)),
        (STEP, ("hysteresis",)),
        (STEP, ("base_tilt", "tip_mass")),
        (STEP, ("unequal_stiffness", "weak_chamber")),
    ],
)
def test_it_moves_as_the_chain_of_balls_does(trial, laws, engines):
    """The compared point is a marker 3 cm next to the tip, which rotates with it."""
    drawn = [draw(name, np.random.default_rng(1)).scaled(3.0) for name in laws]
    rod, balls = (plant.simulate(cut(trial, 50), drawn) for plant in (SpaceRodPlant(), BallPlant(24, 2e-4)))
    apart = np.linalg.norm(rod.at(0.24, 0.03j) - balls.at(0.24, 0.03j), axis=1)
    assert np.sqrt(np.mean(apart**2)) < 3e-4
    assert np.ptp(balls.position[:, :, -1], axis=0).max() > 0.01


def test_a_missing_engine_names_its_dependency_group(monkeypatch):
    monkeypatch.setitem(sys.modules, "elastica", None)
    with pytest.raises(MissingDependencyError, match="blind"):
        SpaceRodPlant(8).simulate(cut(STEP, 3))
