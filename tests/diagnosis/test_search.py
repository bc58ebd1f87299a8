"""The search fits the models that may be credible, and no others: single causes, pairs, and causes hidden by a first choice."""

import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.identification.part import part_variants
from hsr_pin.inference.search import judged, search, without

from ..inference.fabricated import CALIBRATION
from .fabricated import DATA, FakePool, candidate

GAP = 4e-3
EVERY = [part for kind in EFFECTS.values() for part in part_variants(kind)]


def searched(pool, parts=EVERY, **how):
    return judged(search([candidate(gap=pool.gap(()))], parts, pool, DATA, CALIBRATION, **how), DATA, CALIBRATION)


def test_the_one_effect_that_closes_the_gap_is_found():
    found = searched(FakePool({"": GAP, "dry_friction": 0.0, "hysteresis": 1e-3}))
    assert found.best.names == ("dry_friction",)
    assert [each.names for each in found.path] == [(), ("dry_friction",)]


def test_a_pair_is_found_behind_the_one_of_both_that_does_more():
    pool = FakePool({"": GAP, "dry_friction": 2e-3, "tip_mass": 3e-3, "dry_friction+tip_mass": 0.0})
    found = searched(pool)
    assert found.best.names == ("dry_friction", "tip_mass")
    assert [each.names for each in found.path] == [(), ("dry_friction",), ("dry_friction", "tip_mass")]


def test_no_second_effect_is_tried_where_the_first_leaves_nothing():
    pool = FakePool({"": GAP, "dry_friction": 0.0})
    searched(pool)
    assert not any("+" in key for key in pool.fitted)


def test_nor_beside_a_law_that_explains_less_than_its_numbers_cost():
    pool = FakePool({"": GAP, "dry_friction": 0.999 * GAP})
    searched(pool)
    assert not any("+" in key for key in pool.fitted)


def test_but_beside_one_that_explains_a_part_though_it_is_no_more_probable_than_none():
    pool = FakePool({"": GAP, "dry_friction": 0.93 * GAP, "dry_friction+tip_mass": 0.0}, unseen=())
    assert searched(pool).best.names == ("dry_friction", "tip_mass")


def test_each_cause_of_the_best_stands_against_all_others_beside_the_rest():
    """With the lag, friction is the best second cause, although alone another law explained more."""
    pool = FakePool(
        {"": GAP, "hysteresis": 1.5e-3, "actuator_lag": 2.5e-3, "actuator_lag+hysteresis": 0.6e-3, "actuator_lag+backlash": 0.0},
        unseen=(),
    )
    assert searched(pool).best.names == ("actuator_lag", "backlash")


def test_no_more_causes_are_tried_than_asked_for():
    pool = FakePool({"": GAP, "dry_friction": 2e-3, "dry_friction+tip_mass": 0.0})
    assert searched(pool, max_effects=1).best.names == ("dry_friction",)
    assert searched(FakePool({"": GAP, "dry_friction": 0.0}), max_effects=0).best.names == ()


def test_every_variant_of_a_likely_law_is_fitted():
    pool = FakePool({"": GAP, "gravity_tilt": 0.0})
    searched(pool)
    assert pool.fitted.count("gravity_tilt") == len(part_variants(EFFECTS["gravity_tilt"]))


def test_a_special_case_is_tried_in_place_of_a_law_that_contains_it():
    pool = FakePool(
        {"": GAP, "unequal_lag": 0.0, "actuator_lag": 0.0}, quick_gaps={"": GAP, "unequal_lag": 0.0}, unseen=("actuator_lag",)
    )
    found = searched(pool)
    assert "actuator_lag" in pool.fitted
    assert found.posterior.sets[("actuator_lag",)] > found.posterior.sets.get(("unequal_lag",), 0.0)


def test_every_law_gets_a_quick_fit_beside_the_arm_alone_whatever_a_probe_promises():
    pool = FakePool({"": GAP, "tip_mass": 1e-3, "backlash": 0.0}, unseen=("backlash",))
    assert searched(pool).best.names == ("backlash",)


def test_a_flexible_law_hands_its_probability_to_a_law_of_its_kind_that_does_as_much():
    parts = [*EVERY, *(part for kind in FLEXIBLE.values() for part in part_variants(kind))]
    found = searched(FakePool({"": GAP, "stiffness_profile": 0.0, "stiffness_gradient": 0.1e-3}), parts)
    assert found.best.names == ("stiffness_gradient",)


def test_a_size_for_each_level_gives_way_to_one_size_that_does_as_much():
    parts = [part for kind in EFFECTS.values() for part in part_variants(kind, levels=2, each=(1.11, 2.33))]
    found = searched(FakePool({"": GAP, "gravity_tilt": 0.1e-3, "gravity_tilt@each": 0.0}), parts)
    assert not any(part.levels for part in found.best.fit.hypothesis.parts)
    found = searched(FakePool({"": GAP, "gravity_tilt": 2e-3, "gravity_tilt@each": 0.0}), parts)
    assert all(part.levels for part in found.best.fit.hypothesis.parts)


@pytest.mark.parametrize("name", ["tip_mass", "dry_friction"])
def test_without_a_part_a_fit_starts_from_the_values_of_the_rest(name):
    both = candidate("tip_mass", "dry_friction").fit
    fewer = without(both, name)
    assert name not in {part.name for part in fewer.hypothesis.parts}
    assert {key: value for key, value in both.named.items() if not key.startswith(name)} == fewer.named
