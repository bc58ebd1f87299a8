"""Every verdict is reached from what calls for it, and from nothing less."""

import numpy as np
import pytest

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.search import Search, Thresholds, search
from hsr_pin.diagnosis.verdict import judge
from hsr_pin.effects import EFFECTS
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Hypothesis

NOISE = 3e-4  # [m] of a coordinate
THRESHOLDS = Thresholds.of(NOISE * np.sqrt(3), 0.24)
TRIALS, SAMPLES = 6, 200


def candidate(*names, left, sure=True, trials=range(TRIALS)):
    """A fitted model that misses every marker of the given trials by ``left`` [m], under the same noise as all others."""
    generator = np.random.default_rng(1)
    missed = tuple(NOISE * generator.standard_normal((SAMPLES, 1, 3)) for _ in range(TRIALS))
    missed = tuple(part + (np.array([left, 0.0, 0.0]) if k in trials else 0.0) for k, part in enumerate(missed))
    hypothesis = Hypothesis().with_effects(*(EFFECTS[name]() for name in names))
    values = np.array([p.neutral + p.scale * p.amplitude for p in hypothesis.parameters])
    slopes = tuple((1e-2 if sure else 1e-9) * generator.standard_normal((SAMPLES, 1, 3, len(values))) for _ in range(TRIALS))
    weights = tuple(np.full((SAMPLES, 1, 3), 1 / NOISE) for _ in range(TRIALS))
    fit = Fit(hypothesis, values, missed, slopes, weights, missed, True, 1)
    return Candidate(fit, missed)


def verdict(path, *rivals, nominal=0.01, by_level=None):
    return judge(nominal**2, Search(tuple(path), (*path, *rivals)), THRESHOLDS, 0, by_level)


BASE = candidate(left=3e-3)
LAG = candidate("actuator_lag", left=5e-5)


def test_a_declared_model_that_leaves_nothing_is_no_gap():
    assert verdict([candidate(left=5e-5)], nominal=1e-4).status == "no_gap"


def test_a_gap_that_stiffness_and_damping_close_is_parameters():
    assert verdict([candidate(left=5e-5)]).status == "parameters"


def test_an_effect_that_closes_the_gap_and_has_no_rival_is_identified():
    found = verdict([BASE, LAG], candidate("tip_mass", left=2e-3))
    assert (found.status, found.effects, found.alternatives) == ("identified", ("actuator_lag",), ())


def test_two_effects_that_do_equally_well_are_ambiguous_and_neither_is_certain():
    found = verdict([BASE, LAG], candidate("dead_time", left=5e-5))
    assert (found.status, found.effects) == ("ambiguous", ())
    assert set(found.alternatives) == {("actuator_lag",), ("dead_time",)}


def test_what_all_alternatives_share_is_certain():
    best = candidate("actuator_lag", "tip_mass", left=5e-5)
    found = verdict([BASE, LAG, best], candidate("actuator_lag", "added_mass", left=5e-5))
    assert found.status == "ambiguous"
    assert found.effects == ("actuator_lag",)


def test_a_rival_with_more_effects_is_no_rival():
    assert verdict([BASE, LAG], candidate("dead_time", "tip_mass", left=5e-5)).status == "identified"


def test_a_gap_that_no_effect_is_worth_having_for_is_unexplained():
    assert verdict([BASE], candidate("actuator_lag", left=2.99e-3)).status == "unexplained"


def test_an_effect_that_leaves_a_third_of_the_gap_is_not_named():
    found = verdict([BASE, candidate("actuator_lag", left=1.2e-3)])
    assert (found.status, found.effects) == ("unexplained", ())


def test_an_effect_whose_interval_holds_its_neutral_value_is_not_named():
    assert verdict([BASE, candidate("actuator_lag", left=5e-5, sure=False)]).status == "unexplained"


@pytest.mark.parametrize(
    ("left", "status"),
    [(4e-5, "ambiguous"), (1.5e-3, "identified")],
    ids=["as well", "worse"],
)
def test_another_stiffness_at_each_level_is_a_rival_to_every_name(left, status):
    found = verdict([BASE, LAG], by_level=candidate(left=left))
    assert found.status == status
    assert (() in found.alternatives) == (status == "ambiguous")


def test_another_stiffness_at_each_level_explains_what_no_effect_does():
    assert verdict([BASE, candidate("actuator_lag", left=1.2e-3)], by_level=candidate(left=5e-5)).status == "parameters"


class Fabricated:
    """Workers that know how well each set of effects does, and guess and fit nothing."""

    def __init__(self, known):
        self.known, self.finished = known, []

    def guess(self, base, effects):
        from hsr_pin.diagnosis.candidates import Guess

        models = [base.fit.hypothesis.with_effects(effect) for effect in effects]
        return [Guess(model, (model.start,), 0.5) for model in models if self._of(model) is not None]

    def glance(self, tasks):
        return [self._of(guess.hypothesis).fit for _, guess in tasks]

    def finish(self, tasks):
        self.finished += [tuple(effect.name for effect in quick.hypothesis.effects) for _, quick in tasks]
        return [self._of(quick.hypothesis) for _, quick in tasks]

    def _of(self, model):
        return self.known.get(frozenset(effect.name for effect in model.effects))


def searched(*candidates, start=BASE, **options):
    known = {frozenset(each.names): each for each in (start, *candidates)}
    effects = [EFFECTS[name]() for name in sorted({name for each in candidates for name in each.names})]
    return search(start, effects, THRESHOLDS, Fabricated(known), **options)


def test_effects_are_added_as_long_as_one_is_worth_having():
    found = searched(
        candidate("actuator_lag", left=2e-3), candidate("tip_mass", left=2.5e-3), candidate("actuator_lag", "tip_mass", left=5e-5)
    )
    assert [each.names for each in found.path] == [(), ("actuator_lag",), ("actuator_lag", "tip_mass")]


def test_a_certain_gain_that_is_tiny_is_no_finding():
    assert len(searched(candidate("actuator_lag", left=2.999e-3)).path) == 1


def test_a_large_gain_in_one_trial_alone_is_no_finding():
    lopsided = candidate(left=0.02, trials=[0])
    assert len(searched(candidate("actuator_lag", left=1e-3), start=lopsided).path) == 1


def test_nothing_is_added_to_a_closed_gap_or_beyond_the_limit():
    assert len(searched(candidate("actuator_lag", left=1e-5), start=candidate(left=1e-4)).path) == 1
    assert len(searched(LAG, max_effects=0).path) == 1


def test_a_stand_in_that_a_better_pair_replaces_has_no_place_on_the_way():
    found = searched(
        candidate("dead_time", left=1.5e-3),
        candidate("actuator_lag", left=2e-3),
        candidate("dead_time", "tip_mass", left=1.4e-3),
        candidate("actuator_lag", "tip_mass", left=5e-5),
        candidate("tip_mass", left=2.5e-3),
    )
    assert [each.names for each in found.path] == [(), ("actuator_lag",), ("actuator_lag", "tip_mass")]


def test_an_effect_that_the_others_made_needless_is_dropped():
    alone = candidate("backlash", left=6e-5)
    known = {
        frozenset(): BASE,
        frozenset({"torque_bias"}): candidate("torque_bias", left=1e-3),
        frozenset({"backlash", "torque_bias"}): candidate("backlash", "torque_bias", left=5e-5),
    }
    workers = Fabricated(known)
    glanced = workers.glance
    workers.glance = lambda tasks: (glanced(tasks), known.setdefault(frozenset({"backlash"}), alone))[0]  # seen only at the end
    found = search(BASE, [EFFECTS["torque_bias"](), EFFECTS["backlash"]()], THRESHOLDS, workers)
    assert [each.names for each in found.path] == [(), ("backlash",)]
