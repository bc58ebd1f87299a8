"""The proposed experiment separates alternatives that can be separated."""

import numpy as np
import pytest

from hsr_pin.diagnosis.next_experiment import INDISTINGUISHABLE, propose
from hsr_pin.effects import EFFECTS
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part

from .made import TRIALS, made

ARM = Hypothesis(links=8)
HEAVIER = (ARM.with_part(Part("mass_scale")), np.array([1.0, 1.0, 1.4]))
LADEN = (ARM.with_part(Part("added_mass", EFFECTS["added_mass"]())), np.array([1.0, 1.0, 0.4 * 0.15]))
TIP = (ARM.with_part(Part("tip_mass", EFFECTS["tip_mass"]())), np.array([1.0, 1.0, 0.03]))


@pytest.fixture(scope="module")
def experiment():
    return prepare(made(trials=TRIALS[1:3], duration=1.0, links=8))


def test_of_laws_that_are_the_same_to_the_arm_none_is_proposed_to_be_told_from_the_other(experiment):
    assert propose(experiment, [HEAVIER, LADEN]) == ()


def test_laws_that_are_the_same_count_as_one_beside_another(experiment):
    three, two = (propose(experiment, rivals) for rivals in ([HEAVIER, LADEN, TIP], [HEAVIER, TIP]))
    assert [each.name for each in three] == [each.name for each in two]
    assert [each.separation for each in three] == pytest.approx([each.separation for each in two], rel=0.02)
    assert three[0].separation > 10 * INDISTINGUISHABLE
    assert list(three) == sorted(three, key=lambda each: -each.separation)
