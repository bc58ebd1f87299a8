"""A diagnosis names the simulated cause, and does not name causes outside the catalogue."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import catalogue, diagnose, unfitted
from hsr_pin.diagnosis.pulsation import Pulsation
from hsr_pin.diagnosis.verdict import WORDS
from hsr_pin.effects import EFFECTS
from hsr_pin.errors import EffectError, IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.inference.search import judged
from hsr_pin.inference.verdict import verdict_of
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

from ..inference.fabricated import CALIBRATION
from . import outside
from .fabricated import DATA, LENGTH, LIMITS, candidate
from .made import CATALOGUE, TRIALS, made

FEW = ["actuator_lag", "dead_time", "tip_mass", "torque_bias"]


def named(dataset, effects=FEW, **options):
    return diagnose(dataset, effects=effects, jobs=1, **options)


@pytest.mark.parametrize("effect", ["actuator_lag:time_constant=0.08", "tip_mass:mass=0.05"])
def test_the_effect_in_the_recordings_is_named(effect):
    found = named(made(effect))
    assert (found.verdict.status, found.verdict.effects) == ("identified", (effect.split(":")[0],))
    assert found.ladder[-2].rms == pytest.approx(found.limits.noise, rel=0.1)
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
    assert first.ladder[-2].rms == pytest.approx(first.limits.noise, rel=0.1)
    assert second.ladder[-2].rms == pytest.approx(0.01, rel=0.05)


def test_what_predicts_trials_set_aside_no_better_is_not_named():
    biased, plain = made("torque_bias:bias=0.1"), made()
    mixed = replace(biased, trials=(*biased.trials[:-1], plain.trials[-1]))
    one, other = (named(each, effects=["torque_bias"], max_effects=1, test=("trial_06",)) for each in (biased, mixed))
    assert (one.verdict.status, one.verdict.effects) == ("identified", ("torque_bias",))
    assert (other.verdict.status, other.verdict.effects, other.verdict.kinds) == ("unexplained", (), ())
    assert other.ladder[-2].rms > other.ladder[-3].rms


@pytest.mark.parametrize(("share", "kinds"), [(0.8, ("elastic",)), (0.2, ())])
def test_what_pulsates_is_of_a_kind_without_a_name_where_it_predicts_most_of_the_gap(share, kinds):
    base = candidate(gap=4e-3)
    where = SimpleNamespace(base=None, pulsation=Pulsation(2.0, 0.1, share))
    found = judged([base], DATA, CALIBRATION, unfitted(base, where))
    said = verdict_of(found, LIMITS, (5e-3) ** 2, WORDS, length=LENGTH)
    assert (said.effects, said.kinds) == ((), kinds)


def test_a_folder_does_as_well_and_a_diagnosis_says_shortly_what_it_is(heavy_tip, tmp_path):
    write_dataset(heavy_tip, tmp_path / "heavy")
    found = diagnose(tmp_path / "heavy", effects=["tip_mass"], max_effects=1, jobs=1)
    assert found.verdict.effects == ("tip_mass",)
    assert "heavy" in repr(found) and "tip_mass is missing" in repr(found) and len(repr(found)) < 400


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
    tilts = [
        each.fit for each in found.search.candidates if each.names == ("gravity_tilt",) and each.fit.hypothesis.parts[0].levels
    ]
    (sizes,) = (fit.named for fit in tilts if fit.hypothesis.effects[0].frame == "world")  # the variant that it was made with
    assert [sizes[f"gravity_tilt.angle@{keq}"] for keq in (1.11, 2.33)] == pytest.approx([0.1, -0.05], abs=2e-3)


@pytest.mark.parametrize("weighed", [False, True])
def test_of_an_arm_that_was_weighed_no_other_mass_is_considered(weighed):
    parts = catalogue(list(EFFECTS.values()), prepare(replace(made(links=4), weighed=weighed)))
    assert ({"mass_scale", "added_mass"} & {part.name for part in parts} == set()) == weighed
    assert "tip_mass" in {part.name for part in parts}
