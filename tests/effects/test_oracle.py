"""One oracle over all effects: what any law must keep, and fabricated laws that break each promise and must fail."""

import itertools
import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares

from hsr_pin.effects import EFFECTS, Effect, parse_effect
from hsr_pin.effects.effect import Bending, with_values
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.effects.vector import limited
from hsr_pin.effects.viscoelastic import Viscoelastic
from hsr_pin.parameters import amplitude, shape
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import simulate_together
from hsr_pin.simulation.integrator import LONGEST, Integrator
from hsr_pin.simulation.reference import add_joint_moments, update_states
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.simulation.simulate import simulate

EXAMPLES = [
    parse_effect(text)
    for text in (
        "stiffness_gradient:slope=-0.8",
        "soft_spot:depth=0.6,centre=0.4,width=0.15",
        "preset_bend:angle=0.2",
        "stiffening:cubic=0.4",
        "stiffening:cubic=-0.3",
        "bending_stop:ratio=6,angle=0.6",
        "bending_stop:ratio=6,angle=0.4,side=positive",
        "bending_stop:ratio=6,angle=0.3,side=negative",
        "backlash:gap=0.3",
        "dry_friction:level=0.08",
        "dry_friction:level=0.06,form=load",
        "hysteresis:amplitude=0.15,yield_angle=0.2",
        "hysteresis:amplitude=0.15,yield_angle=0.2,form=maxwell_slip",
        "viscoelastic:ratio=0.6,time_constant=0.3",
        "quadratic_damping:coefficient=0.008",
        "damping_gradient:slope=1.2",
        "actuator_lag:time_constant=0.08",
        "actuator_lag:time_constant=0.08,order=second",
        "actuator_lag:time_constant=0.08,order=orifice",
        "unequal_lag:rise=0.05,fall=0.12,delay=0.02",
        "unequal_lag:rise=0.12,fall=0.05,fills=positive",
        "partial_lag:time_constant=0.12,at_once=0.3",
        "ringing_drive:period=0.2,damping_ratio=0.15",
        "dead_time:delay=0.043",
        "torque_bias:bias=-0.15",
        "torque_map:quadratic=0.25",
        "torque_map:quadratic=-0.2,parity=even",
        "torque_map:quadratic=0.2,threshold=0.1",
        "torque_decay:decay=0.4",
        "one_sided_cable:lost=0.7",
        "one_sided_cable:lost=1,pulls=negative",
        "capstan_friction:friction=0.3",
        "capstan_friction:conduit=0.2",
        "gravity_tilt:angle=0.12",
        "gravity_tilt:angle=-0.12,frame=base",
        "gravity_tilt:angle=0.12,frame=cameras",
        "tip_mass:mass=0.05",
        "added_mass:mass=0.06",
        "restraint:contact_stiffness=200,distance=0.02",
        "restraint:contact_stiffness=150,distance=0.02,side=negative",
        "restraint:contact_stiffness=300,distance=0.005,at=0.5",
        "obstacle:hardness=20000,gap=0.04,at=0.5,form=wall",
        "obstacle:hardness=20000,gap=0.005,at=0.9,form=wall,side=negative",
        "obstacle:hardness=20000,gap=0.01,at=0.7",
        "obstacle:hardness=20000,gap=0.01,at=0.7,side=negative",
        "side_force:force=0.3",
        "side_force:force=-0.5,at=0.45",
        "marker_offset:offset=0.008",
        "marker_offset:offset=-0.008,base=kept",
        "marker_offset:offset=0.008,base=zeroed",
        "marker_slip:slip=0.008",
        "marker_slip:slip=-0.008,which=between",
        "marker_slip:slip=-0.008,which=all",
        "length_change:depth=0.02",
        "camera_scale:scale=0.03",
        "elastic_curve:first=0.3,second=0.2,fourth=0.1",
        "damping_curve:coefficient=0.2,power=0.6",
        "damping_curve:coefficient=0.05,power=2,way=positive",
        "damping_curve:coefficient=0.3,power=1.5,way=negative",
        "damping_profile:first=0.5,second=-0.3",
        "stiffness_profile:first=0.4,second=-0.3,third=0.2",
        "torque_profile:first=-0.4,second=0.3,third=0.2",
        "friction_spectrum:first=0.03,second=0.03,third=0.1,fourth=0.1",
        "creep_spectrum:fast=0.3,middle=0.3,slow=0.3",
        "lag_cascade:first=0.05,second=0.03,delay=0.02",
        "marker_profile:across=0.004,taper=-0.003,lift=0.005,slide=0.004",
        "torque_curve:even=0.1,odd=0.2,cubic=0.1",
        "partial_bias:bias=0.1,start=0.4",
    )
]
PASSIVE = [effect for effect in EXAMPLES if effect.passive]
STICKING = [effect for effect in EXAMPLES if effect.name in ("dry_friction", "hysteresis")]

#: All but those that creep, or are damped alone in their play; and laws at the steep end of their ranges.
LASTING = [effect for effect in EXAMPLES if effect.kind != "creep" and effect.name != "backlash"]
STEEPEST = [
    parse_effect(text)
    for text in (
        "stiffening:cubic=5",
        "bending_stop:ratio=30,angle=0.3",
        "dry_friction:level=0.02",
        "dry_friction:level=1",
        "dry_friction:level=1,form=load",
        "hysteresis:amplitude=1,yield_angle=0.1",
        "hysteresis:amplitude=1,yield_angle=0.1,form=maxwell_slip",
        "quadratic_damping:coefficient=0.1",
        "viscoelastic:ratio=3,time_constant=0.1",
    )
]

#: Of laws that are treated less implicitly than they act, and of a jump of the torque that is spread over a sample [m].
LARGEST_ERROR = {"hysteresis": 2.5e-4, "quadratic_damping": 2e-4, "dead_time": 1.2e-3, "unequal_lag": 4e-4}

each_effect = pytest.mark.parametrize("effect", EXAMPLES, ids=repr)


def scenario(*effects, links=4, **changes):
    """Steps up, down and to the other side, 2 s."""
    time = np.arange(201) * 0.01
    torque = np.select([time < 0.1, time < 0.6, time < 1.0, time < 1.4], [0.0, 0.9, 0.3, -0.7], 0.1)
    plain = Scenario(ArmSpecification(links=links, placement="mid"), time, torque, Settled(0.0), effects)
    return replace(plain, **changes)


def short(*effects):
    """A step up, one down and one to the other side, 0.5 s: enough for what has to be equal to the last digit."""
    plain = scenario(*effects)
    return replace(plain, time=plain.time[:51], torque=plain.torque[::4][:51])


def markers(scenario, dynamics="compiled", **how):
    return simulate(scenario, dynamics=dynamics, **how).trajectory.positions


def distance(a, b):
    """Largest distance [m] of a marker."""
    return np.linalg.norm(a - b, axis=-1).max()


def switched_off(effect):
    """The amplitudes neutral, the shapes as they are; a delay is an amplitude wherever it stands."""
    off = {fact.name: fact.neutral for fact in effect.parameters() if fact.amplitude or fact.name == "delay"}
    return with_values(effect, **off)


# --- the promises ---------------------------------------------------------------------------------------------------------------


@cache
def nominal(**how):
    """Where the markers of the arm without any effect are; the same for every law that is tried."""
    return markers(short(), **how)


def neutral_is_nominal(effect):
    off = short(switched_off(effect))
    for how in ({"integrator": "extrapolated2"}, {}, {"dynamics": "rnea"}, {"dynamics": "aba"}):
        assert np.array_equal(markers(off, step=0.005, **how), nominal(step=0.005, **how))
    for dynamics in ("compiled", "aba"):
        found, plain = markers(off, dynamics=dynamics), nominal(dynamics=dynamics)
        # a muscle that remembers, or is late, is given its command in shorter cells, and those may be summed in another order
        in_cells = effect.memories or effect.acts_through("command_delay")
        assert distance(found, plain) < 1e-12 if in_cells else np.array_equal(found, plain)
    assert distance(markers(short(effect)), nominal()) > 1e-4


def dissipates_on_closed_paths(effect):
    rng = np.random.default_rng(1)
    coarse = np.cumsum(rng.normal(size=40))
    coarse = 1.5 * (coarse - coarse[0]) / np.abs(coarse - coarse[0]).max()
    path = np.interp(np.linspace(0, 40, 4001), np.arange(41), [*coarse, 0.0])  # [rad] from the straight pose and back
    for step in (1e-4, 1e-2, 1.0):
        memory, work, turnover = (0.0,) * effect.states, 0.0, 0.0
        for start, end in itertools.pairwise(path):
            before, rate = memory, (end - start) / step
            memory = tuple(effect.update(effect.p, k, z, start, end, step) for k, z in enumerate(memory))
            ends = [Bending(angle, rate, 1.0, 1.0, 0.5, z) for angle, z in ((start, before), (end, memory))]
            part = (end - start) * sum(effect.moment(effect.p, bending) for bending in ends) / 2
            work, turnover = work + part, turnover + abs(part)
        assert work > -1e-4 * turnover


def loses_energy_in_free_motion(effect):
    links, step = 4, 0.005
    time = np.arange(301) * step
    free = Scenario(
        ArmSpecification(links=links, placement="mid"), time, 0 * time, Pose(np.linspace(0.1, 0.35, links)), (effect,)
    )
    run = simulate(free, dynamics="compiled", step=step).trajectory
    batch = ArmBatch.of([free])
    system = batch.pinocchio("aba")
    model, data = system.models[0], system.data[0]
    energy, moments = [], []
    memory, before = np.zeros((batch.states, 1, links)), np.zeros((1, links))
    for n, (q, v) in enumerate(zip(run.joint_angles, run.joint_rates, strict=True)):
        here, moment, after = q[None], np.zeros((1, links)), memory.copy()
        update_states(system, memory, before, here, step if n else math.inf, after)
        add_joint_moments(system, here, v[None], after, moment)
        moments.append(moment[0])
        gravity, kinetic = pin.computePotentialEnergy(model, data, q), pin.computeKineticEnergy(model, data, q, v)
        energy.append(gravity + kinetic + batch.arrays.spring[0] @ q**2 / 2)
        memory, before = after, here
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
        return markers(scenario(guess, links=6), step=0.01).ravel()

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
    memory = np.zeros((effect.states, 3))
    path = np.cumsum(rng.normal(size=(2000, 3)), axis=0)
    path *= 3 / np.abs(path).max()
    for start, end in itertools.pairwise(path):
        memory = np.array([effect.update(effect.p, k, z, start, end, 0.01) for k, z in enumerate(memory)])
    assert np.all(np.abs(memory) <= 6)
    wild = scenario(effect, arm=ArmSpecification(links=8, placement="mid", bending_limit=20.0))
    wild = replace(wild, torque=2 * np.sign(np.sin(8 * wild.time)))
    for how in ({}, {"step": 0.01}, {"integrator": "extrapolated2", "step": 0.01}):
        run = simulate(wild, dynamics="compiled", **how)
        assert np.abs(run.trajectory.joint_angles.sum(axis=1)).max() < 8


def side_by_side_equals_alone(effect):
    more = [switched_off(effect)]
    for fact in effect.parameters():
        value = getattr(effect, fact.name)
        more.append(with_values(effect, **{fact.name: value + 0.1 * fact.scale * (1 if value < fact.upper else -1)}))
    runs = [short(e) for e in (effect, *more)]
    batch, method = ArmBatch.of(runs), Integrator(step=0.01)
    together = simulate_together(runs, batch, method, "aba").angles
    for b, run in enumerate(runs):
        alone = simulate_together([run], batch.members(slice(b, b + 1)), method, "aba").angles
        np.testing.assert_allclose(together[:, b], alone[:, 0], rtol=0, atol=1e-12)


def holds_a_stuck_pose(effect):
    time = np.arange(6201) * 0.01
    run = simulate(scenario(effect, time=time, torque=np.where(time < 1, 0.8, 0.0)), dynamics="compiled")
    q = run.trajectory.joint_angles
    assert abs(q[-1].sum()) > 5e-3  # [rad] it came to rest away from the straight pose
    assert np.abs(q[-1] - q[200]).max() < 1e-6
    assert np.abs(q[-1] - q[1000]).max() < 1e-12


def rests_in_long_steps(effect):
    time = np.arange(3001) * 0.01
    for links, placement in ((4, "base"), (16, "mid")):
        arm = ArmSpecification(links=links, placement=placement)
        for torque in (np.full(3001, 1.0), np.where(time < 1, 0.8, 0.0)):
            held = scenario(effect, arm=arm, time=time, torque=torque, start=Settled(torque[0]))
            run = simulate_together([held], ArmBatch.of([held]), Integrator(), "compiled")
            later = run.steps.cumsum() > 15
            assert later.sum() < 1.5 * 15 / LONGEST
            assert np.abs(run.angles[-1] - run.angles[1500]).max() < 1e-6


def default_tolerance_is_kept(effect):
    exact = markers(scenario(effect), integrator="extrapolated2", step=5e-5)
    error = np.linalg.norm(markers(scenario(effect)) - exact, axis=-1)
    assert error.max() < LARGEST_ERROR.get(effect.name, 1e-4)  # [m]
    assert np.sqrt(np.mean(error**2)) < LARGEST_ERROR.get(effect.name, 1e-4) / 4


def static_start_is_where_slow_loading_ends(effect):
    time = np.arange(5001) * 0.01
    loaded = markers(scenario(effect, time=time, torque=0.6 * np.minimum(1, time / 10)))
    started = markers(scenario(effect, time=time, torque=np.full(5001, 0.6), start=Settled(0.6)))
    assert distance(started, started[0]) < 1e-9
    assert distance(loaded[-1], started[0]) < 1e-4


def links_do_not_matter(effect):
    change = [markers(scenario(effect, links=n)) - markers(scenario(links=n)) for n in (4, 16)]
    assert np.sqrt(np.mean((change[0] - change[1]) ** 2)) < 0.1 * np.sqrt(np.mean(change[1] ** 2)) + 2e-5


# --- every effect keeps them ----------------------------------------------------------------------------------------------------


def test_every_effect_has_an_example_and_every_option_too():
    assert {effect.name for effect in EXAMPLES} == {*EFFECTS, *FLEXIBLE}
    seen = {(effect.name, effect.options) for effect in EXAMPLES}
    assert seen == {(kind.name, tuple(variant.items())) for kind in (EFFECTS | FLEXIBLE).values() for variant in kind.variants()}


@each_effect
def test_the_neutral_value_gives_the_nominal_model_exactly(effect):
    neutral_is_nominal(effect)


@pytest.mark.parametrize("effect", [e for e in PASSIVE if e.acts_through("moment")], ids=repr)
def test_a_passive_law_takes_work_on_any_closed_path(effect):
    dissipates_on_closed_paths(effect)


@pytest.mark.parametrize("effect", [e for e in PASSIVE if not e.acts_through("obstacle")], ids=repr)
def test_a_freely_moving_arm_with_a_passive_law_loses_energy(effect):
    loses_energy_in_free_motion(effect)


#: A stop half-way does much the same as a softer one elsewhere: one motion tells its numbers only together. An obstacle that the
#: arm does not touch with the initial values has no derivatives there.
TOLD = [
    effect
    for effect in EXAMPLES
    if not (effect.flexible or effect.acts_through("obstacle") or (effect.name == "restraint" and effect.at < 1))
]


@pytest.mark.parametrize("effect", TOLD, ids=repr)
def test_parameters_are_recovered_from_data_made_with_them(effect):
    own_parameters_are_recovered(effect)


@each_effect
def test_states_and_angles_stay_bounded_under_violent_reversals(effect):
    state_stays_bounded(effect)


@each_effect
def test_columns_side_by_side_are_each_what_they_are_alone(effect):
    side_by_side_equals_alone(effect)


@pytest.mark.parametrize("effect", STICKING, ids=repr)
def test_a_stuck_pose_holds_for_a_minute(effect):
    holds_a_stuck_pose(effect)


@each_effect
def test_the_default_tolerance_is_kept(effect):
    default_tolerance_is_kept(effect)


@pytest.mark.parametrize("effect", [*LASTING, *STEEPEST], ids=repr)
def test_an_arm_at_rest_takes_long_steps_and_stays(effect):
    rests_in_long_steps(effect)


@pytest.mark.parametrize("effect", [effect for effect in EXAMPLES if effect.name != "marker_offset"], ids=repr)
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
    level: float = amplitude(0.1, "1", lower=-9.0, upper=9.0, description="")

    @staticmethod
    def moment(p, bending):
        return p.level * bending.keq * bending.angle


class NeverOff(Bad):
    def stiffness(self, s):
        return 1 + 1e-9 + 0 * s


class Pump(Bad):
    @staticmethod
    def moment(p, bending):
        return -p.level * bending.keq * bending.rate


@dataclass(frozen=True)
class Twins(Bad):
    other: float = shape(1.0, 0.1, "1", lower=0.0, upper=9.0, description="")

    @staticmethod
    def moment(p, bending):
        return p.other * p.level * bending.keq * bending.angle


class Heap(Bad):
    states = 1

    @staticmethod
    def moment(p, bending):
        return p.level * 1e-3 * bending.memory[0]

    @staticmethod
    def update(p, k, memory, start, end, elapsed):
        return memory + np.abs(end - start)


class Gossip(Bad):
    @staticmethod
    def moment(p, bending):
        return Bad.moment(p, bending).mean(axis=0) + 0 * bending.angle


class Steep(Bad):
    def tangent(self, keq, length):
        return self.level * keq / 2, 0.0


class Leak(Bad):
    states = 1

    @staticmethod
    def moment(p, bending):
        return p.level * bending.keq * bending.memory[0]

    @staticmethod
    def update(p, k, memory, start, end, elapsed):
        return limited(memory + end - start, 0.1) * np.exp(-min(elapsed, 1e3) / 50)


class Harsh(Bad):
    @staticmethod
    def moment(p, bending):
        return p.level * bending.keq * np.sign(bending.rate)


class PerJoint(Bad):
    def stiffness(self, s):
        return 1 + 4 * self.level / len(s) + 0 * s


class Unsettled(Viscoelastic):
    @staticmethod
    def update(p, k, memory, start, end, elapsed):
        x = min(elapsed, 0.01) / p.time_constant
        return memory * np.exp(-x) - (end - start) * np.expm1(-x) / x


@pytest.mark.parametrize(
    ("promise", "effect"),
    [
        (neutral_is_nominal, NeverOff(0.1)),
        (dissipates_on_closed_paths, Pump(0.1)),
        (loses_energy_in_free_motion, Pump(0.2)),
        (own_parameters_are_recovered, Twins(0.2, 0.5)),
        (state_stays_bounded, Heap(0.1)),
        (side_by_side_equals_alone, Gossip(0.2)),
        (holds_a_stuck_pose, Leak(1.0)),
        (rests_in_long_steps, Steep(9.0)),
        (default_tolerance_is_kept, Harsh(0.3)),
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
        side_by_side_equals_alone,
        default_tolerance_is_kept,
        static_start_is_where_slow_loading_ends,
        links_do_not_matter,
    ],
)
def test_the_fabricated_laws_fail_for_their_own_fault(promise):
    """The harmless spring that they are made of keeps the promises."""
    promise(Bad(0.2))
