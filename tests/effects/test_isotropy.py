"""A law that has a form in space knows no direction, and along one axis is the law of the plane."""

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import Bending
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.simulation.simulate import simulate

KEQ, TURN = 1.7, np.exp(0.9j)
#: What has a direction of its own, towards x, and is added to all others.
DIRECTED = {"preset_bend", "torque_bias"}
LAWS = [
    kind(
        **{fact.name: _value for fact in kind.parameters() for _value in [min(fact.neutral + fact.scale, fact.upper)]}, **variant
    )
    for kind in {**EFFECTS, **FLEXIBLE}.values()
    for variant in kind.variants()
]
IN_SPACE = [law for law in LAWS if law.in_space and law.name not in DIRECTED]


def named(law):
    return "-".join([law.name, *(value for _, value in law.options)])


def random(size, *shape):
    generator = np.random.default_rng(7)
    return size * (generator.normal(size=shape) + 1j * generator.normal(size=shape))


def moment(law, turn):
    """For angles, rates and memories that are turned."""
    angle, rate, *memory = turn * random(0.8, 2 + law.states, 40)
    return law.moment(law.p, Bending(angle, 8 * rate, KEQ, 1.0, 0.5, tuple(memory)))


def updated(law, turn):
    memory, start, end = turn * random(0.8, 3, 40)
    return np.array([law.update(law.p, k, memory, start, end, 0.02) for k in range(law.states)])


def answered(law, turn):
    torque, *memory = turn * random(0.8, 1 + law.memories, 40)
    mean, remembered = law.actuator_response(law.p, torque, tuple(memory), 0.02, KEQ)
    return np.array([mean, *remembered])


HOOKS = {"moment": moment, "update": updated, "actuator_response": answered}


@pytest.mark.parametrize(
    ("answer", "law"),
    [pytest.param(HOOKS[h], law, id=f"{h}-{named(law)}") for h in HOOKS for law in IN_SPACE if law.acts_through(h)],
)
def test_what_is_turned_is_answered_turned(answer, law):
    np.testing.assert_allclose(answer(law, TURN), TURN * answer(law, 1.0), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("law", [law for law in LAWS if law.in_space], ids=named)
def test_along_one_axis_it_is_the_law_of_the_plane(law):
    angle, rate, *memory = random(0.8, 2 + law.states, 40).real
    moments = [
        law.moment(law.p, Bending(angle.astype(kind), rate.astype(kind), KEQ, 1.0, 0.5, tuple(z.astype(kind) for z in memory)))
        for kind in (float, complex)
    ]
    np.testing.assert_allclose(*moments, rtol=1e-13, atol=1e-15)


def test_some_laws_have_no_form_in_space():
    assert {named(law) for law in LAWS if not law.in_space} == {
        "torque_map-even",
        "torque_curve",
        "side_force",
        "obstacle-post-positive",
        "obstacle-post-negative",
        "obstacle-wall-positive",
        "obstacle-wall-negative",
        "restraint-positive",
        "restraint-negative",
        "bending_stop-positive",
        "bending_stop-negative",
        "unequal_lag-positive",
        "damping_curve-positive",
        "damping_curve-negative",
        "marker_profile",
        "partial_bias",
        "one_sided_cable-positive",
        "one_sided_cable-negative",
        "capstan_friction",
    }


@pytest.mark.long
@pytest.mark.parametrize("law", [law for law in LAWS if law.in_space], ids=named)
def test_compiled_in_space_it_is_the_same(law):
    arm = ArmSpecification(3, bending="space", cross_tilt=0.2, placement="mid")
    torque = np.where(np.arange(31)[:, None] < 5, 0.0, [0.6, 0.4])
    scenario = Scenario(arm, np.arange(31) * 0.02, torque, effects=(law,))
    compiled, pinocchio = (simulate(scenario, dynamics=way).trajectory.positions for way in ("compiled", "rnea"))
    assert np.abs(compiled - pinocchio).max() < 1e-10
