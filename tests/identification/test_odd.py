"""Fits and diagnoses of recordings that read well and make no sense end in a result or in one clear line, without a warning."""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json as diagnosed
from hsr_pin.errors import InputError
from hsr_pin.identification.document import to_json as fitted
from hsr_pin.identification.identify import identify
from hsr_pin.trajectory import Dataset

FREE = (
    ("keq", "damping"),
    ("keq", "damping", "mass", "gain"),
    ("bending_stop",),
    ("actuator_lag", "dead_time"),
    ("keq", "torque_map", "gravity_tilt"),
    ("damping", "soft_spot"),
)
PAIRS = (["actuator_lag", "tip_mass"], ["dry_friction", "torque_bias"], ["marker_offset", "backlash"])


def of_positions(change):
    """A mutation of one trial's positions (T, M, 3)."""

    def mutate(trial, generator):
        changed = np.array(change(trial.trajectory.positions.copy(), generator))
        return replace(trial, trajectory=replace(trial.trajectory, positions=changed))

    return mutate


def of_input(change):
    """A mutation of one trial's torque (T,); releases stay."""

    def mutate(trial, generator):
        torque = trial.trajectory.torque
        if torque is None:
            return trial
        return replace(trial, trajectory=replace(trial.trajectory, torque=np.array(change(torque.copy(), generator))))

    return mutate


def holes(positions, generator):
    positions[generator.random(positions.shape[:2]) < 0.7] = np.nan
    return positions


def unseen(positions, generator):
    positions[:, generator.integers(positions.shape[1])] = np.nan
    return positions


def seen_once(positions, generator):
    positions[1 + generator.integers(8) :: 40] = np.nan
    positions[20:, 1:] = np.nan
    return positions


def swapped(positions, _):
    return positions[:, ::-1]


def leaping(positions, generator):
    positions[generator.integers(len(positions)) :] += 0.1
    return positions


def cut(trial, generator):
    count = int(generator.integers(2, 25))
    t = trial.trajectory
    torque = None if t.torque is None else t.torque[:count]
    return replace(trial, trajectory=replace(t, time=t.time[:count], positions=t.positions[:count], torque=torque))


def at_rate(factor):
    return lambda trial, _: replace(trial, trajectory=replace(trial.trajectory, time=factor * trial.trajectory.time))


MUTATIONS = {
    "torque of other units": of_input(lambda torque, g: torque * 10.0 ** g.integers(-4, 5)),
    "no torque": of_input(lambda torque, g: 0 * torque),
    "even torque": of_input(lambda torque, g: 0 * torque + torque[-1]),
    "torque of noise": of_input(lambda torque, g: torque + g.normal(size=len(torque))),
    "torque backwards": of_input(lambda torque, g: torque[::-1]),
    "still": of_positions(lambda positions, g: 0 * positions + positions[0]),
    "one place": of_positions(lambda positions, g: 0 * positions),
    "noise alone": of_positions(lambda positions, g: 0.05 * g.normal(size=positions.shape)),
    "much noise": of_positions(lambda positions, g: positions + 0.01 * g.normal(size=positions.shape)),
    "no noise": of_positions(lambda positions, g: positions.round(2)),
    "mirrored": of_positions(lambda positions, g: positions * [-1, 1, 1]),
    "upside down": of_positions(lambda positions, g: positions * [1, 1, -1]),
    "turned": of_positions(lambda positions, g: positions[..., [1, 0, 2]]),
    "moved": of_positions(lambda positions, g: positions + 0.02 * g.normal(size=3)),
    "millimetres": of_positions(lambda positions, g: positions * g.choice([1e-3, 1.3, 1e3])),
    "holes": of_positions(holes),
    "unseen marker": of_positions(unseen),
    "seen once": of_positions(seen_once),
    "swapped markers": of_positions(swapped),
    "leaping": of_positions(leaping),
    "cut short": cut,
    "slow clock": at_rate(20.0),
    "fast clock": at_rate(1e-3),
    "soft": lambda trial, g: replace(trial, keq=trial.keq * 10.0 ** g.integers(-3, 0)),
    "hard": lambda trial, g: replace(trial, keq=trial.keq * 10.0 ** g.integers(1, 5)),
    "undamped": lambda trial, g: replace(trial, damping=trial.damping * 10.0 ** g.integers(-6, 0)),
    "overdamped": lambda trial, g: replace(trial, damping=trial.damping * 10.0 ** g.integers(1, 5)),
    "payload": lambda trial, g: replace(trial, tip_mass=10.0 ** g.integers(-6, 2)),
    "late start": lambda trial, g: replace(trial, t_start=float(trial.trajectory.time[g.integers(len(trial.trajectory.time))])),
}


@pytest.fixture(scope="module")
def whole(record):
    """Two steps and a release."""
    return record([(1.11, 0.6), (2.33, 1.5), (1.11, None)], keq=1.1, damping=0.8, seconds=0.6, links=8)


def mutated(whole, seed):
    """One to three changes of one trial or of all, and what they are."""
    generator = np.random.default_rng(seed)
    trials = list(whole.trials[: generator.integers(1, 4)])
    names = generator.choice(list(MUTATIONS), size=generator.integers(1, 4), replace=False)
    for name in names:
        chosen = range(len(trials)) if generator.random() < 0.4 else [int(generator.integers(len(trials)))]
        for k in chosen:
            trials[k] = MUTATIONS[name](trials[k], generator)
    mass, mount = whole.mass * 10.0 ** generator.integers(-1, 2), str(generator.choice(["hanging", "upright", "horizontal"]))
    return Dataset("odd", whole.length, mass, whole.diameter, mount, tuple(trials)), list(names)


def end(whole, seed):
    """How a fit (of two out of three) or a diagnosis ends; what it says is strict JSON."""
    dataset, names = mutated(whole, seed)
    try:
        if seed % 3:
            document = fitted(identify(dataset, free=FREE[seed % len(FREE)], links=4, by_level=seed % 4 == 0))
        else:
            found = diagnose(dataset, effects=PAIRS[seed // 3 % len(PAIRS)], max_effects=1 + seed % 2, links=4, jobs=1)
            document = diagnosed(found)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 1000
        return "refused"
    except Exception as error:
        raise AssertionError(f"seed {seed}: {names}") from error
    json.dumps(document, allow_nan=False)
    return "told"


def test_of_20_odd_recordings_each_ends_in_a_result_or_one_line(whole):
    ends = Counter(end(whole, seed) for seed in range(20))
    assert ends["told"] > 10


@pytest.mark.long
def test_of_600_odd_recordings_each_ends_in_a_result_or_one_line(whole):
    ends = Counter(end(whole, seed) for seed in range(40, 640))
    assert ends["told"] > 300
