"""A change is described by its two values and its interval."""

from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.words import changes_in_words

LAG = Size("actuator_lag", "actuator_lag.time_constant", "s", 0.09, 0.14, (0.085, 0.095), (0.13, 0.15), (0.042, 0.058))


def test_an_effect_that_grew_is_told_from_what_to_what():
    assert changes_in_words([LAG]) == "actuator_lag.time_constant 0.090 to 0.140 s (by 0.0420 to 0.0580)"


def test_a_number_of_the_arm_is_told_in_percent():
    soft = Size("keq_scale", "keq_scale", "1", 1.1, 1.034, (1.09, 1.11), (1.02, 1.05), (0.93, 0.95))
    assert changes_in_words([soft]) == "stiffness down 6.00 % (5.00 to 7.00 %)"


def test_an_effect_that_came_or_went_is_told_so():
    came = Size("tip_mass", "tip_mass.mass", "kg", 0.0, 0.1, (0.0, 0.0), (0.09, 0.11), (0.09, 0.11))
    assert changes_in_words([came]) == "tip_mass.mass 0.100 kg has appeared (0.090 to 0.110)"
    went = Size("tip_mass", "tip_mass.mass", "kg", 0.1, 0.0, (0.09, 0.11), (0.0, 0.01), (-0.11, -0.09))
    assert changes_in_words([went]) == "tip_mass.mass 0.1000 kg has disappeared"


def test_what_shape_an_effect_came_with_is_no_change():
    shape = Size("hysteresis", "hysteresis.yield_angle", "rad", None, 0.3, None, (0.2, 0.4), None)
    assert changes_in_words([LAG, shape]) == changes_in_words([LAG])
