"""What is named: only what is certainly another than it was, and no law with more numbers than are."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.suspects import Suspect
from hsr_pin.diagnosis.change.verdict import BETTER, SECOND, Difference, Found, better, needless, tied, undivided
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.hypothesis import Hypothesis, Part


def size(parameter, step):
    return Size(parameter.partition(".")[0], parameter, "s", 0.0, sum(step) / 2, (0.0, 0.0), step, step)


class Judged(Found):
    """Of changes with given sizes and gains; all explain enough and move the markers."""

    def __init__(self, *changes):
        self.given = {names: (sizes, gain) for names, sizes, gain in changes}
        self.__dict__["sizes"] = {names: sizes for names, (sizes, _) in self.given.items()}
        self.__dict__["frame"] = SimpleNamespace(pair=SimpleNamespace(worth=0.0))
        self.__dict__["fits"] = [(fitted(*names), None) for names in self.given]

    def gain(self, fitted):
        return self.given[fitted.suspect.names][1]

    def needed(self, fitted):
        return 60.0

    def cost(self, fitted):
        return 2000.0 - self.gain(fitted)


def fitted(*names):
    model = Hypothesis()
    for name in names:
        model = model.with_part(Part(name, neutral(EFFECTS[name])))
    return SimpleNamespace(suspect=Suspect(names, model, model.start, ()), rms=1.0)


LAGS = (size("unequal_lag.rise", (-0.05, 0.11)), size("unequal_lag.fall", (-0.03, 0.10)), size("unequal_lag.delay", (0.06, 0.11)))
DELAY = (size("dead_time.delay", (0.07, 0.11)),)


def test_a_change_whose_size_may_be_none_is_not_named():
    for step, there in (((0.01, 0.03), True), ((0.005, 0.035), False), ((-0.01, 0.03), False)):
        found = Judged((("tip_mass",), (size("tip_mass.mass", step),), 1000.0))
        assert found.sure(fitted("tip_mass")) is there


def test_a_step_is_clear_where_its_near_end_is_two_fifths_of_it():
    near, far, down, none = (0.03, 0.05), (0.01, 0.05), (-0.05, -0.03), (-1, 2)
    for step, moved, clear in ((near, True, True), (far, True, False), (down, True, True), (none, False, False)):
        assert (size("tip_mass.mass", step).moved, size("tip_mass.mass", step).clear) == (moved, clear)
    softer = Size("keq_scale", "keq_scale", "1", 1.0, 0.9, (1.0, 1.0), (0.8, 0.98), (0.8, 0.98))
    assert softer.moved and not softer.clear and replace(softer, step=(0.85, 0.95)).clear


def test_two_changes_are_named_only_where_neither_may_be_none():
    for step, there in (((0.01, 0.03), True), ((-0.01, 0.03), False)):
        both = size("marker_offset.offset", step), size("soft_spot.depth", (0.8, 0.9))
        found = Judged((("marker_offset", "soft_spot"), both, 1000.0))
        assert found.sure(fitted("marker_offset", "soft_spot")) is there


@pytest.mark.parametrize("gain, suffices", [(929.0, True), (700.0, False)])
def test_a_law_whose_further_numbers_may_be_none_yields_to_its_special_case_that_explains_as_much(gain, suffices):
    found = Judged((("unequal_lag",), LAGS, 1001.0), (("dead_time",), DELAY, gain))
    assert found.suffices(fitted("dead_time"), fitted("unequal_lag")) is suffices


def test_a_rise_and_a_fall_that_may_be_the_same_are_no_unequal_lag():
    alike = (size("unequal_lag.rise", (0.01, 0.04)), size("unequal_lag.fall", (0.02, 0.05)), LAGS[2])
    found = Judged((("unequal_lag",), alike, 1001.0), (("dead_time",), DELAY, 990.0), (("soft_spot",), (), 990.0))
    assert found.moved(fitted("unequal_lag")) == 3 and found.suffices(fitted("dead_time"), fitted("unequal_lag"))
    assert not found.suffices(fitted("soft_spot"), fitted("unequal_lag"))


def test_it_does_not_where_they_are_certain_nor_to_another_law():
    certain = (size("unequal_lag.rise", (0.05, 0.11)), size("unequal_lag.fall", (-0.03, 0.04)), LAGS[2])
    found = Judged((("unequal_lag",), certain, 1001.0), (("dead_time",), DELAY, 990.0), (("tip_mass",), DELAY, 990.0))
    assert not found.suffices(fitted("dead_time"), fitted("unequal_lag"))
    assert not found.suffices(fitted("tip_mass"), fitted("unequal_lag"))


@pytest.mark.parametrize("more, told", [(1.5, True), (0.5, False)])
def test_a_change_is_not_named_where_one_of_no_certain_size_explains_clearly_more(more, told):
    mass, bend = size("tip_mass.mass", (0.01, 0.03)), size("preset_bend.angle", (-0.03, 0.01))
    found = Judged((("tip_mass",), (mass,), 1000.0), (("preset_bend",), (bend,), 1000.0 * (1 + more * BETTER)))
    other = better(found, fitted("tip_mass"))
    assert (other.suspect.names if other else None) == (("preset_bend",) if told else None)
    both = Judged((("tip_mass",), (mass,), 1000.0), (("preset_bend", "tip_mass"), (mass, bend), 1500.0))
    assert better(both, fitted("tip_mass")) is None  # it has it, and something more


@pytest.mark.parametrize("more, told", [(1.2, False), (0.8, True)])
def test_a_second_change_is_told_only_where_it_explains_a_part(more, told):
    mass, bend = size("tip_mass.mass", (0.01, 0.03)), size("preset_bend.angle", (0.01, 0.03))
    both = ("preset_bend", "tip_mass")
    found = Judged((("tip_mass",), (mass,), 1000.0), (both, (mass, bend), 1000.0 * (1 + more * SECOND)))
    sure = [each for each, _ in found.fits]
    assert [needless(found, each, sure) for each in sure] == [False, told]


@pytest.mark.parametrize("share, told", [(0.95, 1), (0.7, 2)])
def test_a_rival_counts_as_much_as_the_best_fails_to_foretell(share, told):
    """Two hundredths less explained: no reason to choose where three tenths of held-out trials stay unexplained."""

    class Foretold(Judged):
        def difference(self, fitted):
            return Difference(5e-3, 1e-3, 1e-3, share)

        def noisier(self, fitted):
            return 1.0

        def inexact(self, fitted):
            return 0.0

    found = Foretold((("tip_mass",), (), 5000.0), (("dead_time",), (), 4900.0), (("dry_friction",), (), 4000.0))
    best, *others = (
        SimpleNamespace(**vars(fitted(*names)), square=5000 - gain, after=(0.0,)) for names, (_, gain) in found.given.items()
    )
    assert len(tied(found, best, [best, *others])) == told


@pytest.mark.parametrize("after, nearer", [(2.9e-3, True), (3.1e-3, False)])
def test_a_change_that_takes_the_arm_farther_off_in_metres_is_none(after, nearer):
    class Far(Judged):
        def difference(self, fitted):
            return Difference(3e-3, after, 1e-3, 0.9)

    assert Far((("soft_spot",), (), 1000.0)).nearer(fitted("soft_spot")) is nearer


@pytest.mark.parametrize("rival, told", [(510.0, ("torque_bias",)), (490.0, ("torque_bias", "viscoelastic"))])
def test_of_two_changes_one_is_told_where_another_second_one_explains_as_much(rival, told):
    both, other = ("torque_bias", "viscoelastic"), ("hysteresis", "torque_bias")
    found = Judged((("torque_bias",), (), 370.0), (both, (), 500.0), (other, (), rival), (("viscoelastic",), (), 250.0))
    alone, best, _, second = (each for each, _ in found.fits)
    assert undivided(found, best, [alone, best, second]).suspect.names == told
