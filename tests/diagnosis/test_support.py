"""What speaks for a law: more where it is true than where it stands in for another, and the probability follows it."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from hsr_pin.diagnosis.candidates import Candidate, finish, glance, guesses
from hsr_pin.diagnosis.confidence import KIND, NAME, probability
from hsr_pin.diagnosis.support import Support, drift, environments, supports
from hsr_pin.diagnosis.thresholds import Thresholds
from hsr_pin.effects import effect_named
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.fit import fit
from hsr_pin.identification.heldout import leave_one_out
from hsr_pin.identification.hypothesis import Hypothesis, Part
from hsr_pin.identification.uncertainty import clearness

from .made import TRIALS, made

SMALL = {"trials": TRIALS, "duration": 1.0, "links": 8, "noise": 2e-4}
STRONG = Support("actuator_lag", "actuation_time", 0.9, 0.9, 50.0, 1.0, 0.02, 60.0, 0.1)


@lru_cache
def models():
    """Recordings with a lag in them: fits without effects, with the lag, and with two laws that are not in them."""
    experiment = prepare(made("actuator_lag:time_constant=0.08", **SMALL))
    base = fit(experiment, Hypothesis(links=8))
    found = {"base": Candidate(base, tuple(leave_one_out(experiment, base)))}
    for name in ("actuator_lag", "dry_friction", "tip_mass", "dead_time", "lag_cascade"):
        (guess,) = guesses(experiment, base, [Part(name, neutral(effect_named(name)))])
        found[name] = finish(experiment, glance(experiment, base, guess))
    return experiment, found


def told(best, *tried, shown=()):
    experiment, found = models()
    thresholds, others = Thresholds.of(experiment.noise_rms, experiment.dataset.length), [found[name] for name in tried]
    (part,), (kind,), together = supports(experiment, found[best], found["base"], others, thresholds, 0, shown)
    return part, kind, together


def test_what_recordings_show_without_a_model_counts_where_the_kind_would_be_seen():
    for best, shown, value in (
        ("actuator_lag", ("creep", "actuation_time"), 1.0),
        ("actuator_lag", ("creep",), -1.0),
        ("tip_mass", ("creep",), 0.0),
        ("tip_mass", ("mass_gravity",), 0.0),
    ):
        part, kind, _ = told(best, shown=shown)
        assert (part.shown, kind.shown) == (value, value)


def test_the_true_law_leads_by_far_is_always_better_and_has_one_size_everywhere():
    part, kind, _ = told("actuator_lag", "dry_friction", "tip_mass", "actuator_lag")
    assert part.frequency == kind.frequency == 1.0
    assert part.margin > 100 and part.clear > 20
    assert part.drift < 0.05
    assert probability(part, NAME) > 0.95 and probability(kind, KIND) > 0.95


def test_a_stand_in_has_another_size_in_every_environment():
    experiment, found = models()
    assert (
        drift(experiment, found["dead_time"].fit)["dead_time"] > 3 * drift(experiment, found["actuator_lag"].fit)["actuator_lag"]
    )


def test_a_law_that_a_better_one_was_tried_beside_has_no_support():
    part, _, _ = told("dry_friction", "actuator_lag", "dry_friction")
    assert part.share < 0 and part.frequency < 0.5
    assert probability(part, NAME) < 0.5


def test_a_law_that_needs_a_size_for_each_level_to_do_what_one_size_of_another_does_takes_nothing_from_it():
    experiment, found = models()
    best = found["actuator_lag"]
    apart = Part("dead_time", neutral(effect_named("dead_time")), levels=experiment.levels)
    (guess,) = guesses(experiment, found["base"].fit, [apart])
    fitted = finish(experiment, glance(experiment, found["base"].fit, guess))
    each, one = (replace(other, heldout=best.heldout) for other in (fitted, found["dead_time"]))
    thresholds = Thresholds.of(experiment.noise_rms, experiment.dataset.length)
    (part,), _, _ = supports(experiment, best, found["base"], [each], thresholds, 0, ())
    assert part.frequency == 1.0 and part.share > 0.5
    (part,), _, _ = supports(experiment, best, found["base"], [one], thresholds, 0, ())
    assert part.frequency < 1.0 and part.share == 0.0


def hazy(candidate, clear):
    """A model with one effect of a size that is so many standard errors from none."""
    (before,) = clearness(candidate.fit).values()
    own = np.array([clear / before if "." in name else 1.0 for name in candidate.fit.hypothesis.free])
    return replace(candidate, fit=replace(candidate.fit, slopes=tuple(slopes * own for slopes in candidate.fit.slopes)))


@pytest.mark.parametrize(("clear", "counts"), [(60.0, False), (5.0, False), (3.0, True)])
def test_a_rival_in_doubt_counts_where_the_law_is_in_more_doubt_itself(clear, counts):
    experiment, found = models()
    best = hazy(found["actuator_lag"], clear)
    rival = hazy(replace(found["dead_time"], heldout=best.heldout), 4.0)
    thresholds = Thresholds.of(experiment.noise_rms, experiment.dataset.length)
    (part,), _, _ = supports(experiment, best, found["base"], [rival], thresholds, 0, ())
    assert part.clear == pytest.approx(clear, rel=0.1)
    assert (part.share == 0.0) is counts


def test_a_choice_of_sets_has_the_support_that_none_of_them_has_beside_the_other():
    part, _, together = told("dead_time", "dead_time", "actuator_lag", "dry_friction")
    alone, either = together([("dead_time",)]), together([("dead_time",), ("actuator_lag",)])
    assert (alone.share, alone.frequency) == (part.share, part.frequency)
    assert part.share < 0.1 < 0.5 < either.share and either.frequency == 1.0


def test_environments_cut_every_sample_into_one_part_each():
    experiment, found = models()
    for parts in environments(experiment, found["base"].fit):
        for run in range(len(experiment.runs)):
            assert np.array_equal(sum(part[run].astype(int) for part in parts), np.ones(len(experiment.runs[run].time)))


@pytest.mark.parametrize(
    ("field", "worse"),
    [("lead", 0.0), ("margin", 0.5), ("frequency", 0.6), ("drift", 1.0), ("clear", 3.0), ("rest", 0.6), ("shown", -1.0)],
)
def test_whatever_speaks_less_for_a_law_makes_it_less_probable(field, worse):
    for coefficients in (NAME, KIND):
        if field == "margin" and coefficients is NAME:  # it is in the alternatives
            continue
        assert probability(replace(STRONG, **{field: worse}), coefficients) < probability(STRONG, coefficients)
        assert 0 <= probability(replace(STRONG, **{field: worse}), coefficients) <= 1


def test_a_kind_that_was_right_more_often_than_others_is_more_probable_and_its_names_are_not():
    fair = replace(STRONG, margin=1.5, clear=10.0, lead=0.4)
    damping, elastic = (replace(fair, kind=kind) for kind in ("damping", "elastic"))
    assert probability(damping, KIND) > probability(elastic, KIND) + 0.05
    assert probability(damping, NAME) == probability(elastic, NAME)


def test_a_law_that_has_one_of_the_choice_for_a_special_case_is_no_rival_of_it_and_the_clearest_of_them_counts():
    part, _, together = told("dead_time", "dead_time", "actuator_lag", "lag_cascade", "dry_friction")
    _, found = models()
    assert found["lag_cascade"].contains(found["actuator_lag"])
    either = together([("dead_time",), ("actuator_lag",)])
    assert part.share < 0.1 < 0.5 < either.share
    assert (
        either.clear == max(clearness(found[name].fit)[name] for name in ("dead_time", "actuator_lag")) > part.clear
    )  # of what is on offer


def test_a_kind_is_as_clear_as_the_clearest_of_its_laws_that_do_about_as_well():
    part, kind, _ = told("lag_cascade", "actuator_lag", "lag_cascade", "dead_time", "dry_friction")
    _, found = models()
    lag, late = (clearness(found[name].fit)[name] for name in ("actuator_lag", "dead_time"))
    assert kind.clear == lag > part.clear and late != lag
