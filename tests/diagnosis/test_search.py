"""The search keeps an effect only for a gain that is both certain and worth having, and drops what others made needless."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.search import BEAM, key, search
from hsr_pin.diagnosis.thresholds import Thresholds, mean_square, worth_having
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.identification.hypothesis import Part, readings

from .fabricated import LENGTH, NOISE, THRESHOLDS, FakeCrew, candidate

GAP = 4e-3
EVERY = [part for kind in EFFECTS.values() for part in readings(kind)]


def searched(crew, parts=EVERY, **how):
    return search(candidate(gap=crew.gap(())), parts, THRESHOLDS, crew, **how)


def names(candidates):
    return [each.names for each in candidates]


def test_the_one_effect_that_closes_the_gap_is_found():
    found = searched(FakeCrew({"": GAP, "dry_friction": 0.0, "hysteresis": 1e-3}))
    assert names(found.path) == [(), ("dry_friction",)]
    assert found.best is found.path[-1]
    assert ("hysteresis",) in names(found.tried)


def test_a_law_that_a_probe_does_not_show_is_tried_where_one_that_it_contains_is_promising():
    gaps = {"": GAP, "actuator_lag": 3e-3, "unequal_lag": 0.0}
    assert searched(FakeCrew(gaps, unseen=("unequal_lag",)), max_effects=1).best.names == ("unequal_lag",)
    other = {"": GAP, "tip_mass": 3e-3, "unequal_lag": 0.0}
    assert searched(FakeCrew(other, unseen=("unequal_lag",)), max_effects=1).best.names == ("tip_mass",)


@pytest.mark.parametrize("together", [0.0, 0.5e-3])
def test_a_law_whose_numbers_may_be_those_of_its_special_cases_together_gives_way_to_them(together, monkeypatch):
    gaps = {"": GAP, "tip_mass": 3e-3, "actuator_lag": 2.5e-3, "unequal_lag": 2e-3, "tip_mass+unequal_lag": 0.0}
    crew = FakeCrew(gaps | {"tip_mass+actuator_lag": 1e-3, "tip_mass+actuator_lag+dead_time": together})
    both = ("actuator_lag", "dead_time", "tip_mass")  # whose rise and fall are the same, as all that was fabricated is
    assert searched(crew).best.names == (("tip_mass", "unequal_lag") if together else both)
    assert searched(crew, max_effects=2).best.names == ("tip_mass", "unequal_lag")  # no more than were asked for
    monkeypatch.setattr("hsr_pin.diagnosis.search.alike", lambda fit, part: False)
    assert searched(crew).best.names == ("tip_mass", "unequal_lag")


@pytest.mark.parametrize(("other", "found"), [(0.9 * GAP, "backlash"), (0.85 * GAP, "tip_mass")])
@pytest.mark.parametrize("stuck", [{}, {"backlash": 0.95 * GAP}], ids=["at once", "from neutral"])
def test_laws_that_a_probe_does_not_show_are_looked_at_where_none_that_it_shows_takes_a_quarter(other, found, stuck):
    crew = FakeCrew({"": GAP, "tip_mass": other, "backlash": 0.0}, unseen=("backlash",), stuck=stuck)
    assert searched(crew, max_effects=1).best.names == (found,)


def test_nor_does_one_keep_them_from_a_look_that_takes_more_and_is_not_worth_having():
    scattered = (0.3 * GAP,) * 4 + (1.4 * GAP,) * 2  # 0.71 of the squared gap, and worse in two trials
    even = (np.sqrt(np.mean(np.square(scattered))),) * 6
    for other, found in ((scattered, "backlash"), (even, "tip_mass")):
        crew = FakeCrew({"": GAP, "tip_mass": other, "backlash": 0.0}, unseen=("backlash",))
        assert searched(crew, max_effects=1).best.names == (found,)


def test_beside_another_law_it_takes_no_place_of_those_that_a_probe_shows():
    gaps = {"": GAP, "dry_friction": 3e-3, "dry_friction+actuator_lag": 1e-3, "dry_friction+unequal_lag": 0.0}
    crew = FakeCrew(gaps, unseen=("unequal_lag",))
    assert searched(crew, max_effects=2).best.names == ("actuator_lag", "dry_friction")
    assert "dry_friction+unequal_lag" not in crew.finished


def test_many_readings_of_a_few_laws_do_not_crowd_out_another_law():
    every = [part for kind in EFFECTS.values() for part in readings(kind, levels=2)]
    gaps = {"": GAP, "actuator_lag": 1e-3, "bending_stop": 1.1e-3, "hysteresis": 1.2e-3, "tip_mass": 2e-3}
    crew = FakeCrew(gaps, quick={**gaps, "tip_mass": 0.0}, alike=0.9999)
    searched(crew, every, max_effects=1)
    assert "tip_mass" in crew.finished


@pytest.mark.parametrize(("shown", "looked_at"), [(3e-3, True), (3.8e-3, False)])
def test_laws_of_other_kinds_do_not_crowd_out_the_only_one_of_its_kind_that_a_probe_shows(shown, looked_at):
    gaps = {"": GAP} | dict.fromkeys(
        ("actuator_lag", "bending_stop", "hysteresis", "dry_friction", "torque_map", "tip_mass"), 1e-3
    )
    crew = FakeCrew(gaps | {"restraint": shown}, quick=gaps | {"restraint": 0.0})
    searched(crew, max_effects=1)
    assert ("restraint" in crew.finished) is looked_at


BY_LEVEL = [part for kind in EFFECTS.values() for part in readings(kind, levels=2, each=(1.11, 2.33))]


def test_sizes_apart_are_found_where_one_for_all_levels_leaves_much():
    crew = FakeCrew({"": GAP, "gravity_tilt": 2e-3, "gravity_tilt@each": 0.0, "torque_bias": 1.5e-3, "torque_bias@each": 1e-3})
    (part,) = searched(crew, BY_LEVEL).best.fit.hypothesis.parts
    assert (part.name, part.levels) == ("gravity_tilt", (1.11, 2.33))


def test_sizes_apart_that_take_away_little_more_are_not_tried():
    crew = FakeCrew({"": GAP, "gravity_tilt": 2e-3, "gravity_tilt@each": 1.9e-3})
    assert searched(crew, BY_LEVEL).best.names == ("gravity_tilt",)
    assert "gravity_tilt@each" not in crew.finished


def test_one_size_for_all_levels_takes_the_place_of_sizes_apart_that_close_the_gap_no_better(monkeypatch):
    monkeypatch.setattr("hsr_pin.diagnosis.screening.SIZES_APART", 1.0)
    nearly = 0.9 * THRESHOLDS.closed
    for left, apart in ((nearly, False), (0.2 * GAP, True)):
        found = searched(FakeCrew({"": GAP, "gravity_tilt": left, "gravity_tilt@each": 0.0}), BY_LEVEL)
        assert bool(found.best.fit.hypothesis.parts[0].levels) is apart


class SeesNoBias(FakeCrew):
    """Beside another law a probe shows nothing of a bias."""

    def guess(self, base, parts):
        answers = super().guess(base, parts)
        return [replace(g, gain=0.0) if base.names and g.hypothesis.parts[-1].name == "torque_bias" else g for g in answers]


def test_the_double_of_a_law_is_fitted_in_its_place_where_no_rung_came_to_it():
    singles = {"dead_time": 1.8e-3, "soft_spot": 1.85e-3, "preset_bend": 1.9e-3, "torque_bias": 1.91e-3}  # one more than a beam
    crew = SeesNoBias({"": GAP, **singles, "dead_time+preset_bend": 0.0, "dead_time+torque_bias": 0.1e-3})
    assert searched(crew).best.names == ("dead_time", "preset_bend")
    assert "dead_time+torque_bias" in crew.finished


def test_a_special_case_worse_than_another_that_is_clearly_worse_takes_no_place_for_its_scatter():
    trials = len(candidate(gap=GAP).heldout)
    best, worse = [0.5e-3] * trials, [0.9e-3] * trials
    odd = [0.5e-3] * (trials - 1) + [3e-3]  # in one trial
    gaps = {"": GAP, "torque_curve": tuple(best), "torque_bias": tuple(worse), "torque_decay": tuple(odd)}
    parts = [part for kind in [*EFFECTS.values(), FLEXIBLE["torque_curve"]] for part in readings(kind)]
    assert searched(FakeCrew(gaps), parts, max_effects=1).best.names == ("torque_curve",)


def test_effects_are_added_one_at_a_time_as_long_as_one_is_worth_having():
    found = searched(FakeCrew({"": GAP, "tip_mass": 2e-3, "actuator_lag": 3e-3, "tip_mass+actuator_lag": 0.0}))
    assert names(found.path) == [(), ("tip_mass",), ("actuator_lag", "tip_mass")]


def test_a_tiny_gain_is_no_finding_however_certain():
    after = (GAP**2 - 0.9 * THRESHOLDS.worth**2) ** 0.5
    assert names(searched(FakeCrew({"": GAP, "tip_mass": after})).path) == [()]
    after = (GAP**2 - 1.3 * THRESHOLDS.worth**2) ** 0.5
    assert names(searched(FakeCrew({"": GAP, "tip_mass": after})).path) == [(), ("tip_mass",)]


def test_a_large_gain_is_no_finding_if_it_rests_on_one_trial():
    before, after = (9e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3), (1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3)
    assert names(searched(FakeCrew({"": before, "tip_mass": after})).path) == [()]
    everywhere = tuple(0.5 * gap for gap in before)
    assert names(searched(FakeCrew({"": before, "tip_mass": everywhere})).path) == [(), ("tip_mass",)]


def test_a_pair_is_found_where_neither_is_worth_having_alone_and_no_third_is_looked_for_where_no_pair_is():
    little = (GAP**2 - 0.8 * THRESHOLDS.worth**2) ** 0.5
    gaps = {"": GAP, "backlash": little, "tip_mass": 1.0001 * little}
    assert names(searched(FakeCrew({**gaps, "backlash+tip_mass": 0.0})).path) == [(), ("backlash",), ("backlash", "tip_mass")]
    lines = []
    crew = FakeCrew({**gaps, "backlash+tip_mass": 0.5 * GAP, "backlash+tip_mass+stiffening": 0.0})  # it does not close the gap
    assert names(searched(crew, tell=lines.append).path) == [()]
    assert [line.split(":")[0] for line in lines] == ["effect 1", "effect 2"]
    crew = FakeCrew({**gaps, "backlash+tip_mass": 0.0})
    assert names(searched(crew, max_effects=1).path) == [()]


def test_what_is_worth_having_grows_with_noise_and_with_the_arm():
    assert Thresholds.of(1e-3, LENGTH).worth > Thresholds.of(1e-6, LENGTH).worth
    assert Thresholds.of(1e-6, 2 * LENGTH).worth == 2 * Thresholds.of(1e-6, LENGTH).worth


def test_a_loss_is_not_worth_having():
    assert worth_having(candidate(gap=2e-3), candidate(gap=1e-3), THRESHOLDS, 0)
    assert not worth_having(candidate(gap=1e-3), candidate(gap=2e-3), THRESHOLDS, 0)


@pytest.mark.parametrize("most", [0, 1, 2, 3])
def test_there_are_never_more_effects_than_allowed(most):
    four = ("tip_mass", "actuator_lag", "torque_bias", "stiffening")
    gaps = {"+".join(four[:count]): GAP * max(0.0, 1 - 0.27 * count) ** 0.5 for count in range(5)}
    crew = FakeCrew(gaps)
    found = searched(crew, max_effects=most)
    assert max(len(each) for each in names(found.tried)) == most
    assert found.best.names == tuple(sorted(four[:most]))


def test_without_effects_nothing_is_fitted():
    crew = FakeCrew({"": GAP, "tip_mass": 0.0})
    found = searched(crew, max_effects=0)
    assert (names(found.path), names(found.tried), crew.finished) == ([()], [()], [])


def test_a_closed_gap_is_not_searched():
    crew = FakeCrew({"": 0.5 * THRESHOLDS.closed, "tip_mass": 0.0})
    assert names(searched(crew).path) == [()]
    assert crew.finished == []


def test_the_search_ends_when_the_gap_is_closed():
    crew = FakeCrew({"": GAP, "tip_mass": 0.5 * THRESHOLDS.closed, "tip_mass+stiffening": 0.0})
    assert searched(crew).best.names == ("tip_mass",)
    assert "stiffening+tip_mass" not in crew.finished


def test_the_last_corner_of_an_explained_gap_is_not_searched_but_a_larger_one_is():
    shares = {"": GAP, "tip_mass": 1.9 * THRESHOLDS.closed, "tip_mass+actuator_lag": 0.0}
    assert names(searched(FakeCrew(shares)).path) == [(), ("tip_mass",)]
    shares["tip_mass"] = 2.1 * THRESHOLDS.closed
    assert names(searched(FakeCrew(shares)).path) == [(), ("tip_mass",), ("actuator_lag", "tip_mass")]


@pytest.mark.parametrize(("after_two", "effects"), [(0.8 * GAP, 2), (0.6 * GAP, 3)])
def test_a_third_effect_is_looked_for_only_where_two_take_half_of_the_squared_gap(after_two, effects):
    shares = {"": GAP, "tip_mass": 0.9 * GAP, "tip_mass+actuator_lag": after_two, "tip_mass+actuator_lag+backlash": 0.0}
    assert len(searched(FakeCrew(shares)).best.names) == effects


def test_a_stand_in_that_a_better_pair_replaces_is_not_on_the_path():
    found = searched(
        FakeCrew({"": GAP, "hysteresis": 1.5e-3, "dry_friction": 2e-3, "viscoelastic": 2.5e-3, "dry_friction+viscoelastic": 0.0})
    )
    assert names(found.path) == [(), ("dry_friction",), ("dry_friction", "viscoelastic")]
    for inner, outer in zip(found.path[:-1], found.path[1:], strict=True):
        assert set(inner.names) < set(outer.names)


def test_an_effect_that_two_later_ones_make_needless_is_dropped():
    crew = FakeCrew(  # neither of the two is worth having without the other, so that the search comes to them through a third
        {
            "": GAP,
            "hysteresis": 1e-3,
            "hysteresis+dry_friction": 0.8e-3,
            "dry_friction+viscoelastic": 0.0,
            "hysteresis+dry_friction+viscoelastic": 0.0,
        }
    )
    found = searched(crew)
    assert ("dry_friction", "hysteresis", "viscoelastic") in names(found.tried)
    assert found.best.names == ("dry_friction", "viscoelastic")


@pytest.mark.parametrize(
    ("first", "rest", "effects"),
    [
        (0.22 * GAP, 0.15 * GAP, ("hysteresis",)),  # a third of the distance gone, the gap still open: a patch on the first law
        (0.22 * GAP, 0.9 * THRESHOLDS.closed, ("gravity_tilt", "hysteresis")),  # as little, but the gap is closed
        (
            0.3 * GAP,
            0.14 * GAP,
            ("gravity_tilt", "hysteresis"),
        ),  # not closed, but most of what the first leaves is gone
        (0.3 * GAP, 0.16 * GAP, ("hysteresis",)),  # less than three quarters of it
    ],
)
def test_a_small_share_that_leaves_much_of_what_the_first_leaves_is_no_effect_of_its_own(first, rest, effects):
    found = searched(FakeCrew({"": GAP, "hysteresis": first, "hysteresis+gravity_tilt": rest}))
    assert found.best.names == effects


def test_a_stand_in_that_was_good_alone_is_exchanged_for_the_partner_that_was_not():
    gaps = {
        "": GAP,
        "stiffness_gradient": 0.5 * GAP,
        "torque_decay": 0.6 * GAP,
        "added_mass": 0.7 * GAP,
        "damping_gradient": 0.9 * GAP,
    }
    pairs = {"stiffness_gradient+damping_gradient": 0.05 * GAP, "soft_spot+damping_gradient": 0.0}
    found = searched(FakeCrew(gaps | pairs))
    assert found.best.names == ("damping_gradient", "soft_spot")
    assert ("damping_gradient", "stiffness_gradient") in names(found.tried)


@pytest.mark.parametrize(("errors", "effects"), [(5, ("hysteresis",)), (12, ("gravity_tilt", "hysteresis"))])
def test_a_second_effect_whose_amplitude_is_hardly_pinned_down_is_dropped(errors, effects):
    gaps = {"": GAP, "hysteresis": 0.22 * GAP, "hysteresis+gravity_tilt": 0.0}
    assert searched(FakeCrew(gaps, errors={"gravity_tilt": errors})).best.names == effects


def test_held_out_trials_decide_not_the_fit():
    crew = FakeCrew({"": GAP, "soft_spot": 1e-3, "tip_mass": 0.0}, quick={"": GAP, "soft_spot": 0.0, "tip_mass": 1e-3})
    found = searched(crew)
    assert crew.finished[0] == "soft_spot"
    assert found.best.names == ("tip_mass",)


def test_readings_of_one_law_do_not_crowd_out_other_laws():
    gaps = {"": GAP, "gravity_tilt": 1e-3, "marker_offset": 1.1e-3, "tip_mass": 1.2e-3, "backlash+tip_mass": 0.0}
    assert sum(len(EFFECTS[name].variants()) for name in ("gravity_tilt", "marker_offset")) > BEAM
    found = searched(FakeCrew(gaps))
    assert found.best.names == ("backlash", "tip_mass")


def test_every_reading_of_a_law_is_tried_once():
    found = searched(FakeCrew({"": GAP, "gravity_tilt": 1e-3}))
    keys = [key(each) for each in found.tried if each.names == ("gravity_tilt",)]
    assert len(keys) == len(set(keys)) == len(EFFECTS["gravity_tilt"].variants()) == 3


def test_readings_of_a_law_that_are_the_same_on_these_recordings_are_tried_as_one():
    found = searched(FakeCrew({"": GAP, "torque_map": 1e-3}, alike=1.0))
    assert [key(each) for each in found.tried if each.names == ("torque_map",)] == [
        (("torque_map", (("parity", "odd"),), False, "quadratic", ()),)
    ]


def test_an_open_number_of_the_arm_is_found_like_an_effect():
    found = searched(FakeCrew({"": GAP, "torque_gain": 0.0, "torque_decay": 2e-3}), [Part("torque_gain"), *EVERY])
    assert names(found.path) == [(), ("torque_gain",)]


@pytest.mark.parametrize(("law", "best"), [(0.11e-3, "dry_friction"), (0.17e-3, "dry_friction"), (0.3e-3, "friction_spectrum")])
def test_a_flexible_law_stays_only_where_it_is_clearly_better_than_a_law_that_it_contains_and_that_leaves_something(law, best):
    flexible = Part("friction_spectrum", neutral(FLEXIBLE["friction_spectrum"]))
    gaps = {"": GAP, "dry_friction": law, "friction_spectrum": 0.1e-3, "dry_friction+friction_spectrum": 0.1e-3}
    assert searched(FakeCrew(gaps), [flexible, *EVERY]).best.names == (best,)


def test_a_flexible_law_and_a_special_case_of_it_are_no_two_answers_of_which_neither_is_worth_a_name():
    flexible = Part("damping_profile", neutral(FLEXIBLE["damping_profile"]))
    gaps = {
        "": GAP,
        "viscoelastic": 0.2 * GAP,
        "viscoelastic+damping_profile": 0.01e-3,
        "viscoelastic+damping_gradient": 0.05e-3,
    }
    assert searched(FakeCrew(gaps), [flexible, *EVERY]).best.names == ("damping_gradient", "viscoelastic")
    gaps["viscoelastic+quadratic_damping"] = 0.05e-3  # of another law
    assert searched(FakeCrew(gaps), [flexible, *EVERY]).best.names == ("viscoelastic",)


def test_the_special_cases_of_the_best_are_tried_where_the_beam_passed_them_by():
    decoys = {name: 3e-3 for name in ("tip_mass", "backlash", "stiffening")}
    quick = {"": GAP, "unequal_lag": 0.0, **dict.fromkeys(decoys, 1e-4)}
    crew = FakeCrew({"": GAP, "unequal_lag": 0.0, "dead_time": 0.2 * THRESHOLDS.closed, **decoys}, quick=quick)
    assert searched(crew).best.names == ("dead_time",)
    assert crew.finished.index("dead_time") > crew.finished.index("unequal_lag")


def test_no_effect_is_added_to_itself():
    found = searched(FakeCrew({"": GAP, "gravity_tilt": 2e-3, "gravity_tilt+tip_mass": 1e-3}))
    assert all(len(set(each)) == len(each) for each in names(found.tried))


def test_each_rung_is_told():
    lines = []
    searched(FakeCrew({"": GAP, "tip_mass": 2e-3, "tip_mass+stiffening": 0.0}), tell=lines.append)
    assert [line.split(":")[0] for line in lines] == ["effect 1", "effect 2", "exchange"]


def test_the_noise_of_the_fabricated_recordings_is_what_the_thresholds_say():
    assert THRESHOLDS.noise == pytest.approx(NOISE * 2**0.5)
    assert THRESHOLDS.closed < THRESHOLDS.worth < GAP / 4


def test_a_pair_that_leads_with_its_patch_only_is_kept():
    gaps = {
        "": GAP,
        "bending_stop": 0.28 * GAP,
        "gravity_tilt": 0.3 * GAP,
        "bending_stop+marker_offset": 0.2 * GAP,
        "gravity_tilt+viscoelastic": 0.16 * GAP,
    }
    assert searched(FakeCrew(gaps)).best.names == ("gravity_tilt", "viscoelastic")
    assert searched(FakeCrew(gaps | {"bending_stop": 0.31 * GAP})).best.names == ("gravity_tilt",)


def test_laws_that_are_each_a_special_case_of_the_others_companion_do_not_take_turns():
    flexible = Part("elastic_curve", neutral(FLEXIBLE["elastic_curve"]))
    gaps = {
        "": GAP,
        "elastic_curve": 0.6 * GAP,
        "elastic_curve+stiffening": 0.1 * GAP,
        "bending_stop+elastic_curve": 0.1 * GAP,
    }
    assert "elastic_curve" in searched(FakeCrew(gaps), [flexible, *EVERY]).best.names


def test_a_model_that_lost_what_made_it_the_best_gives_way_to_a_better_one_as_small():
    gaps = {"": GAP, "bending_stop": 0.2 * GAP, "gravity_tilt": 0.3 * GAP, "gravity_tilt+viscoelastic": 0.15 * GAP}
    assert searched(FakeCrew(gaps, errors={"viscoelastic": 4})).best.names == ("bending_stop",)


def test_of_two_sets_that_do_as_well_the_one_of_clear_sizes_is_the_best():
    gaps = {
        "": GAP,
        "hysteresis": 0.8 * GAP,
        "viscoelastic": 0.82 * GAP,
        "hysteresis+stiffening": 0.5 * GAP,
        "viscoelastic+marker_offset": 0.52 * GAP,
    }
    assert searched(FakeCrew(gaps)).best.names == ("hysteresis", "stiffening")
    assert searched(FakeCrew(gaps, errors={"hysteresis": 4})).best.names == ("marker_offset", "viscoelastic")


class TwoBasins(FakeCrew):
    """Quick fits of every law but one stay where they start, and are good at a tenth of the damping only, which that finds."""

    def glance(self, tasks):
        fits = []
        for (_, guess), fit in zip(tasks, super().glance(tasks), strict=True):
            start = dict(zip(guess.hypothesis.free, guess.starts[0], strict=True))
            damping = 0.1 if fit.hypothesis.parts[-1].name == "soft_spot" else start["damping_scale"]
            values = [damping if name == "damping_scale" else value for name, value in fit.named.items()]
            stuck = np.full_like(fit.residuals[0], 3.5e-3 if fit.hypothesis.parts[-1].name == "tip_mass" else 3.4e-3)
            residuals = fit.residuals if damping == 0.1 else (stuck,) * len(fit.residuals)
            fits.append(replace(fit, values=np.array(values), residuals=residuals))
        return fits


def test_no_law_is_passed_over_for_want_of_the_damping_that_another_found():
    gaps = {"": GAP, "soft_spot": 1e-3, "backlash": 1.05e-3, "added_mass": 1.1e-3, "tip_mass": 0.0}
    crew = TwoBasins(gaps, quick={name: 1e-3 * (1 + 0.01 * k) for k, name in enumerate(gaps)} | {"": GAP})
    found = searched(crew)
    assert found.best.names == ("tip_mass",)


def test_a_model_that_ended_in_a_lesser_optimum_is_fitted_again_from_a_larger_one():
    """A lag that the arm alone does not lead to, beside a law of no size that happened to: the lag alone does it all."""
    gaps = {"": GAP, "unequal_lag": 1e-5, "elastic_curve": 3.9e-3}
    crew = FakeCrew(gaps, stuck={"unequal_lag": 1.3e-3}, errors={"elastic_curve": 0.5})
    flexible = [Part(law.name, neutral(law)) for law in FLEXIBLE.values() if law.name == "elastic_curve"]
    found = searched(crew, [next(part for part in EVERY if part.name == "unequal_lag"), *flexible])
    assert found.best.names == ("unequal_lag",) and crew.finished.count("unequal_lag") == 2
    assert mean_square(found.best) < 1e-8 + mean_square(candidate("unequal_lag"))


def test_a_simpler_law_is_looked_for_in_place_of_one_part_and_then_of_the_other():
    """Both parts of the truth come as the general laws that hold them; the beam passes by the pair itself."""
    general, mixed = "elastic_curve+unequal_lag", ("stiffening+unequal_lag", "actuator_lag+elastic_curve")
    gaps = {"": GAP, "unequal_lag": 2e-3, "elastic_curve": 2.1e-3, "actuator_lag": 3e-3, "stiffening": 3.1e-3}
    gaps |= {general: 0.0, **dict.fromkeys(mixed, 1e-5), "actuator_lag+stiffening": 2e-5}
    crew = FakeCrew(gaps, quick=gaps | {"actuator_lag+stiffening": 2.9e-3})
    flexible = [Part(law.name, neutral(law)) for law in FLEXIBLE.values() if law.name == "elastic_curve"]
    found = searched(crew, [*EVERY, *flexible])
    assert found.best.names == ("actuator_lag", "stiffening")
