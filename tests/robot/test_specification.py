"""The arm is Table I of the paper unless told otherwise, and cannot be made of numbers that no arm has."""

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from hsr_pin.errors import SpecificationError
from hsr_pin.robot.specification import MAX_LINKS, ArmSpecification, default_damping


def test_the_default_is_the_papers_arm():
    arm = ArmSpecification()
    assert (arm.length, arm.diameter, arm.mass, arm.bending_limit) == (0.24, 0.04, 0.15, math.pi)
    assert (arm.links, arm.keq, arm.damping, arm.placement) == (4, 1.11, 0.05, "base")


def test_it_is_frozen():
    with pytest.raises(FrozenInstanceError):
        ArmSpecification().links = 5


@pytest.mark.parametrize("links", [1, 4, 500])
def test_joint_springs_and_dampers_in_series_make_the_whole_arms(links):
    arm = ArmSpecification(links=links)
    assert 1 / sum([1 / arm.joint_stiffness] * links) == pytest.approx(arm.keq, rel=1e-12)
    assert 1 / sum([1 / arm.joint_damping] * links) == pytest.approx(arm.damping, rel=1e-12)


def test_default_damping_goes_through_both_values_of_the_paper():
    assert default_damping(1.11) == pytest.approx(0.05, rel=1e-12)
    assert default_damping(2.33) == pytest.approx(0.1, rel=1e-12)


def test_joints_stand_at_the_base_end_or_in_the_middle_of_their_elements():
    np.testing.assert_allclose(ArmSpecification(links=4).joint_arc_lengths, [0, 0.25, 0.5, 0.75])
    mid = ArmSpecification(links=4, placement="mid")
    np.testing.assert_allclose(mid.joint_arc_lengths, [0.125, 0.375, 0.625, 0.875])
    np.testing.assert_allclose(mid.joint_arc_lengths, mid.element_arc_lengths)


@pytest.mark.parametrize("links", [0, -1, MAX_LINKS + 1, 2.5, 4.0, True, math.nan, "4", None])
def test_links_must_be_a_whole_number_in_range(links):
    with pytest.raises(SpecificationError, match=rf"^links: expected a whole number from 1 to {MAX_LINKS}, got "):
        ArmSpecification(links=links)


@pytest.mark.parametrize("value", [-4.0, math.nan, math.inf, -math.inf, True, "1", None, [1.0]])
@pytest.mark.parametrize("name", ["keq", "damping", "length", "mass", "diameter", "tip_mass", "tilt", "bending_limit"])
def test_a_quantity_must_be_a_number_that_an_arm_can_have(name, value):
    with pytest.raises(SpecificationError, match=rf"^{name}: expected an? ") as caught:
        ArmSpecification(**{name: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["keq", "length", "mass", "diameter", "bending_limit"])
def test_what_must_be_there_cannot_be_zero(name):
    with pytest.raises(SpecificationError, match=rf"^{name}: .*more than zero.*, got 0$"):
        ArmSpecification(**{name: 0})


@pytest.mark.parametrize("name", ["damping", "tip_mass", "tilt"])
def test_what_may_be_absent_can_be_zero(name):
    assert getattr(ArmSpecification(**{name: 0}), name) == 0


@pytest.mark.parametrize(("name", "value"), [("mount", "sideways"), ("mount", None), ("placement", "tip"), ("placement", "BASE")])
def test_a_word_must_be_one_of_those_known(name, value):
    with pytest.raises(SpecificationError, match=rf"^{name}: expected .* or .*, got {value!r}$"):
        ArmSpecification(**{name: value})


def test_a_tilt_is_at_most_half_a_turn():
    with pytest.raises(SpecificationError, match=r"^tilt: expected an angle from -pi to pi rad, got 3\.2$"):
        ArmSpecification(tilt=3.2)
