"""Recordings of arms whose parameters are known: simulated with four times the links that are fitted, and noisy."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

MARKERS = (Marker("base", 0.0), Marker("mid", 0.12), Marker("tip", 0.24))
TRUE_LINKS = 24


def recorded(
    commands,
    *,
    keq=1.0,
    damping=1.0,
    effects=(),
    mount="hanging",
    mass=0.15,
    seconds=1.0,
    noise=3e-4,
    seed=0,
    links=TRUE_LINKS,
    interpolated=False,
):
    """A dataset of arms whose true stiffness and damping are ``keq`` and ``damping`` times what is declared.

    ``commands``: (declared Keq, torque) for each trial, or (declared Keq, None) for a release from a bend of 0.8 rad; a
    torque may be one for each sample. ``keq`` and ``damping`` may be dictionaries by declared Keq.
    """
    time = np.arange(round(seconds / 0.01) + 1) * 0.01
    scenarios = []
    for declared, torque in commands:
        k, c = (factor[declared] if isinstance(factor, dict) else factor for factor in (keq, damping))
        arm = ArmSpecification(
            links=links,
            placement="mid",
            keq=k * declared,
            damping=c * 0.045 * declared,
            mass=mass,
            mount=mount,
            bending_limit=6.0,
        )
        start = Pose(np.full(links, 0.8 / links)) if torque is None else Settled(0.0)
        step = np.where(time < 0.1 - 1e-9, 0.0, 0.0 if torque is None else torque)
        scenarios.append(Scenario(arm, time, step, start, tuple(effects), MARKERS, interpolated))
    generator = np.random.default_rng(seed)
    trials = []
    for number, (result, (declared, torque)) in enumerate(zip(simulate_batch(scenarios), commands, strict=True), 1):
        seen = result.raise_on_failure().trajectory.positions
        seen = seen + noise * generator.normal(size=seen.shape)
        command = None if torque is None else result.trajectory.torque
        trials.append(Trial(f"trial_{number:02d}", Trajectory(time, MARKERS, seen, torque=command), declared, 0.045 * declared))
    return Dataset("known", 0.24, mass, 0.04, mount, tuple(trials))


def with_noise(dataset, make):
    """The dataset with ``make(shape)`` [m] added to the positions of every trial."""

    def moved(trial):
        seen = trial.trajectory.positions
        return replace(trial, trajectory=replace(trial.trajectory, positions=seen + make(seen.shape)))

    return replace(dataset, trials=tuple(moved(trial) for trial in dataset.trials))


STEPS = ((1.11, 0.5), (1.11, 1.0), (2.33, 1.2))


@pytest.fixture(scope="session")
def record():
    """:func:`recorded`."""
    return recorded


@pytest.fixture(scope="session")
def add_noise():
    """:func:`with_noise`."""
    return with_noise


@pytest.fixture(scope="session")
def steps():
    """Three steps at two stiffness levels; true factors 1.1 on Keq, 0.8 on C."""
    return recorded(STEPS, keq=1.1, damping=0.8)
