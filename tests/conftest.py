"""What every test may ask for."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from hsr_pin.effects import parse_effect
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trajectory, Trial

# The same examples at every run: a change is judged by what it changed. New ones: pytest --hypothesis-profile=default
settings.register_profile("repeatable", derandomize=True, print_blob=True)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def shared():
    """The folder of shared recordings and facts beside the repository; the test is skipped where it is absent."""
    folder = Path(__file__).resolve().parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip("needs the folder `shared` beside the repository, which is not there")
    return folder


@pytest.fixture(scope="module")
def script(request):
    """The file of ``scripts/`` that a module of tests names as ``SCRIPT``, imported."""
    name = request.module.SCRIPT
    spec = importlib.util.spec_from_file_location(name, Path(__file__).resolve().parents[1] / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look there
    yield spec.loader.exec_module(module) or module
    del sys.modules[name]


@pytest.fixture(scope="session")
def heavy_tip():
    """A dataset of four short steps of an arm that carries 30 g more at its tip than is declared."""
    generator = np.random.default_rng(5)
    trials = []
    for number, torque in enumerate((0.4, 0.8, -0.6, 1.0), 1):
        scenario = step_scenario(ArmSpecification(links=10, placement="mid"), torque, duration=1.0, step=0.02)
        motion = simulate(replace(scenario, effects=(parse_effect("tip_mass:mass=0.03"),))).trajectory
        seen = motion.positions + 1e-4 * generator.standard_normal(motion.positions.shape)
        recording = Trajectory(motion.time, motion.markers, seen, torque=motion.torque)
        trials.append(Trial(f"trial_{number:02d}", recording, keq=1.11, damping=scenario.arm.damping))
    return Dataset("heavy-tip", 0.24, 0.15, 0.04, "hanging", tuple(trials), description="four <short> steps & a weight")


def pytest_collection_modifyitems(items):
    """The commands of README.md take longest: they begin first, beside all others."""
    items.sort(key=lambda item: item.path.name != "test_readme.py")
