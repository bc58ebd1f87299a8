"""What every test may ask for."""

import importlib.util
import sys
from pathlib import Path

import pytest
from hypothesis import settings

from hsr_pin.effects import parse_effect
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset

from .filmed import filmed

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
    arm, mass = ArmSpecification(links=10, placement="mid"), (parse_effect("tip_mass:mass=0.03"),)
    steps = [step_scenario(arm, torque, duration=1.0, step=0.02, effects=mass) for torque in (0.4, 0.8, -0.6, 1.0)]
    trials = filmed([simulate(step).trajectory for step in steps], 1e-4, 5, (1.11, arm.damping))
    return Dataset("heavy-tip", 0.24, 0.15, 0.04, "hanging", trials, description="four <short> steps & a weight")


def pytest_collection_modifyitems(items):
    """The commands of README.md take longest: they begin first, beside all others."""
    items.sort(key=lambda item: item.path.name != "test_readme.py")
