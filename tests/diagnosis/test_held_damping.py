"""Damping that takes a slow torque's place: with the damping held, the slow torque takes away what is its own."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from hsr_pin.diagnosis import held_damping
from hsr_pin.diagnosis.candidates import finish
from hsr_pin.diagnosis.crew import Crew
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json
from hsr_pin.diagnosis.held_damping import MUCH, with_damping_held
from hsr_pin.diagnosis.words import advice
from hsr_pin.effects import parse_effect
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.fit import fit
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.parallel import workers

from .made import TRIALS, made

ALONE = Hypothesis(links=8)


@pytest.fixture(scope="module")
def slow():
    """An arm with a slow torque and a heavy tip; its stiffness and damping alone, and with both laws."""
    trials = [(keq, 0.02, torques) for keq, _, torques in TRIALS if keq == 1.11]
    experiment = prepare(made("actuator_lag:time_constant=0.35", "tip_mass:mass=0.03", trials=trials, damping=1.0))
    both = ALONE.with_effects(parse_effect("actuator_lag:time_constant=0.2"), parse_effect("tip_mass:mass=0.01"))
    return SimpleNamespace(
        experiment=experiment, base=finish(experiment, fit(experiment, ALONE)), best=finish(experiment, fit(experiment, both))
    )


def held(slow, best):
    with workers(1) as executor:
        return with_damping_held(slow.base, best, Crew(slow.experiment, executor))


def test_the_slow_torque_takes_what_the_damper_took_in_its_place(slow):
    assert slow.base.fit.named["damping_scale"] > MUCH
    found = held(slow, slow.best)
    assert (found.slow, found.others) == (("actuator_lag",), ("tip_mass",))
    assert found.damping == (slow.base.fit.named["damping_scale"], slow.best.fit.named["damping_scale"])
    assert "damping_scale" not in found.model.fit.named
    assert found.model.fit.named["actuator_lag.time_constant"] == pytest.approx(0.35, rel=0.05)
    assert found.shares[0] > 0.9 and found.shares[0] + found.shares[1] == pytest.approx(1.0, abs=0.02)


def test_a_fit_that_ended_without_the_lag_finds_it(slow):
    """Beside a large damping the lag may have gone to nothing."""
    values = [1e-4 if name.startswith("actuator_lag") else value for name, value in slow.best.fit.named.items()]
    found = held(slow, replace(slow.best, fit=replace(slow.best.fit, values=slow.best.fit.values * 0 + values)))
    assert found.model.fit.named["actuator_lag.time_constant"] == pytest.approx(0.35, rel=0.05)


def test_there_is_no_other_reading_of_a_plain_damping_or_of_a_torque_that_comes_at_once(slow):
    heavy = finish(slow.experiment, fit(slow.experiment, ALONE.with_effects(parse_effect("tip_mass:mass=0.01"))))
    assert held(slow, heavy) is None
    plain = SimpleNamespace(base=slow.best, experiment=slow.experiment)
    assert held(plain, slow.best) is None


def test_there_is_none_where_each_level_has_a_damping_of_its_own(slow):
    free = ("keq_scale@1.11", "damping_scale@1.11", *slow.best.fit.hypothesis.free[2:])
    levels = replace(slow.best, fit=replace(slow.best.fit, hypothesis=replace(slow.best.fit.hypothesis, free=free)))
    assert levels.names == slow.best.names and held(slow, levels) is None


def test_a_slow_torque_that_takes_nothing_away_is_no_reading(slow, monkeypatch):
    monkeypatch.setattr(held_damping, "left", lambda model: 1.0 + len(model.names))
    assert held(slow, slow.best) is None


def test_it_is_asked_only_where_a_slow_torque_is_certain(heavy_tip, monkeypatch):
    asked = []
    monkeypatch.setattr("hsr_pin.diagnosis.diagnose.with_damping_held", lambda *what: asked.append(what))
    diagnose(heavy_tip, effects=["tip_mass", "actuator_lag"], max_effects=1, jobs=1)
    assert not asked


def test_it_is_told_in_words_and_in_json(slow, diagnosis):
    found = held(slow, slow.best)
    told = replace(diagnosis, held=found)
    (line,) = set(advice(told)) - set(advice(diagnosis))
    lag = found.model.fit.named["actuator_lag.time_constant"]
    assert line.startswith("Without actuator lag the damping comes out ")
    assert f"actuator lag (time_constant {lag:.3f} s) takes away {100 * found.shares[0]:.0f} % of the squared gap" in line
    assert line.endswith(f"tip mass {100 * found.shares[1]:.0f} % more.")
    document = to_json(told)["damping_held"]
    assert document["late"] == {"effects": ["actuator_lag"], "share": found.shares[0]}
    assert document["model"]["effects"] == ["actuator_lag", "tip_mass"]
    assert document["damping_scale"]["alone"] > MUCH > document["damping_scale"]["best"]
