"""The other forms of laws agree with their sources in known limits; none is the form of the catalogue."""

from __future__ import annotations

from collections import Counter
from dataclasses import fields, replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

from hsr_pin.blind.kinds import KINDS, kinds_of
from hsr_pin.blind.plants import laws
from hsr_pin.blind.plants.arm import Arm
from hsr_pin.blind.plants.chain import ChainPlant, build
from hsr_pin.blind.plants.laws.dissipative import Hysteresis
from hsr_pin.blind.plants.laws.forms import actuation, damping, elastic, friction, mounting
from hsr_pin.blind.plants.laws.forms.scale import SCALES
from hsr_pin.blind.plants.laws.law import Joints, State
from hsr_pin.blind.plants.program import Program, program
from hsr_pin.errors import EffectError

TRIAL = replace(program().trials[2], command=(0.0,) * 5 + (1.0,) * 36, duration=0.4)
SHORT = Program("hanging", (TRIAL,))
PLANT = ChainPlant(elements=8, step=5e-4)
JOINTS = Joints(np.array([0.5]), 1.11, np.array([1.11]))
S = (np.arange(1000) + 0.5) / 1000
TIME = np.arange(-100, 20000) * 1e-4
STEP = np.where(TIME >= 0, 1.0, 0.0)


def watched(*effects):
    return PLANT.watch(SHORT, effects)[0]


def state(bend: float, rate: float = 0.0, dt: float = 1e-3, tau: float = 0.0) -> State:
    return State(np.array([bend]), np.array([rate]), 0.0, dt, 0.0, tau, False)


def driven(law, path, dt=1e-3):
    """Return the moment along a path of bending."""
    memory, out = law.memory(JOINTS), []
    for bend, step in zip(path[:-1], np.diff(path), strict=True):
        moment, memory = law.moment(JOINTS, state(bend, step / dt, dt), memory)
        out.append(moment[0])
    return np.array(out)


def swing(centre: float, width: float, cycles: float, start: float = 0.0):
    """Return a sinusoidal path, after a ramp from ``start``."""
    way = np.linspace(start, centre - width, 500)
    return np.concatenate([way, centre - width * np.cos(np.linspace(0, 2 * np.pi * cycles, int(1000 * cycles)))[1:]])


def loop(law, path, dt=1e-3):
    """Return the work dissipated in the last full cycle."""
    return float(np.sum((driven(law, path, dt) * np.diff(path))[-1000:]))


def test_every_law_of_the_catalogue_has_two_other_forms_or_more():
    forms = Counter(name.partition(":")[0] for name in laws.FORMS)
    assert set(forms) == set(laws.CATALOGUE)
    assert min(forms.values()) >= 2
    assert len(set(laws.FORMS.values())) == len(laws.FORMS)


@pytest.mark.parametrize("name", [*laws.CATALOGUE, *laws.OUTSIDE, *laws.FORMS, *laws.PARAMETERS])
def test_every_law_has_a_kind(name):
    assert kinds_of(name) and set(kinds_of(name)) <= set(KINDS)


NEW = [*laws.FORMS, *laws.PARAMETERS, "camera_scale", "marker_slip"]


@pytest.mark.parametrize("name", NEW)
def test_at_zero_it_is_neutral(name):
    law = laws.draw(name, np.random.default_rng(4)).scaled(0.0)
    assert np.allclose(watched(law), watched(), atol=1e-9)


@pytest.mark.parametrize("name", [name for name in NEW if name != "bending_stop:gradual"])  # beyond the short step
def test_drawn_and_twice_as_strong_it_moves_the_arm(name):
    law = laws.draw(name, np.random.default_rng(4)).scaled(2.0)
    law = replace(law, way=1) if "one_way" in name else law  # the short step moves in one direction
    assert np.abs(watched(law) - watched()).max() > 2e-4


@pytest.mark.parametrize("name", [name for name, law in laws.FORMS.items() if "scale" in {f.name for f in fields(law)}])
def test_sizes_stay_or_go_with_stiffness_or_damping(name):
    drawn = {laws.draw(name, np.random.default_rng(seed)).scale for seed in range(30)}
    assert len(drawn) >= 2 and drawn <= set(SCALES)
    with pytest.raises(EffectError, match="stays or stiffness or damping"):
        replace(laws.draw(name, np.random.default_rng(0)), scale="mass")


def test_a_size_grows_with_its_scale():
    def moment(scale, keq, c):
        joints = Joints(np.array([0.5]), keq, np.array([keq]), c)
        return elastic.Quintic(0.1, scale).moment(joints, state(1.0), np.zeros(1))[0][0]

    low = moment("stays", 1.11, 0.05)
    assert moment("stays", 2.33, 0.10) == pytest.approx(low)
    assert moment("stiffness", 2.33, 0.10) == pytest.approx(low * 2.33 / 1.11)
    assert moment("damping", 2.33, 0.10) == pytest.approx(low * 2)


# Elastic.


@pytest.mark.parametrize("law", [elastic.TaperedRadius(0.5), elastic.TwoSections(0.8), elastic.TwoSections(-0.8, 0.4)])
def test_a_gradient_in_any_form_keeps_the_compliance_of_the_whole(law):
    assert np.mean(1 / law.stiffness(S)) == pytest.approx(1.0, rel=2e-3)


def test_a_box_has_edges_and_a_crack_a_peak():
    box = elastic.BoxSpot(0.4, 0.5, 0.1).stiffness(S)
    assert set(np.round(box, 12)) == {0.6, 1.0} and np.mean(box < 1) == pytest.approx(0.2, abs=2e-3)
    crack = elastic.CrackedSpot(0.4, 0.5, 0.05).stiffness(S)
    assert crack.min() == pytest.approx(0.6, rel=1e-2) and np.all(np.diff(crack)[:499] < 0)


def test_a_quintic_spring_grows_with_the_fifth_power_and_a_saturating_one_levels_off():
    quintic, level = elastic.Quintic(0.1), elastic.Saturating(0.5, 0.3)
    one, two = (quintic.moment(JOINTS, state(b), np.zeros(1))[0][0] for b in (0.5, 1.0))
    assert two / one == pytest.approx(32)
    assert level.moment(JOINTS, state(100.0), np.zeros(1))[0][0] == pytest.approx(0.5 * 1.11 * 100, rel=1e-3)


def test_an_impact_stop_takes_energy_and_never_pulls():
    law = elastic.ImpactStop(5.0, 0.3, 0.5)
    assert law.moment(JOINTS, state(0.29, 1.0), np.zeros(1))[0][0] == 0.0
    moments = [law.moment(JOINTS, state(0.5, rate), np.zeros(1))[0][0] for rate in (-50.0, -1.0, 0.0, 1.0)]
    assert moments[0] == 0.0 and np.all(np.diff(moments) > 0)
    assert law.moment(JOINTS, state(-0.5, 0.0), np.zeros(1))[0][0] == -moments[2]


def test_a_gradual_stop_is_soft_at_its_angle_linear_beyond_and_on_one_side():
    law = elastic.GradualStop(2.0, 0.5, 0.05)
    m = [law.moment(JOINTS, state(b), np.zeros(1))[0][0] for b in (-0.9, 0.5, 0.9, 1.0)]
    assert m[0] == pytest.approx(0.0, abs=1e-9) and m[1] > 0.05
    assert (m[3] - m[2]) / 0.1 == pytest.approx(2.0 * 1.11, rel=1e-3)


def test_smooth_play_has_no_stiffness_at_the_middle_and_gives_way_by_half_its_gap():
    law = elastic.SmoothPlay(0.2)
    total = [1.11 * b + law.moment(JOINTS, state(b), np.zeros(1))[0][0] for b in (0.001, 1.0)]
    assert total[0] < 1.11 * 0.001 * 1e-3
    assert total[1] == pytest.approx(1.11 * 0.9)


def test_local_play_is_only_where_links_are_worn():
    joints = Joints(S, 1.0, np.ones_like(S))
    moment, _ = elastic.LocalPlay(0.2, 0.3, 0.1).moment(joints, State(np.ones_like(S), 0 * S, 0.0, 1e-3, 0.0, 0.0, False), 0 * S)
    assert set(np.round(moment, 12)) == {-0.1, 0.0} and np.mean(moment < 0) == pytest.approx(0.2, abs=2e-3)


# Friction.


def test_stribeck_friction_breaks_away_above_the_level_that_it_slides_at():
    law = friction.StribeckFriction(0.1, 1.6, 0.3)
    slow = driven(law, np.linspace(0, 0.1, 20000), 1e-3)  # 5e-3 rad/s
    fast = driven(law, np.linspace(0, 3.0, 2000), 1e-3)
    assert slow[-1] == pytest.approx(1.6 * 0.111, rel=1e-3)
    assert fast[-1] == pytest.approx(0.111, rel=1e-3)


@pytest.mark.parametrize(
    "law", [friction.StribeckFriction(0.1), friction.LoadFriction(0.5, 0.2), friction.BaseFriction(0.2), friction.Preisach(0.5)]
)
def test_friction_holds_a_constant_bending(law):
    path = np.concatenate([np.linspace(0, 0.5, 500), np.full(5000, 0.5)])
    moment = driven(law, path)
    assert moment[499:].std() < 1e-9 and moment[-1] > 0.02


def test_load_friction_grows_with_the_torque_and_base_friction_falls_along_the_arm():
    law = friction.LoadFriction(0.1, 0.2)
    idle, loaded = (law.moment(JOINTS, state(0.0, 10.0, tau=tau), np.array([0.005]))[0][0] for tau in (0.0, -1.0))
    assert loaded - idle == pytest.approx(0.1)
    joints = Joints(S, 1.11, np.ones_like(S))
    slide = State(0 * S, 0 * S + 10.0, 0.0, 1e-3, 0.0, 0.0, False)
    moment, _ = friction.BaseFriction(0.1, 2.0).moment(joints, slide, 0 * S + 0.005)
    assert moment[-1] / moment[0] == pytest.approx(np.exp(-2.0), rel=1e-2)


@pytest.mark.parametrize(
    "law", [friction.Preisach(0.5, 0.8, 0.4), friction.SkewedLoop(0.5, 0.15, 0.4), friction.BaseFriction(0.1)]
)
def test_a_loop_takes_energy_and_knows_no_rate(law):
    path = swing(0.0, 0.4, 4)
    assert loop(law, path) > 0
    assert loop(law, path, 1e-3) == pytest.approx(loop(law, path, 1e-2), rel=1e-6)


def test_a_minor_loop_of_preisach_stays_where_history_has_put_it_and_that_of_bouc_and_wen_drifts():
    def apart(law):
        up, down = (driven(law, np.concatenate([np.linspace(0, far, 800), swing(0.0, 0.1, 8, far)])) for far in (0.7, -0.7))
        return (
            (up[-1000:].mean() - down[-1000:].mean()) / (up[2300:3300].mean() - down[2300:3300].mean()),
            up[-1000:],
            down[-1000:],
        )

    kept, up, down = apart(friction.Preisach(0.5, 0.8, 0.4))
    assert kept == pytest.approx(1.0, abs=0.1)
    assert np.allclose(up - up.mean(), down - down.mean(), atol=0.02 * np.ptp(up))  # congruent
    assert apart(Hysteresis(0.5, 0.5))[0] < 0.5


def test_a_skewed_loop_is_higher_on_one_side():
    law = friction.SkewedLoop(0.5, 0.1, 0.4)
    moment = driven(law, swing(0.0, 1.0, 3))
    assert -moment.min() / moment.max() == pytest.approx(1.4 / 0.6, rel=0.02)


# Creep and damping.


def test_three_branches_relax_each_in_its_time():
    law, times = damping.Relaxations(0.3, 0.4, 6.0), 0.4 * 6.0 ** np.array([-1.0, 0.0, 1.0])
    memory = np.zeros((3, 1))
    for _ in range(500):
        moment, memory = law.moment(JOINTS, state(1.0), memory)
    assert moment[0] == pytest.approx(0.3 * 1.11 * np.exp(-0.5 / times).mean())


def test_a_power_law_creeps_in_every_decade():
    law, memory, left = damping.PowerLawCreep(0.4, 0.3), np.zeros((8, 1)), {}
    for k in range(1, 10001):
        moment, memory = law.moment(JOINTS, state(1.0, dt=1e-3), memory)
        left[k] = moment[0]
    falls = [left[10] - left[100], left[100] - left[1000], left[1000] - left[10000]]
    assert min(falls) > 0.1 * 0.4 * 1.11


def test_damping_grows_with_its_power_and_one_way_damping_acts_one_way():
    power, one_way = damping.PowerDamping(0.5), damping.OneWayDamping(0.5, -1)
    assert power.viscous(JOINTS, state(0.0, 4.0)) / power.viscous(JOINTS, state(0.0, 1.0)) == pytest.approx(2.0)
    assert one_way.viscous(JOINTS, state(0.0, 4.0))[0] == 0.0
    assert one_way.viscous(JOINTS, state(0.0, -4.0))[0] == pytest.approx(4 * 0.5 * 0.05)


@pytest.mark.parametrize("law", [damping.CuffDamping(3.0, 0.3, 1), damping.ExponentialDamping(-1.5)])
def test_damping_along_the_arm_keeps_its_mean(law):
    assert law.damping(S).mean() == pytest.approx(1.0, rel=1e-3)


# Actuation.


def reached(out, share):
    return float(TIME[np.argmax(out >= share)])


def test_a_second_order_lag_starts_flat_and_rings_when_lightly_damped():
    out = actuation.SecondOrderLag(0.02, 1.0).command(STEP, TIME, 1.11, 0.0)
    exact = 1 - (1 + TIME / 0.02) * np.exp(-TIME / 0.02)
    assert np.allclose(out[101:], exact[101:], atol=1e-6)
    assert actuation.SecondOrderLag(0.02, 0.5).command(STEP, TIME, 1.11, 0.0).max() == pytest.approx(1.163, abs=1e-3)
    assert reached(actuation.SecondOrderLag(0.02, scale="stiffness").command(STEP, TIME, 2.22, 0.0), 0.5) == pytest.approx(
        2 * reached(out, 0.5), rel=1e-2
    )


def test_filling_and_venting_take_their_own_times():
    law = actuation.UnequalLag(0.1, 3.0)
    rise = law.command(STEP, TIME, 1.11, 0.0)
    fall = law.command(1 - STEP, TIME, 1.11, 0.0)
    assert reached(rise, 1 - np.exp(-1)) == pytest.approx(0.1, abs=1e-3)
    assert float(TIME[np.argmax(fall <= np.exp(-1))]) == pytest.approx(0.3, abs=1e-3)
    assert np.allclose(law.command(-STEP, TIME, 1.11, 0.0), -rise)


def test_a_choked_lag_ramps_first_and_then_approaches():
    out = actuation.ChokedLag(0.1, 0.9).command(STEP, TIME, 1.0, 0.0)
    ramp = np.diff(out[(out > 0.05) & (out < 0.5)]) / 1e-4
    assert np.allclose(ramp, 0.9 / 0.3, rtol=1e-6)
    assert 0 < 1 - out[-1] < 1e-5 and np.all(np.diff(out) >= 0)


def test_jitter_keeps_the_order_and_the_mean_delay():
    ramp = np.floor(np.maximum(TIME, 0.0) * 100 + 1e-6)  # a new value every 10 ms
    out = actuation.JitteredDelay(0.05, 0.9, 3).command(ramp, TIME, 1.11, 0.0)
    assert np.all(np.diff(out) >= 0)
    late = (ramp - out)[5000:].mean() / 100
    assert 0.05 < late < 0.08  # commands wait for one another
    waits = np.diff(np.flatnonzero(np.diff(out) > 0))
    assert waits.std() > 20  # in tenths of a millisecond; without jitter each would be 100


def test_a_restarted_clock_delays_every_trial_by_a_time_of_its_own():
    law = actuation.RestartedDelay(0.05, 0.6, 3)
    delays = [reached(law.command(STEP, TIME, 1.11, clock), 0.5) for clock in (0.0, 22.0, 44.0, 66.0)]
    assert len(set(delays)) == 4 and all(0.02 <= delay <= 0.08 for delay in delays)
    assert law.command(STEP, TIME, 1.11, 22.0) == pytest.approx(law.command(STEP, TIME, 1.11, 22.0))


def test_a_drifting_bias_comes_with_the_session_and_a_partial_one_acts_on_a_part():
    law = actuation.DriftingBias(0.1, 30.0)
    first, last = (law.command(0 * STEP, TIME, 1.11, clock)[-1] for clock in (0.0, 300.0))
    assert first < 0.05 and last == pytest.approx(0.1, rel=1e-3)
    joints = Joints(S, 2.22, np.ones_like(S))
    still = State(0 * S, 0 * S, 0.0, 1e-3, 0.0, 0.0, False)
    moment, _ = actuation.PartialBias(0.1, 0.4, "stiffness").moment(joints, still, 0 * S)
    assert set(np.round(moment, 12)) == {0.0, -0.2} and np.mean(moment < 0) == pytest.approx(0.6, abs=2e-3)


def test_maps_saturate_above_or_start_late():
    tau = np.array([-50.0, 0.01, 1.0, 50.0])
    top = actuation.SaturatingMap(0.5).command(tau, tau, 1.0, 0.0)
    assert top == pytest.approx([-2.0, 0.01, 2 * np.tanh(0.5), 2.0], rel=1e-4)
    late = actuation.ThresholdMap(0.1).command(tau, tau, 1.0, 0.0)
    assert late[1] < 1e-4 and late[3] == pytest.approx(49.9)


def test_short_muscles_leave_the_tip_bare_and_a_parabola_falls_faster_there():
    assert np.mean(actuation.ShortMuscles(0.3).torque(S)) == pytest.approx(0.7, rel=1e-2)
    assert actuation.ShortMuscles(0.3).torque(np.array([0.9]))[0] == 0.0
    assert actuation.ParabolicTorque(0.4).torque(np.array([0.0, 1.0])) == pytest.approx([1.0, 0.6])


# Mounts, masses, markers.


@pytest.mark.parametrize(
    ("law", "mass", "moment"),
    [
        (mounting.Ring(0.05, 0.8), 0.05, 0.05 * 0.8),
        (mounting.Overhang(0.05, 0.2), 0.05, 0.05 * 1.2),
        (mounting.HalfHose(0.06, 0.0, 0.6), 0.06, 0.06 * 0.3),
        (mounting.GrowingMass(0.03), 0.03, 0.03 * 2 / 3),
    ],
)
def test_a_mass_is_all_there_and_where_it_should_be(law, mass, moment):
    def first_moments(arm):
        model = build(arm, np.full(24, 1.11), np.full(24, 0.05), 1e-3)
        import mujoco

        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        return np.array([model.body_mass.sum(), model.body_mass @ data.xipos[:, 2] / arm.length])

    found = first_moments(law.arm(Arm(), TRIAL)) - first_moments(Arm())
    assert found == pytest.approx([mass, moment], rel=2e-2)


def test_a_mount_sags_or_is_clamped_anew():
    early, late = (mounting.SaggingMount(0.1, 30.0).arm(Arm(), replace(TRIAL, clock=clock)).tilt for clock in (0.0, 300.0))
    assert early == pytest.approx(0.03) and late == pytest.approx(0.1, rel=1e-3)
    low, high = (mounting.Remounted(0.1, 0.3).arm(Arm(), replace(TRIAL, keq=keq)).tilt for keq in (1.11, 2.33))
    assert (low, high) == (pytest.approx(0.1), pytest.approx(0.03))


def test_plates_are_uneven_and_a_sleeve_slides_back_as_the_arm_bends():
    angle = np.array([0.0, 1.0])
    assert [mounting.UnevenPlates(0.01, 1.0).shift(s, angle)[1][0] for s in (0.0, 1.0)] == pytest.approx([0.005, 0.015])
    along, off = mounting.SlidingSleeve(-0.01, 0.5, 0.4).shift(1.0, angle)
    assert along == pytest.approx([0.0, -0.004]) and off == pytest.approx([-0.01, -0.015])
