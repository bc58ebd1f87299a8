"""Recording artefacts have the stated size, and small effects stay small."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

from hsr_pin.blind.background import MAX_ALONE, MAX_COUNT, MAX_TOGETHER, MIN_COUNT, MIN_TOGETHER, background
from hsr_pin.blind.plants.artefacts import Artefacts, messy_nuisance
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.plants.nuisance import Nuisance, noise_floor
from hsr_pin.blind.plants.program import program
from hsr_pin.blind.plants.scaling import GapSimulator

PLANT = ChainPlant(elements=6, step=1e-3)
STILL = np.zeros((4000, 3, 3))


def noise(**artefacts):
    return Artefacts(**artefacts).recorded(STILL, 1e-3, 0.0, np.random.default_rng(0))


def test_drawn_artefacts_keep_to_their_ranges_and_differ():
    drawn = [Artefacts.draw(np.random.default_rng(seed)) for seed in range(300)]
    assert 0.4 < np.mean([artefacts.colour == 0 for artefacts in drawn]) < 0.6
    for name, most in (("drift", 1e-3), ("outliers", 0.01), ("gaps", 0.04), ("rest", 3e-3), ("colour", 0.15)):
        values = [getattr(artefacts, name) for artefacts in drawn]
        assert 0.8 * most < max(values) <= most and min(values) == 0
    levels = [messy_nuisance(np.random.default_rng(seed)).noise for seed in range(300)]
    assert 2e-4 <= min(levels) < 2.2e-4 and 1.1e-3 < max(levels) <= 1.2e-3


@pytest.mark.parametrize("colour", [0.0, 0.05])
def test_noise_has_its_variance_whatever_its_colour(colour):
    seen = noise(colour=colour)
    assert seen.std() == pytest.approx(1e-3, rel=0.05)
    lag = np.mean(seen[1:] * seen[:-1]) / np.mean(seen**2)
    assert lag == pytest.approx(np.exp(-0.01 / 0.05) if colour else 0.0, abs=0.03)


def test_camera_drift_is_slow_and_equal_for_all_markers():
    artefacts = Artefacts(drift=1e-3, seed=3)
    early, late = (artefacts.recorded(STILL, 0.0, clock, np.random.default_rng(0)) for clock in (0.0, 100.0))
    assert np.ptp(early, axis=1).max() == 0
    assert 0 < np.abs(np.diff(early, axis=0)).max() < 2e-6
    assert np.abs(late - early).max() > 2e-4 and max(np.abs(late).max(), np.abs(early).max()) <= 1e-3


def test_outliers_and_gaps_come_as_often_as_said_and_not_at_the_start():
    seen = noise(outliers=0.01, gaps=0.04)
    away = np.linalg.norm(seen, axis=2)
    assert np.mean(away > 8e-3) == pytest.approx(0.01, rel=0.35)
    assert np.mean(np.isnan(away)) == pytest.approx(0.04, rel=0.35)
    assert not np.isnan(away[:10]).any() and away[:10].max() < 8e-3


@pytest.mark.parametrize("mount", ["hanging", "upright"])
def test_every_trial_rests_elsewhere_within_three_millimetres(mount):
    artefacts, steps = Artefacts(rest=2.7e-3, seed=1), program("steps+releases", mount)
    steps = replace(steps, trials=tuple(replace(trial, duration=0.0, command=trial.command[:1]) for trial in steps.trials[:3]))
    with_it, without = (PLANT.watch(steps, laws) for laws in ((artefacts.law(),), ()))
    moved = [float(a[0, 2, 0] - b[0, 2, 0]) for a, b in zip(with_it, without, strict=True)]
    assert len({round(each, 6) for each in moved}) == 3
    assert 1e-4 < max(map(abs, moved)) <= 3e-3
    strongest = replace(artefacts.law(), spread=artefacts.law().spread)
    steps = replace(steps, trials=tuple(replace(steps.trials[0], clock=float(clock)) for clock in range(30)))
    places = np.array([points[0, 2, 0] for points in PLANT.watch(steps, (strongest,))])
    assert 1.5e-3 < np.abs(places).max() <= 3.05e-3


def test_manual_releases_have_different_initial_poses_and_durations():
    asked = program("releases")
    with_release_errors = Artefacts(seed=4).with_release_errors(asked)
    assert len({trial.hold_force for trial in with_release_errors.trials}) == len(with_release_errors.trials)
    assert {trial.release for trial in with_release_errors.trials} == {0.2} and any(
        trial.start_error != 0 for trial in with_release_errors.trials
    )
    trial = replace(with_release_errors.trials[0], duration=0.4, hold_force=4.0, hold_torque=0.0, hold_at=0.7)
    sharp, slow = (PLANT.simulate(replace(trial, release_duration=release_duration)) for release_duration in (0.0, 0.1))
    assert np.allclose(sharp.x[:21], slow.x[:21])  # held until 0.2 s
    assert np.abs(sharp.x[25, -1] - slow.x[25, -1]) > 1e-3
    curvature = np.diff(sharp.angle[0])
    assert np.abs(curvature[-1]) < 0.2 * np.abs(curvature[0])  # the arm hangs freely beyond the holding force


def test_steps_are_left_as_they_are():
    assert Artefacts(seed=4).with_release_errors(program("steps")) == program("steps")


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_small_effects_are_small_alone_and_about_the_noise_together(seed):
    nuisance = Nuisance(noise=5e-4)
    gap_simulator = GapSimulator(program("steps", "upright"), nuisance, PLANT)
    floor = 1e3 * noise_floor(nuisance.noise)
    found = background(np.random.default_rng(seed), ("tip_mass",), gap_simulator, floor)
    names = [law.name for law in found.laws]
    assert MIN_COUNT <= len(names) <= MAX_COUNT and len(set(names)) == len(names)
    assert set(names) <= {*CATALOGUE, *OUTSIDE} - {"tip_mass", "wall"}
    assert max(found.alone) <= MAX_ALONE * 1.01
    assert MIN_TOGETHER <= found.together <= MAX_TOGETHER
    assert gap_simulator.refitted_gap(*found.laws) / floor == pytest.approx(found.together)
