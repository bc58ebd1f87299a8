"""Synthetic recordings for the indicators, with known errors of the arm; some motions are given without any arm."""

import zlib
from functools import lru_cache

import numpy as np

from hsr_pin.effects import parse_effect
from hsr_pin.identification.experiment import prepare
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

LENGTH = 0.24
STEP = 0.01


def commands():
    """Return steps to both sides and back, a staircase up and down, and a chirp: (T,) [s] and (T,) [N m] each."""
    time = np.arange(0, 3, STEP)
    for size in (0.6, 1.0, -0.8):
        yield time, np.select([time < 0.3 - 1e-9, time < 1.6 - 1e-9], [0.0, size], 0.0)
    time = np.arange(0, 9, STEP)
    stairs = np.array([0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0])
    yield time, stairs[np.minimum((time + 1e-9).astype(int), 8)]
    time = np.arange(0, 8, STEP)
    yield time, 0.5 * (1 - np.cos(2 * np.pi * (0.3 * time + 0.06 * time**2)))


@lru_cache
def commanded(*effects, damping=0.05, noise=3e-4):
    """Return an experiment of an arm with effects, driven by :func:`commands`."""
    arm = ArmSpecification(links=8, placement="mid", keq=1.11, damping=damping)
    laws = tuple(map(parse_effect, effects))
    return _recorded([Scenario(arm, time, torque, Settled(0.0), laws) for time, torque in commands()], effects, noise, True)


@lru_cache
def released(*effects, damping=0.003, noise=1e-4, angles=(0.5, 0.8, 1.1, -0.6, -1.0)):
    """Return an experiment of an arm with effects, released from equilibria under torques."""
    arm = ArmSpecification(links=8, placement="mid", keq=1.11, damping=damping)
    laws, time = tuple(map(parse_effect, effects)), np.arange(0, 3, STEP)
    scenarios = [Scenario(arm, time, np.zeros_like(time), Settled(angle), laws) for angle in angles]
    return _recorded(scenarios, effects, noise, False)


def _recorded(scenarios, effects, noise, has_input):
    generator = np.random.default_rng(zlib.crc32(repr(effects).encode()))
    trials = []
    for number, result in enumerate(simulate_batch(scenarios), 1):
        motion = result.trajectory
        assert len(motion.time) == len(result.scenario.time), result.outcome
        seen = motion.positions + noise * generator.standard_normal(motion.positions.shape)
        recording = Trajectory(motion.time, motion.markers, seen, torque=motion.torque if has_input else None)
        arm = result.scenario.arm
        trials.append(Trial(f"trial_{number}", recording, arm.keq, arm.damping, t_start=None if has_input else 0.0))
    return prepare(Dataset("recorded", LENGTH, 0.15, 0.04, "hanging", tuple(trials)))


def arcs(
    *bendings,
    torques=None,
    step=STEP,
    noise=0.0,
    stretch=0.0,
    sideways=None,
    markers=(0.5, 1.0),
    t_start=0.0,
    seed=0,
    payloads=None,
    mount="hanging",
):
    """Return an experiment of hanging arcs with given bending (T,) [rad] in each trial, without any model."""
    generator = np.random.default_rng(seed)
    trials = []
    for number, bending in enumerate(bendings):
        time = step * np.arange(len(bending))
        places = np.zeros((len(time), len(markers), 3))
        for index, part in enumerate(markers):
            chord = part * LENGTH * (1 + stretch * bending**2) * np.sinc(part * bending / 2 / np.pi)
            places[:, index, 0] = chord * np.sin(part * bending / 2)
            places[:, index, 2] = -chord * np.cos(part * bending / 2)
            places[:, index, 1] = 0.0 if sideways is None else part * sideways[number]
        places += noise * generator.standard_normal(places.shape)
        recording = Trajectory(
            time,
            tuple(Marker(f"at_{part:g}", part * LENGTH) for part in markers),
            places,
            torque=None if torques is None else torques[number],
        )
        payload = 0.0 if payloads is None else payloads[number]
        start = t_start if torques is None else None
        trials.append(Trial(f"trial_{number + 1}", recording, 1.0, 0.05, t_start=start, tip_mass=payload))
    return prepare(Dataset("arcs", LENGTH, 0.15, 0.04, mount, tuple(trials)))


def swing(amplitude, frequency, ratio, duration=4.0, rest=0.0, held=0.0):
    """Return the bending (T,) [rad] of an arm held at ``rest + amplitude`` for ``held`` [s], then oscillating freely."""
    since = np.maximum(STEP * np.arange(round(duration / STEP)) - held, 0.0)
    decay = 2 * np.pi * frequency * ratio / np.sqrt(1 - ratio**2)
    turn = 2 * np.pi * frequency * since
    return rest + amplitude * np.exp(-decay * since) * (np.cos(turn) + decay / (2 * np.pi * frequency) * np.sin(turn))
