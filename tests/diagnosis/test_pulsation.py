"""A periodic disturbance is distinguished from what follows the command, and a pulsating torque from a pulsating stiffness."""

import numpy as np
import pytest

from hsr_pin.diagnosis.pulsation import Pulsation, wave

STEP = 0.02
TORQUES = (0.3, 0.8, -0.5, 1.0, 0.6)


def bending(torque, samples=120):
    """Return the bending of an arm that oscillates after a step."""
    t = np.arange(samples) * STEP
    return torque * (1 - np.exp(-4 * t) * np.cos(9 * t))


def runs(missing, samples=120, seed=0):
    """Return runs with the missing torque ``missing(k, t, bending)`` and noise."""
    t, rng = np.arange(samples) * STEP, np.random.default_rng(seed)
    bends = [bending(torque, samples) for torque in TORQUES]
    return [(missing(k, t, bend) + 0.003 * rng.normal(size=samples), bend) for k, bend in enumerate(bends)]


def saw(k, t, frequency=2.3):
    """Return a sawtooth wave with a different phase in every trial."""
    return (frequency * t + 0.37 * k**2) % 1.0 - 0.5


@pytest.mark.parametrize(
    ("missing", "kind"),
    [
        (lambda k, t, bend: 0.05 * saw(k, t), "actuation_map"),
        (lambda k, t, bend: 0.08 * saw(k, t) * bend, "elastic"),
        (lambda k, t, bend: 0.08 * bend**3, ""),
        (lambda k, t, bend: 0.05 * np.gradient(bend, STEP), ""),
        (lambda k, t, bend: 0.05 * saw(k, t, 1.5 + 0.4 * k), ""),
        (lambda k, t, bend: 0.05 * saw(k, t) + 0.07 * bend**3, ""),
        (lambda k, t, bend: 0.05 * ((t > 0.6) & (t < 1.0)), ""),
        (lambda k, t, bend: 0.05 * ((t > 0.6) & (t < 1.0)) * np.sign(bend[-1]), ""),
        (lambda k, t, bend: 0.05 * saw(0, t), "actuation_map"),
        (lambda k, t, bend: 0.05 * ((t - 0.25 * k) % 1.6 < 0.4), "actuation_map"),
        (lambda k, t, bend: 0 * t, ""),
    ],
    ids=[
        "supply",
        "stiffness",
        "spring",
        "damping",
        "another frequency in every trial",
        "beside much else",
        "a push in every trial",
        "a push that goes with the bending",
        "supply that starts with every trial",
        "slow supply",
        "noise",
    ],
)
def test_what_pulses_is_told_and_what_follows_the_arm_is_not(missing, kind):
    found = wave(runs(missing), STEP)
    assert found.kind == kind
    assert bool(found.sentence) == bool(kind)
    if kind:
        assert min(abs(found.frequency - true) for true in (2.3, 1 / 1.6)) < 0.1


def test_a_wave_that_may_be_either_is_of_no_kind():
    assert [Pulsation(2.0, added, elastic).kind for added, elastic in ((0.7, 0.68), (0.7, 0.5), (0.5, 0.7))] == [
        "",
        "actuation_map",
        "elastic",
    ]


def test_chance_is_not_predicted():
    """A wave of six coefficients explains a share of any data that it is fitted to, but predicts nothing."""
    rng = np.random.default_rng(3)
    found = wave([(rng.normal(size=40), bending(torque, 40)) for torque in TORQUES[:3]], STEP)
    assert max(found.added, found.elastic) < 0.16


def test_two_trials_or_short_ones_tell_nothing():
    pulsing = runs(lambda k, t, bend: 0.05 * saw(k, t))
    assert wave(pulsing[:2], STEP) is None
    assert wave([(missing[:6], bend[:6]) for missing, bend in pulsing], STEP) is None
