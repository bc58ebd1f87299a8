"""Scatter and direction of equilibrium poses are recovered."""

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.rests import _side, rests

from .recorded import LENGTH, STEP, arcs, swing


def let_go(rest_of_side, sides, scatter=0.0):
    """Return an experiment of releases from some sides, with equilibria displaced towards them [rad] and random scatter."""
    generator = np.random.default_rng(4)
    noise = scatter * generator.standard_normal(len(sides))
    return arcs(
        *(swing(side * 0.5, 2.0, 0.2, rest=side * rest_of_side + off) for side, off in zip(sides, noise, strict=True)), noise=5e-5
    )


def test_rests_towards_either_side_are_friction():
    found = rests(let_go(0.04, [1, 1, 1, -1, -1, -1]))
    assert found.towards.value == pytest.approx(0.02 * LENGTH, rel=0.05)  # a chord turns by half the bending
    assert found.kinds == ("friction",) and not found.one_sided


def test_from_one_side_only_a_bent_arm_looks_the_same():
    found = rests(let_go(0.04, [1] * 5))
    assert found.one_sided and found.kinds == ("friction", "mass_gravity")
    assert "all trials come from one side" in found.sentence


def test_random_rests_are_no_direction():
    found = rests(let_go(0.0, [1, -1] * 6, scatter=0.04))
    assert found.scatter == pytest.approx(0.02 * LENGTH, rel=0.5)
    assert not found.directed and "measurement" in found.kinds


def test_rests_alike_point_to_nothing():
    found = rests(let_go(0.0, [1, -1] * 3))
    assert found.kinds == () and "where it should" in found.sentence


def test_a_shift_between_trials_is_none_of_the_motion():
    time = STEP * np.arange(400)
    torque = np.where((time > 1) & (time < 2.5), 1.0, 0.0)
    experiment = arcs(*(0.5 * torque + shift for shift in (-0.1, 0.0, 0.05, 0.12)), torques=[torque] * 4, noise=5e-5)
    assert rests(experiment).kinds == ("measurement",)


def test_an_arm_that_still_moves_does_not_rest():
    assert rests(arcs(*[swing(0.5, 2.0, 0.01, duration=1.0)] * 4)) is None


def test_a_rest_of_which_the_end_was_not_seen_came_from_no_known_side():
    """Such a rest occurs in a release of 38 samples without most of its values."""
    assert _side(0, float("nan"), 0.03, ()) == 0
    assert [_side(0, rest, 0.03, ()) for rest in (0.01, 0.05)] == [1, -1]
