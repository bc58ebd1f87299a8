"""From recordings to a verdict: what was put into them is named, and what no candidate knows is not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import _Study, catalogue, diagnose
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.thresholds import clearly_worse
from hsr_pin.effects import EFFECTS
from hsr_pin.errors import EffectError, IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset

from . import outside
from .fabricated import THRESHOLDS, FakeCrew, candidate
from .made import CATALOGUE, TRIALS, made

FEW = ["actuator_lag", "dead_time", "tip_mass", "torque_bias"]


def named(dataset, effects=FEW, **options):
    return diagnose(dataset, effects=effects, jobs=1, **options)


@pytest.mark.parametrize("effect", ["actuator_lag:time_constant=0.08", "tip_mass:mass=0.05"])
def test_the_effect_in_the_recordings_is_named(effect):
    found = named(made(effect))
    assert (found.verdict.status, found.verdict.effects) == ("identified", (effect.split(":")[0],))
    assert found.ladder[-2].rms == pytest.approx(found.thresholds.noise, rel=0.1)
    assert sum(rung.share for rung in found.ladder) == pytest.approx(1.0)


def test_other_stiffness_and_damping_are_parameters_and_no_effect():
    verdict = named(made()).verdict
    assert (verdict.status, verdict.effects) == ("parameters", ())


def test_other_parameters_at_each_level_are_parameters_and_no_effect():
    soft, stiff = made(keq=1.12), made(keq=0.9)
    mixed = replace(soft, trials=(*soft.trials[:3], *stiff.trials[3:]))
    found = named(mixed)
    assert (found.verdict.status, found.verdict.effects) == ("parameters", ())
    assert [rung.name for rung in found.ladder][-2] == "stiffness and damping of each level"


def test_a_law_outside_the_catalogue_gets_no_name():
    verdict = named(made(outside.PulsingStiffness(depth=0.4))).verdict
    assert (verdict.status, verdict.effects) == ("unexplained", ())


def test_one_trial_is_too_little_and_says_what_to_record():
    whole = made("tip_mass:mass=0.05")
    found = named(replace(whole, trials=whole.trials[:1]))
    assert found.verdict.status == "insufficient"
    assert len(found.next_experiment) > 1


def test_an_arm_that_never_moves_is_too_little():
    still = made(trials=tuple((keq, damping, (0.0, 0.0)) for keq, damping, _ in TRIALS))
    assert named(still).verdict.status == "insufficient"


def test_the_same_seed_gives_the_same_answer():
    dataset = made("torque_bias:bias=0.1")
    first, second = named(dataset, seed=3), named(dataset, seed=3)
    assert first.verdict == second.verdict
    assert first.ladder == second.ladder


def test_an_unknown_effect_and_a_negative_limit_are_refused():
    with pytest.raises(EffectError, match="actuator_lag"):
        named(made(), effects=["actuator_leg"])
    with pytest.raises(IdentificationError, match="zero or more"):
        named(made(), max_effects=-1)


def test_trials_set_aside_change_the_ladder_and_nothing_else():
    dataset = made("tip_mass:mass=0.05")
    last = dataset.trials[-1]
    shifted = replace(last, trajectory=replace(last.trajectory, positions=last.trajectory.positions + np.array([0.01, 0.0, 0.0])))
    spoilt = replace(dataset, trials=(*dataset.trials[:-1], shifted))
    first, second = (named(each, effects=["tip_mass"], max_effects=1, test=("trial_06",)) for each in (dataset, spoilt))
    assert first.verdict.effects == second.verdict.effects == ("tip_mass",)
    assert second.search.best.fit.values == pytest.approx(first.search.best.fit.values, rel=1e-3)
    assert first.ladder[-2].rms == pytest.approx(first.thresholds.noise, rel=0.1)
    assert second.ladder[-2].rms == pytest.approx(0.01, rel=0.05)


def test_what_foretells_trials_set_aside_no_better_is_not_named(monkeypatch):
    biased, plain = made("torque_bias:bias=0.1"), made()
    mixed = replace(biased, trials=(*biased.trials[:-1], plain.trials[-1]))
    one, other = (named(each, effects=["torque_bias"], max_effects=1, test=("trial_06",)) for each in (biased, mixed))
    assert (one.verdict.status, one.verdict.effects) == ("identified", ("torque_bias",))
    assert (other.verdict.status, other.verdict.effects, other.verdict.kinds) == ("unexplained", (), ())
    assert other.ladder[-2].rms > other.ladder[-3].rms
    less, worse = (f"({1e3 * rung.rms:.2f} mm)" for rung in other.ladder[-3:-1])
    assert f"foretells those set aside no better {worse} than stiffness and damping alone do {less}." in other.verdict.sentence
    assert max(other.verdict.confidence.values()) < 0.2 < min(one.verdict.confidence.values())
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.pulsation", lambda *_: SimpleNamespace(kind="elastic", sentence="it pulses"))
    again = named(mixed, effects=["torque_bias"], max_effects=1, test=("trial_06",))
    assert again.verdict == other.verdict  # what models said was wrong, which is no sign of anything else
    outer = named(made(outside.PulsingStiffness(depth=0.4)), effects=["torque_bias"], max_effects=1, test=("trial_06",))
    assert (outer.verdict.status, outer.verdict.kinds) == ("partly_identified", ("elastic",))


def test_spikes_do_not_decide():
    clean = made("actuator_lag:time_constant=0.08")
    generator = np.random.default_rng(5)
    trials = []
    for trial in clean.trials:
        positions = trial.trajectory.positions.copy()
        hit = generator.random(positions.shape[:2]) < 0.02
        positions[hit] += 0.03 * generator.standard_normal((int(hit.sum()), 3))
        trials.append(replace(trial, trajectory=replace(trial.trajectory, positions=positions)))
    verdict = named(replace(clean, trials=tuple(trials))).verdict
    assert (verdict.status, verdict.effects) == ("identified", ("actuator_lag",))


#: It makes 0.9 mm in all; a quick fit is still far from its optimum when the best few are chosen for full ones, and viscoelastic
#: is called certain in its place.
MISSED = "soft_spot:depth=0.7,centre=0.35,width=0.08"


@pytest.mark.long
@pytest.mark.parametrize(
    "effect", [pytest.param(each, marks=pytest.mark.xfail(strict=True)) if each == MISSED else each for each in CATALOGUE]
)
def test_every_effect_is_named_with_the_whole_catalogue_to_choose_from(effect):
    verdict, truth = diagnose(made(effect), jobs=1).verdict, (effect.split(":")[0],)
    assert verdict.effects == truth if verdict.status == "identified" else truth in verdict.alternatives


@pytest.mark.long
def test_sample_steps_has_two_effects(shared):
    found = diagnose(read_dataset(shared / "recordings" / "sample-steps"), jobs=1)
    assert found.verdict.status == "identified"
    assert len(found.verdict.effects) == 2


def test_a_law_that_is_needless_with_the_commands_taken_the_other_way_has_to_be_worth_having_there():
    late, without = candidate("bending_stop", "dead_time", gap=5e-5), candidate("bending_stop", gap=2e-4)
    assert clearly_worse(without, late, THRESHOLDS, 0)
    study = SimpleNamespace(seed=0)
    assert _Study.needless(study, late, without, THRESHOLDS)
    assert not _Study.needless(study, late, candidate("bending_stop", gap=5e-4), THRESHOLDS)
    assert not _Study.needless(study, late, candidate("bending_stop", "actuator_lag", gap=2e-4), THRESHOLDS)


def test_a_simpler_law_with_the_commands_taken_the_other_way_must_be_no_worse_even_where_one_trial_keeps_it_from_being_certain():
    best = candidate("unequal_lag", gap=(1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3, 1.1e-3))
    worse = candidate("actuator_lag", gap=(9e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3))
    assert not clearly_worse(worse, best, THRESHOLDS, 0)
    study = SimpleNamespace(seed=0)
    assert not _Study.needless(study, best, worse, THRESHOLDS)
    assert _Study.needless(study, best, candidate("actuator_lag", gap=1.2e-3), THRESHOLDS)


@pytest.mark.parametrize(("names", "turned"), [((), False), (("tip_mass",), True)])
def test_commands_are_not_taken_the_other_way_for_a_pair_where_no_law_is_worth_having(names, turned, monkeypatch):
    crew = FakeCrew({"": 1e-3, "tip_mass": 1e-3, "actuator_lag": 1e-3, "actuator_lag+tip_mass": 0.0})
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.otherwise", lambda experiment: ["the other way"])
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.Crew", lambda *given: crew)
    tried = [candidate(gap=1e-3), candidate("actuator_lag", gap=1e-3), candidate("actuator_lag", "tip_mass", gap=0.9e-3)]
    found = SimpleNamespace(
        search=Search((tried[0], candidate(*names, gap=1e-3)), tuple(tried)), experiment=None, thresholds=THRESHOLDS
    )
    study = SimpleNamespace(executor=None, advance=None, seed=0, _sooner=lambda best, crew: [])
    assert _Study.turned(study, found)[0] == ("the other way" if turned else None)


@pytest.mark.parametrize(
    ("told", "status", "alone", "taken"),
    [
        (candidate("backlash", gap=1e-4), "ambiguous", 1.4, True),
        (candidate("backlash", gap=1e-4), "unexplained", 1.4, False),
        (candidate("backlash", gap=0.9e-3), "ambiguous", 1.4, False),
        (candidate("actuator_lag", gap=1e-4), "identified", 1.4, False),
        (candidate("backlash", gap=1e-4), "ambiguous", 1.6, False),
    ],
    ids=["play that shows there", "nothing there either", "hardly better", "late for the way itself", "much worse alone"],
)
def test_what_nothing_explains_is_looked_at_with_the_commands_taken_another_way(told, status, alone, taken, monkeypatch):
    def diagnosis(best, status):
        return SimpleNamespace(
            search=Search((base, best), ()), verdict=SimpleNamespace(status=status), experiment=None, thresholds=THRESHOLDS
        )

    base = candidate(gap=1e-3)
    again = diagnosis(told, status)
    study = SimpleNamespace(seed=0, tell=lambda line: None, of=lambda experiment, settled: again)
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.otherwise", lambda experiment: ["the other way"])
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.fit", lambda *given, **start: SimpleNamespace(rms=alone * base.fit.rms))
    found = diagnosis(base, "unexplained")
    assert _Study.in_other_forms(study, found) is (again if taken else found)
    explained = diagnosis(base, "partly_identified")
    assert _Study.in_other_forms(study, explained) is explained


@pytest.mark.parametrize(("trials", "asked"), [(TRIALS, True), (TRIALS[:4], False), (TRIALS[:3], False)])
def test_sizes_at_each_level_are_asked_for_where_each_can_be_checked_on_a_trial_that_is_held_out(trials, asked):
    parts = catalogue(list(EFFECTS.values()), prepare(made(trials=trials, links=4)))
    assert {part.levels for part in parts if part.levels} == ({(1.11, 2.33)} if asked else set())


def test_a_base_that_was_mounted_anew_for_each_level_is_named_with_both_of_its_angles():
    both = [made(f"gravity_tilt:angle={angle}", trials=trials) for angle, trials in ((0.1, TRIALS[:3]), (-0.05, TRIALS[3:]))]
    trials = [replace(trial, name=f"trial_{k}") for k, trial in enumerate(trial for one in both for trial in one.trials)]
    found = diagnose(
        replace(both[0], trials=tuple(trials)), effects=["gravity_tilt", "torque_bias", "preset_bend", "tip_mass"], jobs=1
    )
    assert (found.verdict.status, found.verdict.effects) == ("identified", ("gravity_tilt",))
    sizes = found.search.best.fit.named
    assert [sizes[f"gravity_tilt.angle@{keq}"] for keq in (1.11, 2.33)] == pytest.approx([0.1, -0.05], abs=2e-3)
