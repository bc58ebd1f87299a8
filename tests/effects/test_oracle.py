"""One oracle over all effects: what any law must keep, and fabricated laws that break each promise and must fail."""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares

from hsr_pin.effects import EFFECTS, Effect, parse_effect
from hsr_pin.effects.effect import Bending, with_values
from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.parameters import parameter
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.columns import Columns, shape_of
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate

EXAMPLES = [
    parse_effect(text)
    for text in (
        "stiffness_gradient:slope=-0.8",
        "soft_spot:depth=0.6,centre=0.4,width=0.15",
        "stiffening:cubic=0.4",
        "stiffening:cubic=-0.3",
        "bending_stop:ratio=6,angle=0.6",
        "backlash:gap=0.3",
        "dry_friction:level=0.08",
        "hysteresis:amplitude=0.15,yield_angle=0.2",
        "hysteresis:amplitude=0.15,yield_angle=0.2,form=maxwell_slip",
        "viscoelastic:ratio=0.6,time_constant=0.3",
        "quadratic_damping:coefficient=0.008",
        "damping_gradient:slope=1.2",
        "actuator_lag:time_constant=0.08",
        "dead_time:delay=0.043",
        "torque_bias:bias=-0.15",
        "torque_map:quadratic=0.25",
        "torque_map:quadratic=-0.2,parity=even",
        "torque_decay:decay=0.4",
        "gravity_tilt:angle=0.12",
        "gravity_tilt:angle=-0.12,frame=base",
        "tip_mass:mass=0.05",
        "added_mass:mass=0.06",
        "marker_offset:offset=0.008",
        "marker_offset:offset=-0.008,base=kept",
    )
]
PASSIVE = [effect for effect in EXAMPLES if effect.passive]
STICKING = [effect for effect in EXAMPLES if effect.name in ("dry_friction", "hysteresis")]

each_effect = pytest.mark.parametrize("effect", EXAMPLES, ids=repr)


def scenario(*effects, links=4, **changes):
    """Steps up, down and to the other side, 2 s."""
    time = np.arange(201) * 0.01
    torque = np.select([time < 0.1, time < 0.6, time < 1.0, time < 1.4], [0.0, 0.9, 0.3, -0.7], 0.1)
    plain = Scenario(ArmSpecification(links=links, placement="mid"), time, torque, Settled(0.0), effects)
    return replace(plain, **changes)


def markers(scenario, **how):
    return simulate(scenario, **how).trajectory.positions


def distance(a, b):
    """Largest distance [m] of a marker."""
    return np.linalg.norm(a - b, axis=-1).max()


def switched_off(effect):
    """The amplitudes neutral, the shapes as they are."""
    return with_values(effect, **{fact.name: fact.neutral for fact in effect.parameters() if fact.amplitude})


# --- the promises ---------------------------------------------------------------------------------------------------------------


def neutral_is_nominal(effect):
    for how in ({"integrator": "ros2"}, {"dynamics": "rnea"}, {}):
        assert np.array_equal(markers(scenario(switched_off(effect)), **how), markers(scenario(), **how))
    assert distance(markers(scenario(effect)), markers(scenario())) > 1e-4


def dissipates_on_closed_paths(effect):
    rng = np.random.default_rng(1)
    coarse = np.cumsum(rng.normal(size=40))
    coarse = 1.5 * (coarse - coarse[0]) / np.abs(coarse - coarse[0]).max()
    path = np.interp(np.linspace(0, 40, 4001), np.arange(41), [*coarse, 0.0])  # [rad] from the straight pose and back
    for step in (1e-4, 1e-2, 1.0):
        state, work, turnover = np.zeros((effect.states, 1, 1)), 0.0, 0.0
        for start, end in itertools.pairwise(path.reshape(-1, 1, 1)):
            before, rate = state, (end - start) / step
            state = effect.update(state, start, end, step)
            ends = [Bending(*pose, np.ones(1), np.ones((1, 1)), z) for pose, z in (((start, rate), before), ((end, rate), state))]
            part = ((end - start) * sum(effect.moment(bending) for bending in ends)).item() / 2
            work, turnover = work + part, turnover + abs(part)
        assert work > -1e-4 * turnover


def loses_energy_in_free_motion(effect):
    links, step = 4, 0.005
    time = np.arange(301) * step
    free = Scenario(
        ArmSpecification(links=links, placement="mid"), time, 0 * time, Pose(np.linspace(0.1, 0.35, links)), (effect,)
    )
    run = simulate(free, step=step).trajectory
    columns = Columns([free], shape_of(free, step))
    model = columns.arm_models[0].model
    data = model.createData()
    spring = links * free.arm.keq * columns.profile[:, 0]
    energy, moments = [], []
    states, before = columns.virgin_states(), 0 * run.joint_angles[0][:, None]
    for n, (q, v) in enumerate(zip(run.joint_angles, run.joint_rates, strict=True)):
        here = q[:, None]
        states = columns.update(states, before, here, step if n else math.inf)
        bending = [Bending(links * here, links * v[:, None], columns.keq, columns.profile, state) for state in states]
        moments.append(sum(law.moment(at)[:, 0] for law, at in zip(columns.laws, bending, strict=True)) + 0 * q)
        gravity, kinetic = pin.computePotentialEnergy(model, data, q), pin.computeKineticEnergy(model, data, q, v)
        energy.append(gravity + kinetic + spring @ q**2 / 2)
        before = here
    stored = np.cumsum(np.sum(np.diff(run.joint_angles, axis=0) * (np.array(moments[1:]) + moments[:-1]), axis=1) / 2)
    total = np.add(energy, [0.0, *stored])  # of the bodies and springs, and the work that went into the laws
    assert np.diff(total).max() < 1e-4 * np.ptp(total)


def own_parameters_are_recovered(effect):
    facts = effect.parameters()
    lower, upper, scale = (np.array([getattr(fact, key) for fact in facts]) for key in ("lower", "upper", "scale"))
    truth = np.array([getattr(effect, fact.name) for fact in facts])
    begin = np.array([fact.neutral + 0.5 * fact.scale * fact.amplitude for fact in facts])

    def seen(values):
        guess = with_values(effect, **{fact.name: value for fact, value in zip(facts, values, strict=True)})
        return markers(scenario(guess, links=6), integrator="ros2").ravel()

    def slopes(values):
        ends = [(np.minimum(values + h, upper), np.maximum(values - h, lower)) for h in np.diag(1e-3 * scale)]
        return np.column_stack([(seen(a) - seen(b)) / (a - b).sum() for a, b in ends])

    data = seen(truth)
    fit = least_squares(lambda x: seen(x) - data, begin, slopes, bounds=(lower, upper), x_scale=scale, xtol=1e-9, ftol=1e-12)
    assert np.all(np.abs(fit.x - truth) < 0.01 * scale)
    weakest = np.linalg.svd(fit.jac * scale, compute_uv=False)[-1] / np.sqrt(data.size)
    assert weakest > 1e-5  # [m] what the eye of the cameras has to tell apart


def state_stays_bounded(effect):
    rng = np.random.default_rng(2)
    state = np.zeros((effect.states, 3, 1))
    path = np.cumsum(rng.normal(size=(2000, 3, 1)), axis=0)
    path *= 3 / np.abs(path).max()
    for start, end in itertools.pairwise(path):
        state = effect.update(state, start, end, 0.01)
    assert np.all(np.abs(state) <= 6)
    wild = scenario(effect, arm=ArmSpecification(links=8, placement="mid", bending_limit=20.0))
    wild = replace(wild, torque=2 * np.sign(np.sin(8 * wild.time)))
    for how in ("ros2", "extrapolated4"):
        run = simulate(wild, integrator=how)
        assert np.abs(run.trajectory.joint_angles.sum(axis=1)).max() < 8


def batch_equals_single(effect):
    more = [switched_off(effect)]
    for fact in effect.parameters():
        value = getattr(effect, fact.name)
        more.append(with_values(effect, **{fact.name: value + 0.1 * fact.scale}))
    shared = scenario(effect)
    runs = [scenario(e, implicit_as=shared) for e in (effect, *more)] + [scenario(effect, links=3), scenario()]
    for run, result in zip(runs, simulate_batch(runs), strict=True):
        assert distance(result.trajectory.positions, markers(run)) < 1e-12


def holds_a_stuck_pose(effect):
    time = np.arange(6201) * 0.01
    run = simulate(scenario(effect, time=time, torque=np.where(time < 1, 0.8, 0.0)))
    q = run.trajectory.joint_angles
    assert abs(q[-1].sum()) > 5e-3  # [rad] it came to rest away from the straight pose
    assert np.abs(q[-1] - q[200]).max() < 1e-6
    assert np.abs(q[-1] - q[1000]).max() < 1e-12


def default_step_is_accurate(effect):
    exact = markers(scenario(effect), integrator="extrapolated2", step=2.5e-4)
    for integrator, largest, typical in (("extrapolated4", 1.2e-3, 0.1e-3), ("ros2", 3.5e-3, 0.7e-3)):  # [m]
        error = np.linalg.norm(markers(scenario(effect), integrator=integrator) - exact, axis=-1)
        assert error.max() < largest
        assert np.sqrt(np.mean(error**2)) < typical


def static_start_is_where_slow_loading_ends(effect):
    time = np.arange(1601) * 0.01
    loaded = markers(scenario(effect, time=time, torque=0.6 * np.minimum(1, time / 10)))
    started = markers(scenario(effect, time=time, torque=np.full(1601, 0.6), start=Settled(0.6)))
    assert distance(started, started[0]) < 1e-9
    assert distance(loaded[-1], started[0]) < 1e-4


def links_do_not_matter(effect):
    change = [markers(scenario(effect, links=n)) - markers(scenario(links=n)) for n in (4, 16)]
    assert np.sqrt(np.mean((change[0] - change[1]) ** 2)) < 0.1 * np.sqrt(np.mean(change[1] ** 2)) + 2e-5


# --- every effect keeps them ----------------------------------------------------------------------------------------------------


def test_every_effect_has_an_example_and_every_option_too():
    assert {effect.name for effect in EXAMPLES} == set(EFFECTS)
    seen = {(effect.name, effect.options) for effect in EXAMPLES}
    assert seen == {(kind.name, tuple(variant.items())) for kind in EFFECTS.values() for variant in kind.variants()}


@each_effect
def test_the_neutral_value_gives_the_nominal_model_exactly(effect):
    neutral_is_nominal(effect)


@pytest.mark.parametrize("effect", [e for e in PASSIVE if e.acts_through("moment")], ids=repr)
def test_a_passive_law_takes_work_on_any_closed_path(effect):
    dissipates_on_closed_paths(effect)


@pytest.mark.parametrize("effect", PASSIVE, ids=repr)
def test_a_freely_moving_arm_with_a_passive_law_loses_energy(effect):
    loses_energy_in_free_motion(effect)


@each_effect
def test_parameters_are_recovered_from_data_made_with_them(effect):
    own_parameters_are_recovered(effect)


@each_effect
def test_states_and_angles_stay_bounded_under_violent_reversals(effect):
    state_stays_bounded(effect)


@each_effect
def test_a_batch_gives_each_column_what_it_gives_alone(effect):
    batch_equals_single(effect)


@pytest.mark.parametrize("effect", STICKING, ids=repr)
def test_a_stuck_pose_holds_for_a_minute(effect):
    holds_a_stuck_pose(effect)


@each_effect
def test_the_default_step_is_accurate(effect):
    default_step_is_accurate(effect)


@each_effect
def test_a_static_start_is_where_slow_loading_ends(effect):
    static_start_is_where_slow_loading_ends(effect)


@each_effect
def test_a_law_means_the_same_for_any_number_of_links(effect):
    links_do_not_matter(effect)


# --- negative control: laws that break one promise each -----------------------------------------------------------------------


@dataclass(frozen=True)
class Bad(Effect):
    """Base of the fabricated laws: a linear spring beside the arm's own."""

    name = "bad"
    passive = True
    level: float = parameter(0.0, lower=-9.0, upper=9.0, unit="1", scale=0.1, amplitude=True, description="")

    def moment(self, bending):
        return self.level * bending.keq * bending.angle


class NeverOff(Bad):
    def stiffness(self, s):
        return 1 + 1e-9 + 0 * s


class Pump(Bad):
    def moment(self, bending):
        return -self.level * bending.keq * bending.rate

    def tangent(self, keq):
        return 0.0, 0.0


@dataclass(frozen=True)
class Twins(Bad):
    other: float = parameter(1.0, lower=0.0, upper=9.0, unit="1", scale=0.1, description="")

    def moment(self, bending):
        return self.other * super().moment(bending)


class Heap(Bad):
    states = 1

    def moment(self, bending):
        return self.level * 1e-3 * bending.state[0]

    def update(self, state, start, end, elapsed):
        return state + np.abs(end - start)


class Gossip(Bad):
    def moment(self, bending):
        return super().moment(bending).mean(axis=1, keepdims=True) + 0 * bending.angle


class Leak(Bad):
    states = 1

    def moment(self, bending):
        return self.level * bending.keq * bending.state[0]

    def update(self, state, start, end, elapsed):
        return np.clip(state + end - start, -0.1, 0.1) * math.exp(-min(elapsed, 1e3) / 50)


class Harsh(Bad):
    def moment(self, bending):
        return self.level * bending.keq * np.sign(bending.rate)


class PerJoint(Bad):
    def moment(self, bending):
        return super().moment(bending) / len(bending.angle)


class Unsettled(Viscoelastic):
    def update(self, state, start, end, elapsed):
        return super().update(state, start, end, min(elapsed, 0.01))


@pytest.mark.parametrize(
    ("promise", "effect"),
    [
        (neutral_is_nominal, NeverOff(0.1)),
        (dissipates_on_closed_paths, Pump(0.1)),
        (loses_energy_in_free_motion, Pump(0.2)),
        (own_parameters_are_recovered, Twins(0.2, 0.5)),
        (state_stays_bounded, Heap(0.1)),
        (batch_equals_single, Gossip(0.2)),
        (holds_a_stuck_pose, Leak(1.0)),
        (default_step_is_accurate, Harsh(0.3)),
        (static_start_is_where_slow_loading_ends, Unsettled(0.6, 0.3)),
        (links_do_not_matter, PerJoint(0.5)),
    ],
    ids=lambda value: getattr(value, "__name__", type(value).__name__),
)
def test_a_law_that_breaks_a_promise_fails_it(promise, effect):
    with pytest.raises((AssertionError, RuntimeError)):
        promise(effect)


@pytest.mark.parametrize(
    "promise",
    [
        neutral_is_nominal,
        dissipates_on_closed_paths,
        loses_energy_in_free_motion,
        own_parameters_are_recovered,
        state_stays_bounded,
        batch_equals_single,
        default_step_is_accurate,
        static_start_is_where_slow_loading_ends,
        links_do_not_matter,
    ],
)
def test_the_fabricated_laws_fail_for_their_own_fault(promise):
    """The harmless spring that they are made of keeps the promises."""
    promise(Bad(0.2))
