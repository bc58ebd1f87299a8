"""Every effect is found by its name and can be written on a command line; what is wrong is named, with what would be right."""

import dataclasses
import re

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS, effect_named, parse_effect
from hsr_pin.effects.effect import effect_subset, neutral, stack
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.effects.gravity_tilt import GravityTilt
from hsr_pin.errors import EffectError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate

every_kind = pytest.mark.parametrize("kind", EFFECTS.values(), ids=EFFECTS)


def test_there_are_thirty_two_effects_and_ten_flexible_laws():
    assert (len(EFFECTS), len(FLEXIBLE)) == (32, 10)
    assert not {*EFFECTS} & {*FLEXIBLE}


@every_kind
def test_an_effect_is_a_frozen_dataclass_that_says_what_it_is(kind):
    assert dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen
    assert kind is effect_named(kind.name)
    assert all((kind.lacks, kind.cause, kind.__doc__))
    assert re.search(r"\(\d{4}\)", kind.citation)
    assert kind.__module__ == f"hsr_pin.effects.{kind.name}"


@every_kind
def test_a_parameter_has_unit_bounds_scale_and_description(kind):
    facts = kind.parameters()
    assert any(fact.amplitude for fact in facts)
    for fact in facts:
        assert fact.unit and fact.description
        assert fact.scale < fact.upper - fact.lower
        assert not fact.amplitude or fact.neutral == 0


@every_kind
def test_a_value_out_of_bounds_is_refused(kind):
    for fact in kind.parameters():
        for value in (fact.lower - 1e-6, fact.upper + 1e-6, float("nan")):
            with pytest.raises(EffectError, match=f"{kind.name}.{fact.name}: expected"):
                kind(**{fact.name: value})


@every_kind
def test_what_is_written_is_what_is_read(kind):
    for variant in kind.variants():
        values = {fact.name: fact.neutral + 0.3 * (fact.upper - fact.neutral) for fact in kind.parameters()}
        text = ",".join(f"{name}={value}" for name, value in {**values, **variant}.items())
        assert parse_effect(f"{kind.name}:{text}") == kind(**values, **variant)


def test_a_parameter_that_is_not_given_keeps_its_neutral_value():
    assert parse_effect("soft_spot: depth = 0.2") == effect_named("soft_spot")(depth=0.2)


def test_one_amplitude_of_several_switches_an_effect_on():
    assert parse_effect("unequal_lag:rise=0.1") == effect_named("unequal_lag")(rise=0.1)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("dry_frction:level=1", "stiffness_gradient, .* got 'dry_frction'; did you mean dry_friction?"),
        ("friktion", "expected stiffness_gradient"),
        ("dry_friction", "dry_friction.level: expected a value, as in dry_friction:level=0.05"),
        ("unequal_lag", "unequal_lag.rise: expected a value, as in unequal_lag:rise=[^ ]+,fall=[^ ]+,delay="),
        ("soft_spot:depht=1", "expected depth, centre, width, got 'depht'; did you mean depth?"),
        ("tip_mass:mass=heavy", "tip_mass.mass: expected a number, got 'heavy'"),
        ("tip_mass:mass", "tip_mass.mass: expected a number"),
        ("tip_mass:mass=0.1,mass=0.2", "tip_mass.mass: expected one value"),
        ("tip_mass:mass=7", r"tip_mass.mass: expected 0 to 0.5 \[kg\], got 7"),
        ("gravity_tilt:angle=0.1,frame=moon", "gravity_tilt.frame: expected world or base or cameras, got 'moon'"),
    ],
)
def test_a_mistake_is_named_with_what_would_be_right(text, complaint):
    with pytest.raises(EffectError, match=complaint):
        parse_effect(text)


@every_kind
def test_neutral_takes_every_reading_of_the_law(kind):
    for variant in kind.variants():
        assert dict(neutral(kind, **variant).options) == variant


def test_the_first_reading_is_the_default():
    assert GravityTilt.variants() == ({"frame": "world"}, {"frame": "base"}, {"frame": "cameras"})
    assert GravityTilt() == GravityTilt(frame="world")


def test_stacking_keeps_the_reading_and_columns_come_back():
    both = stack([GravityTilt(angle=a, frame="base") for a in (0.1, 0.2, 0.3)])
    assert both.frame == "base"
    np.testing.assert_array_equal(effect_subset(both, [2, 0]).angle, [0.3, 0.1])
    assert effect_subset(both, [1]).frame == "base"


def test_readings_are_kept_apart_in_a_batch():
    runs = [step_scenario(ArmSpecification(), 0.5, duration=0.3, effects=(GravityTilt(0.2, frame=f),)) for f in ("world", "base")]
    together = [result.trajectory.positions for result in simulate_batch(runs)]
    assert np.abs(together[0] - together[1]).max() > 0.01
    for run, positions in zip(runs, together, strict=True):
        np.testing.assert_allclose(positions, simulate(run).trajectory.positions, atol=1e-12)
