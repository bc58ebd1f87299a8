"""The change hypotheses cover new effects and effects of the reference model."""

import numpy as np

from hsr_pin.diagnosis.change.hypotheses import change_hypotheses
from hsr_pin.effects import EFFECTS
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import part_variants

BIASES = part_variants(EFFECTS["torque_bias"], levels=2, each=(1.11, 2.33))


def test_what_is_new_has_one_size_at_all_levels():
    plain = Hypothesis()
    asked = change_hypotheses(plain, plain.start, BIASES)[2:]
    assert [(each.names, each.open) for each in asked] == [(("torque_bias",), ("torque_bias.bias",))]


def test_what_was_there_with_sizes_of_its_own_at_each_level_may_change_in_all_of_them():
    *_, apart = BIASES
    model = Hypothesis().with_part(apart)
    asked = change_hypotheses(model, np.array([1.0, 1.0, 0.1, -0.2]), BIASES)[2:]
    assert [(each.names, each.open) for each in asked] == [(("torque_bias",), ("torque_bias.bias@1.11", "torque_bias.bias@2.33"))]
