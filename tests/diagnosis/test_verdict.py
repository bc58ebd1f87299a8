"""Every verdict is reached by what should lead to it, and by nothing less."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.confidence import NAME, probability
from hsr_pin.diagnosis.rivals import rivals, without_companions
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.support import Support
from hsr_pin.diagnosis.thresholds import clearly_worse, explains
from hsr_pin.diagnosis.traces import mostly_explained
from hsr_pin.diagnosis.verdict import CERTAIN, CERTAIN_KIND, STATUSES, Evidence, _plainly_there, judge
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.hypothesis import Part

from .fabricated import THRESHOLDS, candidate

GAP = 4e-3
BASE = candidate(gap=GAP)
LENGTH = 0.24


def support(name, kind, weak=(), fair=()):
    """What a true law has, or, where the name is weak, a stand-in, or a fair one whose rivals are near."""
    if {name, kind} & set(fair):
        return Support(name, kind, 0.3, 0.3, 1.0, 1.0, 0.05, 40.0, 0.2)
    if not {name, kind} & set(weak):
        return Support(name, kind, 0.9, 0.9, 100.0, 1.0, 0.01, 100.0, 0.02)
    return Support(name, kind, 0.1, 0.1, 0.2, 0.7, 0.3, 5.0, 0.2)


def verdict(
    *tried, base=BASE, nominal=6e-3, by_level=None, not_repeatable=None, thresholds=THRESHOLDS, together_sure=False, **how
):
    """With the last of the fitted models as the best."""
    path = (base, tried[-1]) if tried else (base,)
    parts = tuple(support(part.name, part.kind, **how) for part in path[-1].fit.hypothesis.parts)
    kinds = tuple(support(kind, kind, **how) for kind in path[-1].kinds)

    def together(sets):
        return support("", "", () if together_sure else ("",))

    evidence = Evidence(nominal**2, parts, kinds, together, LENGTH, not_repeatable, by_level, 0)
    return judge(Search(path, (base, *tried)), thresholds, evidence)


def test_a_declared_model_within_the_noise_has_no_gap():
    found = verdict(base=candidate(gap=0.0), nominal=0.9 * THRESHOLDS.closed)
    assert (found.status, found.effects, found.alternatives) == ("no_gap", (), ())
    assert verdict(base=candidate(gap=0.0), nominal=1.1 * THRESHOLDS.closed).status == "parameters"


def test_a_gap_that_stiffness_and_damping_close_is_one_of_parameters():
    found = verdict(base=candidate(gap=0.5 * THRESHOLDS.closed))
    assert (found.status, found.effects, found.alternatives) == ("parameters", (), ())
    assert "keq_scale" in found.sentence and "6.00 mm" in found.sentence


def test_a_small_rest_that_no_effect_is_worth_having_for_is_still_one_of_parameters():
    assert verdict(base=candidate(gap=1.5 * THRESHOLDS.closed)).status == "parameters"


def test_a_gain_that_closes_the_gap_is_one_of_parameters_and_a_drift_is_missing_physics_without_a_name():
    gain = verdict(candidate("torque_gain"))
    assert (gain.status, gain.effects, gain.kinds) == ("parameters", (), ("actuation_map",))
    assert gain.sentence.startswith("Another gain of the torque (torque_gain) explains it: with it 100 % of")
    drift = verdict(candidate("keq_drift"))
    assert (drift.status, drift.effects, drift.kinds) == ("partly_identified", (), ("elastic",))
    assert drift.sentence.startswith("A stiffness that changes over the session (keq_drift) explains it: with it 100 % of")


def test_a_large_rest_that_no_effect_is_worth_having_for_is_unexplained():
    found = verdict()
    assert (found.status, found.effects, found.alternatives) == ("unexplained", (), ())
    assert "4.00 mm" in found.sentence and "no effect" in found.sentence


def test_of_a_rest_that_stays_the_certain_part_is_named_and_how_much_is_left_is_told():
    found = verdict(
        candidate("tip_mass", gap=3e-3), candidate("stiffening", "tip_mass", gap=2e-3), weak=("tip_mass", "mass_gravity")
    )
    assert (found.status, found.effects, found.kinds) == ("partly_identified", ("stiffening",), ("elastic",))
    assert "stiffening is certain, though something else is left" in found.sentence and "2.00 mm" in found.sentence
    assert found.left.rms == pytest.approx(2e-3, rel=1e-3) and found.left.share == pytest.approx(0.25, rel=1e-3)
    assert found.confidence["stiffening"] > 0.9 > 0.5 > found.confidence["tip_mass"]


def test_no_cause_is_certain_where_most_of_the_gap_is_left_unless_that_does_not_repeat():
    best = candidate("stiffening", gap=3.2e-3)  # 64 % of the squared gap
    assert (verdict(best).effects, verdict(best).kinds) == ((), ("elastic",))
    assert verdict(best, thresholds=replace(THRESHOLDS, unrepeatable=2.5e-3)).effects == ("stiffening",)


def test_the_few_models_next_to_the_best_are_told_beside_it_where_it_is_likely_and_little_is_left():
    names = ("stiffness_gradient", "elastic")
    near = (candidate("torque_decay", gap=1.5e-3), candidate("stiffness_gradient", gap=1.2e-3))
    found = verdict(candidate("tip_mass", gap=3.9e-3), *near, fair=names)
    assert (found.status, found.alternatives) == ("ambiguous", (("stiffness_gradient",), ("torque_decay",)))
    many = [candidate(name, gap=1.55e-3) for name in ("tip_mass", "backlash", "viscoelastic")]
    assert len(verdict(*many, *near, fair=names).alternatives) == 3
    far = (candidate("torque_decay", gap=2.4e-3), candidate("stiffness_gradient", gap=2.1e-3))  # 28 % of the squared gap
    assert verdict(*far, fair=names).status == "unexplained"
    assert verdict(*near, weak=names).status == "unexplained"
    # none is likely by itself, as the others are near; that it is one of them is sure
    found = verdict(*near, weak=names, together_sure=True)
    assert (found.status, found.effects, len(found.alternatives)) == ("ambiguous", (), 2)
    assert verdict(*far, weak=names, together_sure=True).status == "unexplained"


def test_a_best_that_is_likely_and_has_nothing_near_it_is_told_alone():
    best = candidate("bending_stop", gap=0.8e-3)
    found = verdict(best, fair=("bending_stop", "elastic"))
    assert (found.status, found.effects, found.alternatives) == ("ambiguous", (), (("bending_stop",),))
    assert 0.75 <= found.confidence["bending_stop"] < CERTAIN
    assert found.sentence.startswith("bending_stop may be missing from the model")
    assert verdict(best, weak=("bending_stop", "elastic")).status == "unexplained"
    assert verdict(candidate("bending_stop", gap=2.2e-3), fair=("bending_stop", "elastic")).status == "unexplained"  # 30 % left
    pair = candidate("bending_stop", "tip_mass", gap=0.8e-3)
    assert verdict(pair, fair=("bending_stop", "elastic"), weak=("tip_mass", "mass_gravity")).alternatives == ()


def test_the_flexible_law_of_another_kind_that_does_as_well_is_an_alternative_where_nothing_is_sure():
    soft, other = candidate("soft_spot", gap=1.2e-3), candidate("torque_profile", gap=1.25e-3)
    unsure = {"weak": ("soft_spot", "elastic"), "together_sure": True}
    assert verdict(other, soft, **unsure).alternatives == (("soft_spot",), ("torque_profile",))
    assert verdict(candidate("stiffness_profile", gap=1.25e-3), soft, **unsure).status == "unexplained"  # the same kind
    assert verdict(candidate("torque_profile", gap=2.2e-3), soft, **unsure).status == "unexplained"  # clearly worse
    named = verdict(candidate("torque_decay", gap=1.25e-3), other, soft, **unsure)
    assert named.alternatives == (("soft_spot",), ("torque_decay",))  # that kind is told by its name
    many = [candidate(name, gap=1.22e-3) for name in ("tip_mass", "dry_friction", "viscoelastic")]
    assert verdict(*many, other, soft, **unsure).alternatives[-1] == ("torque_profile",)  # however many causes do as well


def test_a_kind_is_named_where_no_cause_is_certain():
    found = verdict(candidate("stiffening", gap=1e-3), weak=("stiffening",))
    assert (found.status, found.effects, found.kinds) == ("partly_identified", (), ("elastic",))
    assert "something of the kind elastic" in found.sentence


def test_a_kind_is_told_beside_a_certain_cause_of_another_kind():
    found = verdict(candidate("stiffening", "tip_mass", gap=1e-3), weak=("tip_mass",))
    assert (found.effects, found.kinds) == (("stiffening",), ("elastic", "mass_gravity"))
    assert "stiffening, and something of the kind mass_gravity (mass and gravity) are certain" in found.sentence
    assert "kind" not in verdict(candidate("stiffening", gap=2e-3)).sentence


def test_the_flexible_law_of_a_kind_is_never_named():
    found = verdict(candidate("elastic_curve"))
    assert (found.status, found.effects, found.kinds) == ("partly_identified", (), ("elastic",))
    assert "elastic_curve" not in found.confidence
    assert "certain, in a form that has no name here; with elastic_curve 100 %" in found.sentence
    assert "something else is left" in verdict(candidate("elastic_curve", gap=2e-3)).sentence


def test_of_a_kind_that_is_certain_the_laws_with_a_name_that_come_closest_are_told():
    laws = (candidate("bending_stop", gap=5e-4), candidate("stiffening", gap=8e-4), candidate("backlash", gap=2.5e-3))
    others = (candidate("torque_map", gap=4e-4), candidate("backlash", "stiffening", gap=4e-4), candidate("elastic_curve"))
    found = verdict(*laws, *others)
    assert (found.status, found.effects, found.kinds) == ("partly_identified", (), ("elastic",))
    assert found.alternatives == (("bending_stop",), ("stiffening",))  # no other kind, none far from these, no more parts
    assert found.sentence.endswith("Of the laws that have a name bending_stop, or stiffening come closest.")
    assert verdict(*laws[2:], *others).alternatives == (("backlash",),)
    beside = verdict(candidate("stiffening", "tip_mass", gap=1e-3), weak=("tip_mass", "mass_gravity", "stiffening"))
    assert (beside.kinds, beside.alternatives) == (("elastic",), (("stiffening",),))  # the mass is not sure, nor is its kind


def test_companions_that_are_open_are_no_causes_beside_a_kind_that_is_certain():
    weak = ("viscoelastic", "creep", "tip_mass", "mass_gravity", "quadratic_damping", "torque_bias", "actuation_map")
    rivals = (candidate("damping_gradient", "torque_bias", gap=2.01e-3), candidate("quadratic_damping", "tip_mass", gap=2.005e-3))
    found = verdict(*rivals, candidate("quadratic_damping", "viscoelastic", gap=2e-3), weak=weak)
    assert (found.status, found.effects, found.kinds) == ("partly_identified", (), ("damping",))
    assert found.alternatives == (("quadratic_damping",), ("damping_gradient",))
    assert found.sentence.endswith("Of the laws that have a name quadratic_damping, or damping_gradient come closest.")


def test_a_companion_that_all_alternatives_share_stays_though_its_kind_is_not_certain():
    weak = ("unequal_lag", "actuation_time", "marker_offset")
    rival = candidate("length_change", "unequal_lag", gap=2.01e-3)
    found = verdict(rival, candidate("marker_offset", "unequal_lag", gap=2e-3), weak=weak)
    assert (found.effects, found.kinds) == ((), ("measurement",))
    assert found.alternatives == (("marker_offset", "unequal_lag"), ("length_change", "unequal_lag"))


def test_nor_is_a_companion_of_the_one_alternative_that_has_a_name_a_cause():
    best = candidate("friction_spectrum", "marker_profile", gap=2e-3)
    found = verdict(candidate("hysteresis", "soft_spot", gap=2.01e-3), best, weak=("marker_profile", "measurement"))
    assert (found.effects, found.kinds, found.alternatives) == ((), ("friction",), (("hysteresis",),))
    assert found.sentence.endswith("Of the laws that have a name hysteresis comes closest.")


def test_what_is_certain_is_no_alternative_to_itself_beside_other_companions():
    best, weak = candidate("stiffening", "tip_mass", gap=2e-3), ("tip_mass", "mass_gravity")
    found = verdict(candidate("stiffening", "torque_bias", gap=2.01e-3), best, weak=weak)
    assert (found.status, found.effects, found.kinds, found.alternatives) == (
        "partly_identified",
        ("stiffening",),
        ("elastic",),
        (),
    )
    more = candidate("backlash", "stiffening", gap=2.01e-3)  # nor with more of its kind, which another does without
    assert verdict(more, best, weak=weak).alternatives == ()


def test_of_a_certain_name_with_companions_of_its_kind_none_is_said_to_come_closest():
    rival = candidate("soft_spot", "stiffening", gap=2.01e-3)
    found = verdict(rival, candidate("backlash", "stiffening", gap=2e-3), weak=("backlash",))
    assert (found.effects, found.kinds) == (("stiffening",), ("elastic",))
    assert found.alternatives == (("backlash", "stiffening"), ("soft_spot", "stiffening"))
    assert "closest" not in found.sentence


def test_the_flexible_law_of_a_kind_is_no_alternative():
    found = verdict(
        candidate("bending_stop", gap=2e-3), candidate("stiffening", gap=2.01e-3), candidate("elastic_curve", gap=1.9e-3)
    )
    assert (found.status, found.kinds) == ("partly_identified", ("elastic",)) and "with elastic_curve 77 %" in found.sentence
    assert found.alternatives == (("bending_stop",), ("stiffening",))


def test_a_simpler_law_that_leaves_next_to_nothing_is_a_rival():
    last = candidate("soft_spot", gap=0.3 * THRESHOLDS.closed)
    for gap, sets in ((0.95, (("soft_spot",), ("stiffness_gradient",))), (1.2, ())):
        other = candidate("stiffness_gradient", gap=gap * THRESHOLDS.closed)
        assert clearly_worse(other, last, THRESHOLDS, 0)
        assert verdict(other, last).alternatives == sets
    slope = candidate("stiffness_gradient", gap=0.3 * THRESHOLDS.closed)
    assert verdict(candidate("soft_spot", gap=0.95 * THRESHOLDS.closed), slope).alternatives == ()


def test_a_rest_of_which_nothing_is_certain_is_unexplained_and_the_best_is_not_offered_where_it_hardly_helps():
    found = verdict(candidate("tip_mass", gap=2e-3), weak=("tip_mass", "mass_gravity"))
    assert (found.status, found.effects, found.kinds, found.alternatives) == ("unexplained", (), (), ())
    assert "tip_mass) is not certain" in found.sentence
    hardly = verdict(candidate("tip_mass", gap=3.8e-3), weak=("tip_mass", "mass_gravity"))
    assert "a fifth" in hardly.sentence and "tip_mass" not in hardly.sentence


def test_how_far_the_arm_is_from_itself_is_handed_on():
    assert verdict(candidate("tip_mass", gap=2e-3), not_repeatable=1.5e-3).left.not_repeatable == 1.5e-3


@pytest.mark.parametrize("effects", [("dry_friction",), ("actuator_lag", "tip_mass"), ("backlash", "tip_mass", "torque_bias")])
def test_effects_that_close_the_gap_are_identified(effects):
    found = verdict(candidate(*effects))
    assert (found.status, found.effects, found.alternatives) == ("identified", effects, ())
    assert all(name in found.sentence for name in effects)
    assert "100 %" in found.sentence


def test_an_effect_that_closes_the_gap_without_support_is_not_identified():
    assert verdict(candidate("tip_mass"), weak=("tip_mass", "mass_gravity")).status == "unexplained"
    assert verdict(candidate("tip_mass"), weak=("tip_mass",)).effects == ()


def test_an_effect_that_closes_the_gap_with_an_amplitude_hardly_pinned_down_is_not_identified():
    found = verdict(candidate("stiffening", "bending_stop", errors={"bending_stop": 5}), weak=("bending_stop",))
    assert (found.status, found.effects) == ("partly_identified", ("stiffening",))
    assert verdict(candidate("stiffening", "bending_stop", errors={"bending_stop": 12})).status == "identified"


def test_a_rival_is_named_beside_the_best_though_its_amplitude_is_hardly_pinned_down():
    found = verdict(candidate("hysteresis", errors={"hysteresis": 5}), candidate("dry_friction"))
    assert found.alternatives == (("dry_friction",), ("hysteresis",))


def test_two_effects_that_explain_alike_are_ambiguous_the_better_first():
    found = verdict(candidate("hysteresis", gap=0.02e-3), candidate("dry_friction"))
    assert (found.status, found.effects) == ("ambiguous", ())
    assert found.alternatives == (("dry_friction",), ("hysteresis",))
    assert found.sentence.endswith("dry_friction, or hysteresis.")


def test_alternatives_are_listed_from_the_best_to_the_worst():
    tried = [candidate(name, gap=gap) for name, gap in (("backlash", 2.4e-5), ("stiffening", 0.8e-5), ("hysteresis", 1.6e-5))]
    found = verdict(*tried, candidate("dry_friction"))
    assert found.alternatives == (("dry_friction",), ("stiffening",), ("hysteresis",), ("backlash",))


def test_a_rival_that_leaves_a_little_more_than_explains_the_gap_is_told_if_it_is_not_clearly_worse():
    best, near = candidate("dry_friction", gap=0.65e-3), candidate("hysteresis", gap=0.75e-3)  # 2.6 and 3.5 % of the squared gap
    assert explains(best, BASE, THRESHOLDS) and not explains(near, BASE, THRESHOLDS)
    assert verdict(near, best).alternatives == (("dry_friction",), ("hysteresis",))


def test_no_law_is_certain_that_is_led_by_nothing_however_clear_its_size():
    clear = Support("tip_mass", "mass_gravity", 0.9, 0.9, 0.9, 1.0, 0.0, 1e4, 0.0)
    assert probability(clear, NAME) > CERTAIN
    for margin, named in ((0.9, ()), (1.1, ("tip_mass",))):
        one = candidate("tip_mass")
        evidence = Evidence(
            36e-6, (replace(clear, margin=margin),), (replace(clear, margin=margin),), lambda sets: clear, LENGTH, None, None, 0
        )
        assert judge(Search((BASE, one), (BASE, one)), THRESHOLDS, evidence).effects == named


def test_what_all_alternatives_share_is_certain():
    found = verdict(candidate("hysteresis", "tip_mass"), candidate("dry_friction", "tip_mass"))
    assert (found.status, found.effects) == ("ambiguous", ("tip_mass",))
    assert found.alternatives == (("dry_friction", "tip_mass"), ("hysteresis", "tip_mass"))
    assert found.sentence.startswith("tip_mass is certain")


@pytest.mark.parametrize("second", ["mass_gravity", "friction"])
def test_of_alternatives_that_close_the_gap_only_that_is_told_of_which_name_or_kind_is_certain(second):
    tried = candidate("hysteresis", "tip_mass", gap=0.01e-3), candidate("dry_friction", "tip_mass")
    masses = {"tip_mass", "mass_gravity"}
    weak = masses if second == "mass_gravity" else {"dry_friction", "friction"}
    found = verdict(*tried, weak=weak)
    if weak == masses:
        assert (found.status, found.alternatives) == ("ambiguous", (("dry_friction",), ("hysteresis",)))
        assert found.kinds == ("friction",) and "beside it is something smaller" in found.sentence
    else:
        assert (found.status, found.effects, found.alternatives) == ("partly_identified", ("tip_mass",), ())
        assert found.kinds == ("mass_gravity",) and found.sentence.startswith(
            "tip_mass is certain; with dry_friction and tip_mass"
        )
    beside = candidate("backlash", "bending_stop", gap=0.01e-3), candidate("bending_stop", "torque_bias")
    by_name = _plainly_there([each.names for each in tried], {"tip_mass"}, Search((BASE, tried[1]), (BASE, *tried)))
    assert by_name == [("tip_mass",)]  # whatever is known of its kind
    nested = verdict(*beside, weak={"torque_bias", "actuation_map"})
    assert nested.alternatives == (("bending_stop", "torque_bias"), ("backlash", "bending_stop"))
    both = verdict(*tried, weak=masses | {"dry_friction", "friction"})
    assert both.alternatives == (("dry_friction", "tip_mass"), ("hysteresis", "tip_mass"))


@pytest.mark.parametrize(("lead", "clear", "certain"), [(0.1, 30.0, False), (0.2, 30.0, True), (0.1, 300.0, True)])
def test_a_kind_that_takes_little_away_beside_another_is_certain_from_more_on(lead, clear, certain):
    second = Support("damping", "damping", lead, lead, 3.0, 1.0, 0.3, clear, 0.1)
    best = candidate("damping_curve", "tip_mass", gap=1.2e-3)
    first = [replace(support(name, "mass_gravity"), rest=0.1) for name in ("tip_mass", "mass_gravity")]
    evidence = Evidence(
        36e-6, (first[0], replace(second, name="damping_curve")), (first[1], second), lambda sets: second, LENGTH, None, None, 0
    )
    found = judge(Search((BASE, best), (BASE, best)), THRESHOLDS, evidence)
    assert found.confidence["damping"] > CERTAIN_KIND and (found.confidence["damping"] > CERTAIN) is (clear > 100)
    assert ("damping" in found.kinds) is certain and "mass_gravity" in found.kinds
    closed = candidate("damping_curve", "tip_mass")
    assert ("in a form" in judge(Search((BASE, closed), (BASE, closed)), THRESHOLDS, evidence).sentence) is certain
    alone = replace(evidence, kinds=(second,))
    assert "damping" in judge(Search((BASE, best), (BASE, best)), THRESHOLDS, alone).kinds


def test_the_kind_of_a_certain_name_is_certain():
    best = candidate("damping_gradient", "tip_mass")
    sure = support("tip_mass", "mass_gravity"), support("damping_gradient", "damping")
    weak = Support("damping", "damping", 0.1, 0.1, 3.0, 1.0, 0.3, 30.0, 0.1)  # beside another kind less than certain by itself
    evidence = Evidence(36e-6, sure, (support("mass_gravity", "mass_gravity"), weak), lambda sets: sure[0], LENGTH, None, None, 0)
    found = judge(Search((BASE, best), (BASE, best)), THRESHOLDS, evidence)
    assert (found.status, found.kinds) == ("identified", ("damping", "mass_gravity"))
    assert found.confidence["damping"] < CERTAIN


def test_a_rival_that_is_clearly_worse_leaves_the_name_clear():
    assert verdict(candidate("hysteresis", gap=0.5e-3), candidate("dry_friction")).status == "identified"


def test_a_rival_that_is_worse_in_one_trial_alone_stays():
    worse = candidate("hysteresis", gap=(0.5e-3, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not clearly_worse(worse, candidate("dry_friction"), THRESHOLDS, 0)
    assert verdict(worse, candidate("dry_friction")).status == "ambiguous"


def test_a_rival_is_none_that_leaves_the_gap_open_or_has_an_idle_part_or_needs_more_effects():
    best = candidate("dry_friction", "torque_bias", gap=0.5e-3)
    alone = candidate("backlash", gap=0.5e-3)
    tried = (
        BASE,
        candidate("hysteresis", gap=1.5e-3),  # a seventh of the squared gap
        candidate("backlash", "viscoelastic", gap=0.5e-3, errors={"viscoelastic": 1}),
        candidate("backlash", "tip_mass", "soft_spot"),
        best,
    )
    assert rivals(best, BASE, tried, THRESHOLDS, 0, True) == []
    assert rivals(best, BASE, (*tried, alone), THRESHOLDS, 0, True) == [("backlash",)]


def test_a_part_of_no_clear_size_is_not_idle_where_much_more_is_left_without_it():
    best = candidate("dry_friction", "torque_bias", gap=0.5e-3)
    pair = candidate("backlash", "viscoelastic", gap=0.5e-3, errors={"viscoelastic": 1})
    tried = (BASE, candidate("backlash", gap=2e-3), pair, best)
    assert rivals(best, BASE, tried, THRESHOLDS, 0, True) == [("backlash", "viscoelastic")]


def test_a_law_that_contains_the_best_is_no_rival_of_it():
    best, wider = candidate("actuator_lag"), candidate("unequal_lag")
    assert rivals(best, BASE, (best, wider), THRESHOLDS, 0, True) == []
    assert rivals(wider, BASE, (best, wider), THRESHOLDS, 0, True) == [("actuator_lag",)]


def test_a_size_for_each_level_is_no_rival_of_a_law_that_does_the_same_with_fewer_numbers():
    apart = candidate(Part("preset_bend", neutral(EFFECTS["preset_bend"]), levels=(1.11, 2.33)))
    few, more = candidate("torque_bias"), candidate("bending_stop")
    assert rivals(few, BASE, (few, apart), THRESHOLDS, 0, True) == []
    assert rivals(few, BASE, (few, candidate("preset_bend")), THRESHOLDS, 0, True) == [("preset_bend",)]
    assert rivals(more, BASE, (more, apart), THRESHOLDS, 0, True) == [("preset_bend",)]


def test_two_readings_of_one_law_are_no_rivals():
    kinds = [candidate("gravity_tilt", gap=gap) for gap in (0.0, 0.01e-3)]
    assert verdict(*kinds).status == "identified"


def test_stiffness_that_differs_between_levels_is_parameters_where_no_effect_does_better():
    levels = candidate(gap=0.0)
    found = verdict(candidate("tip_mass", gap=2e-3), by_level=levels)
    assert (found.status, found.effects) == ("parameters", ())
    found = verdict(candidate("tip_mass", gap=0.9e-3), by_level=levels)
    assert found.status == "parameters"


def test_stiffness_that_differs_between_levels_is_a_rival_where_an_effect_does_as_well():
    found = verdict(candidate("tip_mass"), by_level=candidate(gap=0.0))
    assert (found.status, found.effects, found.alternatives) == ("ambiguous", (), (("tip_mass",), ()))
    assert "at each level" in found.sentence


def test_an_effect_that_does_better_than_stiffness_at_each_level_is_identified():
    assert verdict(candidate("tip_mass"), by_level=candidate(gap=1e-3)).status == "identified"


def test_a_large_gap_is_not_explained_where_far_more_than_noise_is_left():
    assert verdict(candidate("tip_mass", gap=4.9 * THRESHOLDS.closed), base=candidate(gap=16e-3)).status == "identified"
    assert verdict(candidate("tip_mass", gap=5.5 * THRESHOLDS.closed), base=candidate(gap=16e-3)).status == "partly_identified"


def test_shares_and_rests_in_the_sentence_are_those_of_the_models():
    found = verdict(candidate("tip_mass", gap=0.5e-3))
    assert f"{100 * (1 - 1 / 64):.0f} %" in found.sentence
    assert "0.50 mm" in found.sentence


def test_the_same_seed_gives_the_same_verdict():
    tried = (candidate("hysteresis", gap=tuple(np.linspace(0, 0.3e-3, 6))), candidate("dry_friction"))
    assert verdict(*tried) == verdict(*tried)


def test_every_status_but_that_of_too_few_data_is_reached_here():
    reached = {
        verdict(nominal=0.0).status,
        verdict(base=candidate()).status,
        verdict().status,
        verdict(candidate("tip_mass")).status,
        verdict(candidate("tip_mass", gap=2e-3)).status,
        verdict(candidate("added_mass"), candidate("tip_mass")).status,
    }
    assert reached == set(STATUSES) - {"insufficient", "unchanged"}


def test_a_gap_is_mostly_explained_if_any_model_takes_half_of_its_square_or_all_that_repeats():
    open_, half = candidate("tip_mass", gap=0.75 * GAP), candidate("backlash", gap=0.65 * GAP)

    def explained(*tried, thresholds=THRESHOLDS):
        return mostly_explained(Search((BASE,), (BASE, *tried)), thresholds)

    assert not explained() and not explained(open_)
    assert explained(open_, half)
    assert explained(open_, thresholds=replace(THRESHOLDS, unrepeatable=0.4 * GAP))


@pytest.mark.parametrize("alone, ends_at", [(1.0e-3, ("stiffening",)), (1.3e-3, ("stiffening", "viscoelastic"))])
def test_of_a_small_companion_is_not_asked_which_law_it_is(alone, ends_at):
    """Of what both take away it takes 3 %, or 7 %."""
    best, rival = candidate("stiffening", "viscoelastic", gap=0.75e-3), candidate("dead_time", "stiffening", gap=0.76e-3)
    tried = BASE, candidate("stiffening", gap=alone), best, rival
    assert without_companions(best, BASE, tried, THRESHOLDS, 0).names == ends_at
    assert without_companions(best, BASE, tried[:-1], THRESHOLDS, 0) is best  # no other law does what it does


def test_a_rival_that_is_part_of_the_best_stands_for_it():
    best, other = candidate("torque_bias", "unequal_lag", gap=1.0e-3), candidate("actuator_lag", "preset_bend", gap=1.0e-3)
    part = candidate("unequal_lag", gap=1.1e-3)
    assert without_companions(best, BASE, (BASE, part, best, other), THRESHOLDS, 0) is part


def test_of_a_small_companion_is_not_asked_though_the_law_beside_it_has_a_rival_too():
    best = candidate("added_mass", "stiffness_gradient", gap=0.75e-3)
    rivals = candidate("added_mass", "soft_spot", gap=0.76e-3), candidate("stiffness_gradient", "tip_mass", gap=0.76e-3)
    alone = candidate("stiffness_gradient", gap=0.9e-3)
    assert without_companions(best, BASE, (BASE, alone, best, *rivals), THRESHOLDS, 0) is alone


@pytest.mark.parametrize(
    ("alone", "rival", "ends_at"),
    [
        (0.6e-3, 0.59e-3, ("tip_mass",)),  # without the flexible law the other mass does as well
        (0.6e-3, 2.0e-3, ("marker_profile", "tip_mass")),  # it does not
        (0.8e-3, 0.79e-3, ("marker_profile", "tip_mass")),  # too much is left without it
        (1.4e-3, 1.39e-3, ("marker_profile", "tip_mass")),  # the flexible law takes a tenth of what both do
    ],
)
def test_a_flexible_law_that_takes_little_tells_no_name_from_another(alone, rival, ends_at):
    best = candidate("marker_profile", "tip_mass", gap=0.3e-3)
    tried = BASE, candidate("tip_mass", gap=alone), candidate("added_mass", gap=rival), best
    assert without_companions(best, BASE, tried, THRESHOLDS, 0).names == ends_at
    named = candidate("marker_offset", "tip_mass", gap=0.3e-3)
    assert without_companions(named, BASE, (*tried[:-1], named), THRESHOLDS, 0) is named
    of_another_kind = candidate("backlash", gap=rival)
    assert without_companions(best, BASE, (*tried[:2], of_another_kind, best), THRESHOLDS, 0) is best


def test_a_second_law_without_which_much_is_left_stays_though_which_it_is_is_open():
    best = candidate("added_mass", "dead_time", gap=0.2e-3)
    rivals = candidate("mass_scale", "unequal_lag", gap=0.21e-3), candidate("dead_time", "mass_scale", gap=0.21e-3)
    for alone, ends_at in ((0.8e-3, ("added_mass", "dead_time")), (0.6e-3, ("dead_time",))):
        tried = BASE, candidate("dead_time", gap=alone), best, *rivals
        assert without_companions(best, BASE, tried, THRESHOLDS, 0).names == ends_at


def test_a_flexible_law_is_no_answer_in_place_of_a_pair_of_which_a_rival_has_neither():
    best, rival = candidate("marker_profile", "torque_bias", gap=0.1e-3), candidate("gravity_tilt", "preset_bend", gap=0.1e-3)
    alone = candidate("marker_profile", gap=0.5e-3), candidate("torque_bias", gap=0.6e-3)
    assert without_companions(best, BASE, (BASE, *alone, best, rival), THRESHOLDS, 0) is alone[1]
    assert without_companions(best, BASE, (BASE, *alone[:1], best, rival), THRESHOLDS, 0) is best
