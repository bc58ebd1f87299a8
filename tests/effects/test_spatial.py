"""Laws that only an arm in space has: off they are nothing, on they do what they say, and along x some are laws of the plane."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from hsr_pin.effects import EFFECTS, effect_named, parse_effect
from hsr_pin.effects.effect import Bending, neutral, with_values
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker

EXAMPLES = [
    parse_effect(text)
    for text in (
        "unequal_stiffness:along_x=0.2,diagonal=-0.1",
        "bend_at_rest:towards_x=0.2,towards_y=-0.1",
        "torsion_compliance:ratio=1.4",
        "turned_actuation:angle=0.3",
        "weak_chamber:loss=0.4,direction=0.8",
        "torque_offset:towards_x=0.1,towards_y=-0.15",
        "base_tilt:towards_x=0.1,towards_y=-0.06",
        "base_tilt:towards_x=0.1,towards_y=-0.06,frame=base",
        "base_tilt:towards_x=0.1,towards_y=-0.06,frame=cameras",
        "markers_beside:towards_x=0.004,towards_y=-0.006",
        "markers_beside:towards_x=0.004,towards_y=-0.006,base=kept",
        "markers_beside:towards_x=0.004,towards_y=-0.006,base=zeroed",
    )
]
#: Laws of the plane, and what becomes of them.
SISTERS = {
    "preset_bend:angle=0.2": "bend_at_rest:towards_x=0.2",
    "torque_bias:bias=0.1": "torque_offset:towards_x=0.1",
    "gravity_tilt:angle=0.1": "base_tilt:towards_x=0.1",
    "gravity_tilt:angle=0.1,frame=base": "base_tilt:towards_x=0.1,frame=base",
    "gravity_tilt:angle=0.1,frame=cameras": "base_tilt:towards_x=0.1,frame=cameras",
    "marker_offset:offset=0.005": "markers_beside:towards_x=0.005",
    "marker_offset:offset=0.005,base=zeroed": "markers_beside:towards_x=0.005,base=zeroed",
}
MARKERS = (Marker("base", 0.0), Marker("low", 0.1, 0.03, 0.5), Marker("tip", 0.24, 0.02, -2.0))
each_effect = pytest.mark.parametrize("effect", EXAMPLES, ids=repr)


def scenario(*effects, mount="horizontal"):
    """Torques to all sides, so that an arm that can twist does so."""
    time = np.arange(121) * 0.01
    torque = np.select([time[:, None] < t for t in (0.1, 0.4, 0.8)], [[0.0, 0.0], [0.6, 0.3], [-0.3, 0.5]], [0.1, -0.6])
    arm = ArmSpecification(4, placement="mid", mount=mount, bending="space", tip_mass=0.03, bending_limit=9.0)
    return Scenario(arm, time, torque, effects=effects, markers=MARKERS)


def seen(*effects, **how):
    return simulate(scenario(*effects), **{"dynamics": "compiled", "step": 0.01, **how}).trajectory.positions


def test_every_law_has_its_example_and_says_what_it_is():
    assert {effect.name for effect in EXAMPLES} == {*SPATIAL}
    assert not {*SPATIAL} & {*EFFECTS, *FLEXIBLE}
    for kind in SPATIAL.values():
        assert kind is effect_named(kind.name) and re.search(r"\(\d{4}\)", kind.citation)
        assert kind.__module__ == f"hsr_pin.effects.spatial.{kind.name}"
        assert all(fact.unit and fact.description and fact.neutral == 0 for fact in kind.parameters())
        assert set(kind.contains) <= {*EFFECTS}


@each_effect
def test_off_it_is_nothing_and_on_it_shows(effect):
    off = neutral(type(effect), **dict(effect.options))
    np.testing.assert_array_equal(seen(off), seen())
    assert np.linalg.norm(seen(effect) - seen(), axis=-1).max() > 1e-4


@each_effect
def test_in_a_plane_it_is_refused(effect):
    with pytest.raises(InputError, match=f"laws that are defined for planar arms, got {effect.name}"):
        step_scenario(ArmSpecification(), 0.1, effects=(effect,))


@each_effect
def test_compiled_it_is_the_same(effect):
    np.testing.assert_allclose(seen(effect), seen(effect, dynamics="rnea"), atol=1e-10)


@each_effect
def test_its_parameters_are_recovered(effect):
    facts = effect.parameters()
    truth, scale = (np.array([of(fact) for fact in facts]) for of in (lambda f: getattr(effect, f.name), lambda f: f.scale))
    lower, upper = (np.array([getattr(fact, end) for fact in facts]) for end in ("lower", "upper"))
    data = seen(effect)

    def missed(values):
        return (seen(with_values(effect, **dict(zip((f.name for f in facts), values, strict=True)))) - data).ravel()

    begin = np.array([0.5 * fact.scale * fact.amplitude for fact in facts])
    found = least_squares(missed, begin, bounds=(lower, upper), x_scale=scale, diff_step=1e-4, xtol=1e-9, ftol=1e-12)
    np.testing.assert_allclose(found.x, truth, atol=0.02 * scale.min())


@pytest.mark.parametrize(("plane", "space"), SISTERS.items())
def test_along_x_it_is_the_law_of_the_plane(plane, space):
    np.testing.assert_allclose(seen(parse_effect(space)), seen(parse_effect(plane)), atol=1e-12)
    assert parse_effect(plane).name in parse_effect(space).contains


def test_an_arm_that_is_stiffer_one_way_bends_less_that_way():
    law = parse_effect("unequal_stiffness:along_x=0.2")
    along, across = (law.moment(law.p, Bending(way, 0.0, 2.0, 1.0, 0.5, ())) for way in (1.0 + 0j, 1j))
    assert (along, across) == (pytest.approx(0.4), pytest.approx(-0.4j))
    half = parse_effect("unequal_stiffness:diagonal=0.2")
    way = np.exp(0.25j * np.pi)
    assert half.moment(half.p, Bending(way, 0.0, 2.0, 1.0, 0.5, ())) == pytest.approx(0.4 * way)


def test_a_weak_chamber_lacks_where_it_pulls_and_nowhere_else():
    law = parse_effect("weak_chamber:loss=0.5,direction=0")
    ways = np.exp(2j * np.pi / 3 * np.arange(3))
    arriving = law.actuator_response(law.p, ways, (), 0.01, 1.0)[0]
    np.testing.assert_allclose(arriving, [0.5, ways[1], ways[2]], atol=1e-12)
    assert law.actuator_response(law.p, -ways[:1], (), 0.01, 1.0)[0] == pytest.approx(-ways[0])  # made by the other two
    between = np.exp(0.9j)  # by two of them, one of which is weak: what is missing points at it
    missing = between - law.actuator_response(law.p, between, (), 0.01, 1.0)[0]
    assert missing.real > 0.1 and missing.imag == pytest.approx(0.0)


def test_a_compliance_of_twist_is_added_to_the_declared_one():
    law = parse_effect("torsion_compliance:ratio=1.5")
    arm = ArmSpecification(keq=3.0, bending="space")
    assert law.arm(arm).torsion == pytest.approx(2.0)
    assert law.arm(replace(arm, torsion=2.0)).torsion == pytest.approx(1.0)
    assert neutral(type(law)).arm(arm).torsion == np.inf
