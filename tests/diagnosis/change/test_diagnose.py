"""A change is named with its size, although the model has a discrepancy that both recordings share."""

from dataclasses import replace

import pytest

from hsr_pin.diagnosis.change.diagnose import diagnose_change
from hsr_pin.errors import IdentificationError

from .recorded import OTHER, QUICK, recorded


@pytest.fixture(scope="module")
def old():
    return recorded()


@pytest.fixture(scope="module")
def heavier(old):
    return diagnose_change(recorded("tip_mass:mass=0.02", name="new"), old, **QUICK)


def test_a_mass_that_came_is_named_alone_with_its_size(heavier):
    verdict = heavier.verdict
    assert (verdict.status, verdict.effects, verdict.kinds) == ("identified", ("tip_mass",), ("mass_gravity",))
    (size,) = verdict.changes
    assert size.before == 0
    assert size.step[0] <= 0.02 <= size.step[1]
    assert size.step[1] - size.step[0] < 0.01
    assert verdict.difference.after < 0.5 * verdict.difference.before


def test_a_change_is_written_as_a_report_and_as_json(heavier, tmp_path):
    heavier.to_html(tmp_path / "change.html")
    assert "tip mass" in (tmp_path / "change.html").read_text(encoding="utf-8")
    assert heavier.to_json()["verdict"]["effects"] == ["tip_mass"]


def test_nothing_has_changed_where_nothing_has(old):
    verdict = diagnose_change(recorded(name="new"), old, **QUICK).verdict
    assert (verdict.status, verdict.effects, verdict.changes) == ("unchanged", (), ())
    assert 0 < verdict.limits["keq_scale"] < 0.1
    assert verdict.difference.before < 2 * verdict.difference.scatter


@pytest.mark.long
def test_a_softer_arm_is_told_from_unlike_commands(old):
    verdict = diagnose_change(recorded(name="new", trials=OTHER, keq=0.99), old, **QUICK).verdict
    assert verdict.effects == ("keq_scale",)
    (size,) = verdict.changes
    assert size.step[0] <= 0.9 <= size.step[1]


@pytest.mark.long
def test_an_effect_that_is_there_grows_from_what_it_was():
    old, new = (recorded(f"actuator_lag:time_constant={lag}", name=name) for lag, name in ((0.06, "old"), (0.1, "new")))
    found = diagnose_change(new, old, **{**QUICK, "max_effects": 1})
    assert "actuator_lag" in found.reference.names
    assert found.verdict.effects == ("actuator_lag",)
    (size,) = found.verdict.changes
    assert size.before == pytest.approx(0.06, abs=0.01)
    assert size.step[0] <= 0.04 <= size.step[1]


@pytest.mark.long
def test_a_frame_that_is_turned_is_no_arm_that_is(old):
    turned = recorded("gravity_tilt:angle=0.06", name="new")
    assert "gravity_tilt" in _named(diagnose_change(turned, old, **{**QUICK, "effects": ["gravity_tilt", "frame_turn"]}).verdict)


def test_another_arm_is_refused(old):
    for change, word in ((replace(old, length=0.3), "length"), (replace(old, mount="upright"), "mount")):
        with pytest.raises(IdentificationError, match=f"{word} of old: expected"):
            diagnose_change(change, old, **QUICK)


def test_one_trial_is_too_little_to_know_what_trials_have_of_their_own(old):
    verdict = diagnose_change(old, replace(old, trials=old.trials[:1]), **QUICK).verdict
    assert verdict.status == "insufficient"
    assert "first recording" in verdict.sentence


def _named(verdict):
    return {*verdict.effects, *(name for names in verdict.alternatives for name in names)}
