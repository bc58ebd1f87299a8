"""Each law is what its equation says: closed forms, one by one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp, trapezoid

from hsr_pin.effects import EFFECTS, parse_effect
from hsr_pin.effects.dry_friction import presliding
from hsr_pin.effects.effect import Bending, stack
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation import reference
from hsr_pin.simulation.arm_batch import ArmBatch, along
from hsr_pin.simulation.command import deliver
from hsr_pin.simulation.scenario import Marker, Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.simulate import simulate

KEQ = 2.0
S = np.linspace(0, 1, 20001)[:, None]


def moment(effect, angle, rate=0.0, memory=None, stiffness=1.0):
    """[N m] over Keq, for angles of any shape."""
    angle = np.atleast_1d(np.asarray(angle, dtype=float))
    memory = (0 * angle,) * effect.states if memory is None else memory
    return effect.moment(effect.p, Bending(angle, rate + 0 * angle, KEQ, stiffness, 0.5, memory)) / KEQ


def updated(effect, memory, start, end, elapsed):
    """What a law remembers after a path."""
    return tuple(effect.update(effect.p, k, z, start, end, elapsed) for k, z in enumerate(memory))


def walked(effect, path, step=0.01):
    """The first state after a path of angles from the virgin state, and the moment over Keq at every point of it."""
    memory, moments = (0.0,) * effect.states, []
    for start, end in zip([0.0, *path[:-1]], path, strict=True):
        memory = updated(effect, memory, start, end, step)
        moments.append(moment(effect, end, memory=memory).item())
    return memory[0], np.array(moments)


def delivered(effect, torque, step=0.01, initial=0.0):
    """(S,) the mean over each step, of a command that was ``initial`` before."""
    batch = ArmBatch.of([Scenario(ArmSpecification(keq=KEQ), [0.0, step], [0.0, 0.0], effects=(effect,))])
    held = np.append(torque, 0.0)[:, None]
    impulse = deliver(batch, held, np.array([initial]), step).impulse[0]
    return np.diff(impulse[:: (len(impulse) - 1) // len(torque)]) * len(torque) / (len(impulse) - 1)


def answers(effect, torque, steps, initial=0.0):
    """(S,) the mean over steps of any length, of a law with memory."""
    memory, means = (initial,) * effect.memories, []
    for held, step in zip(torque, np.broadcast_to(steps, len(torque)), strict=True):
        mean, memory = effect.actuator_response(effect.p, held, memory, step, KEQ)
        means.append(mean)
    return np.array(means)


@pytest.mark.parametrize("slope", [-1.8, -0.5, -2e-3, -1e-9, 0.0, 1.9e-3, 2.1e-3, 1.0, 1.8])
def test_a_stiffness_gradient_keeps_the_series_stiffness(slope):
    k = EFFECTS["stiffness_gradient"](slope).stiffness(S)[:, 0]
    assert simpson(1 / k, x=S[:, 0]) == pytest.approx(1, abs=1e-8)
    assert k[-1] / k[0] == pytest.approx((2 + slope) / (2 - slope))


def test_a_stiffness_gradient_keeps_the_series_stiffness_of_the_chain():
    for links in (1, 4, 10):
        k = along((EFFECTS["stiffness_gradient"](1.5),), "stiffness", links)
        assert np.mean(1 / k) == pytest.approx(1, abs=1e-9)


def test_a_soft_spot_takes_its_depth_at_its_centre_and_adds_the_same_compliance_to_any_chain():
    spot = EFFECTS["soft_spot"](0.6, 0.4, 0.1)
    assert spot.stiffness(np.array([[0.4]])).item() == pytest.approx(0.4)
    assert spot.stiffness(np.array([[0.5]])).item() == pytest.approx(1 - 0.6 * math.exp(-0.5))
    compliance = simpson(1 / spot.stiffness(S)[:, 0], x=S[:, 0])
    for links in (2, 5, 16):
        assert np.mean(1 / along((spot,), "stiffness", links)) == pytest.approx(compliance, abs=1e-6)


def test_stiffening_is_cubic_where_arms_work():
    angle = np.linspace(-1.2, 1.2, 25)
    for cubic in (-0.15, 0.1, 3.0):
        np.testing.assert_allclose(moment(EFFECTS["stiffening"](cubic), angle, stiffness=0.7), 0.7 * cubic * angle**3, atol=1e-14)


@pytest.mark.parametrize("cubic", [-1.0, -0.15, 0.05, 5.0])
def test_stiffening_leaves_a_fifth_of_the_stiffness_and_is_smooth(cubic):
    angle = np.linspace(-3.5, 3.5, 70001)
    slope = np.gradient(moment(EFFECTS["stiffening"](cubic), angle), angle)[1:-1]
    assert slope.min() > -0.8 - 1e-6 and slope.max() < 20 + 1e-6
    assert np.abs(np.diff(slope)).max() < 0.01


def test_a_stop_acts_beyond_its_angle_only():
    stop = EFFECTS["bending_stop"](4.0, 0.5)
    np.testing.assert_allclose(moment(stop, [-0.7, -0.5, 0.0, 0.3, 0.6]), [-0.8, 0, 0, 0, 0.4], atol=1e-15)


def test_backlash_leaves_a_dead_zone_and_the_spring_beyond_it():
    angle = np.array([-0.5, -0.1, 0.0, 0.15, 0.4])
    total = 1.3 * angle + moment(EFFECTS["backlash"](0.3), angle, stiffness=1.3)
    np.testing.assert_allclose(total, 1.3 * np.array([-0.35, 0, 0, 0, 0.25]), atol=1e-15)


def test_friction_slides_at_its_level_and_needs_twice_the_presliding_angle_to_turn_round():
    friction = EFFECTS["dry_friction"](0.2)
    d = presliding(0.2)
    _, m = walked(friction, [d / 2, d, 1.0, 1.0 - d, 1.0 - 2 * d, 0.3])
    np.testing.assert_allclose(m, [0.1, 0.2, 0.2, 0, -0.2, -0.2], atol=1e-12)


def test_friction_under_load_holds_and_slides_at_a_level_that_grows_with_bending():
    friction = EFFECTS["dry_friction"](0.2, form="load")
    d = presliding(0.2)
    _, m = walked(friction, [d / 10, 0.3, 1.0, 1.0 - d, -1.0, -0.3])
    np.testing.assert_allclose(m, [0.2 / 10, 0.2 * 0.5, 0.2 * 1.2, 0.2 * 0.2, -0.2 * 1.2, 0.2 * 0.5], atol=1e-12)
    steepest = friction.tangent(1.0, 1.0)[0]
    assert steepest == EFFECTS["dry_friction"](0.2).tangent(1.0, 1.0)[0]  # what is stuck gives as much under any load


def test_friction_takes_four_levels_per_unit_of_amplitude_in_a_cycle():
    friction = EFFECTS["dry_friction"](0.2)
    d, path = presliding(0.2), 0.5 * np.sin(np.linspace(0, 4 * np.pi, 40001))
    _, m = walked(friction, path)
    last = slice(20000, None)
    assert trapezoid(m[last], path[last]) == pytest.approx(4 * 0.2 * (0.5 - d), rel=1e-3)


def test_an_arm_with_friction_stays_where_a_small_torque_cannot_slide_it():
    friction = EFFECTS["dry_friction"](0.3)
    arm = ArmSpecification(placement="mid")
    run = simulate(step_scenario(arm, 0.2 * arm.keq, duration=2, effects=(friction,)))
    assert abs(run.trajectory.joint_angles[-1].sum()) < presliding(0.3)


def test_hysteresis_saturates_exponentially_in_the_angle():
    z, m = walked(EFFECTS["hysteresis"](0.4, 0.2), [0.1, 0.3])
    assert z == pytest.approx(1 - math.exp(-1.5))
    assert m[0] == pytest.approx(0.4 * (1 - math.exp(-0.5)))
    z, _ = walked(EFFECTS["hysteresis"](0.4, 0.2), [5.0, 4.9])
    assert z == pytest.approx(-1 + 2 * math.exp(-0.5))


def test_sliders_close_every_inner_loop_where_it_began_and_saturate_at_the_amplitude():
    law = EFFECTS["hysteresis"](0.4, 0.2, form="maxwell_slip")
    _, m = walked(law, [0.15, 0.05, 0.1, 0.05, 0.15, 5.0])
    assert m[1] == pytest.approx(m[3]) and m[0] == pytest.approx(m[4]) and m[2] != pytest.approx(m[1])
    assert m[5] == pytest.approx(0.4)
    _, m = walked(law, [0.02])
    assert m[0] == pytest.approx(0.4 * 0.02 / 0.2)  # none slips yet


@pytest.mark.parametrize("text", ["dry_friction:level=0.3", "dry_friction:level=0.3,form=load", "hysteresis:amplitude=0.3"])
def test_rate_independent_laws_see_the_path_and_not_its_speed_nor_its_sampling(text):
    law = parse_effect(text)
    path = np.array([0.1, 0.5, 0.43, 0.6, -0.2])
    fine = np.interp(np.arange(1, 501) / 100, np.arange(6), [0.0, *path])
    assert walked(law, fine, 1e-4)[0] == pytest.approx(walked(law, path, 10.0)[0], abs=1e-12)
    assert walked(law, path, math.inf)[0] == walked(law, path)[0]


def test_a_maxwell_branch_relaxes_exponentially_and_follows_a_ramp_exactly():
    law = EFFECTS["viscoelastic"](0.5, 0.2)
    path = 3.0 * 0.1 * np.arange(1, 11)  # 3 rad/s for 1 s
    assert walked(law, path, 0.1)[0] == pytest.approx(3.0 * 0.2 * (1 - math.exp(-1 / 0.2)), abs=1e-12)
    assert walked(law, [3.0], 1.0)[0] == pytest.approx(3.0 * 0.2 * (1 - math.exp(-1 / 0.2)), abs=1e-12)
    _, m = walked(law, [1.0, *[1.0] * 40], 1e-9)
    assert m[0] == pytest.approx(0.5, abs=1e-6)
    memory = updated(law, (1.0,), 1.0, 1.0, 0.3)
    assert memory == pytest.approx([math.exp(-1.5)])
    assert updated(law, memory, 0.0, 1.0, math.inf) == (0.0,)


def test_quadratic_damping_is_odd_and_quadratic_up_to_15_rad_per_second_and_then_goes_on_evenly():
    law = EFFECTS["quadratic_damping"](0.02)
    for rate in (-14.0, -1.0, 0.0, 0.5, 15.0):
        assert KEQ * moment(law, 0.3, rate).item() == pytest.approx(0.02 * rate * abs(rate), abs=1e-15)
    assert KEQ * moment(law, 0.3, -20.0).item() == pytest.approx(-0.02 * (225 + 30 * 5))


@pytest.mark.parametrize(("way", "rates"), [("both", (-4.0, 4.0)), ("positive", (0.0, 4.0)), ("negative", (-4.0, 0.0))])
def test_damping_over_rate_is_a_power_in_the_ways_that_it_resists(way, rates):
    law = parse_effect(f"damping_curve:coefficient=0.2,power=2,way={way}")
    resisted = [KEQ * moment(law, 0.3, rate).item() for rate in (-4.0, 4.0)]
    assert resisted == pytest.approx([0.2 * rate * abs(rate) / 9 for rate in rates], abs=1e-15)


def test_a_damping_gradient_keeps_the_mean():
    law = EFFECTS["damping_gradient"](-1.2)
    assert along((law,), "damping", 7).mean() == pytest.approx(1, abs=1e-12)
    np.testing.assert_allclose(law.damping(np.array([[0.0], [1.0]]))[:, 0], [1.6, 0.4])


def test_a_lag_gives_the_mean_of_the_exponential_over_each_step():
    lag, h = 0.03, 0.02
    mean = delivered(EFFECTS["actuator_lag"](lag), [1.0] * 5, h)
    edges = h * np.arange(6)
    integral = edges + lag * np.exp(-edges / lag)  # of 1 - exp(-t / T)
    np.testing.assert_allclose(mean, np.diff(integral) / h, atol=1e-14)


def test_through_an_orifice_a_muscle_is_full_after_a_finite_time():
    """Against the equation, integrated in small steps; the mean over a step in which it becomes full too."""
    T, h, keq = 0.1, 0.02, KEQ
    law = EFFECTS["actuator_lag"](T, "orifice")
    fine = np.empty(30000)
    y = 0.3
    for k in range(len(fine)):
        fine[k] = y
        y += np.sign(1.0 - y) * np.sqrt(keq * abs(1.0 - y)) / T * 1e-5
    means = answers(law, [1.0] * 15, h, initial=0.3)
    np.testing.assert_allclose(means, fine.reshape(15, 2000).mean(axis=1), atol=2e-4)
    full = 2 * T * np.sqrt(0.7 / keq)
    assert np.all(means[int(full / h) + 1 :] == 1.0) and means[int(full / h)] < 1.0
    assert np.all(answers(law, [0.7] * 9, h, initial=0.7) == 0.7)


def test_a_lag_starts_settled_and_takes_each_column_its_own_time():
    laws = stack([EFFECTS["actuator_lag"](t) for t in (0.0, 1e-9, 0.1)])
    torque, memory = np.empty((100, 3)), (np.full(3, 0.5),)
    for n in range(100):
        torque[n], memory = laws.actuator_response(laws.p, np.full(3, 2.0), memory, 0.01, np.full(3, KEQ))
    assert np.all(torque[:, 0] == 2.0)
    np.testing.assert_allclose(torque[:, 1], 2.0, atol=1e-6)
    assert torque[0, 2] < 0.6 and torque[-1, 2] == pytest.approx(2.0, abs=1e-3)
    assert np.all(answers(EFFECTS["actuator_lag"](0.2), [0.7] * 9, 0.01, initial=0.7) == 0.7)


def test_a_dead_time_of_whole_steps_shifts_and_a_part_of_a_step_is_averaged():
    u = [1.0, 3.0, 2.0, 0.0]
    np.testing.assert_allclose(delivered(EFFECTS["dead_time"](0.02), u, initial=9.0), [9, 9, 1, 3], atol=1e-12)
    np.testing.assert_allclose(delivered(EFFECTS["dead_time"](0.0025), u, initial=5.0), [2, 2.5, 2.25, 0.5])
    assert np.all(delivered(EFFECTS["dead_time"](0.5), u, initial=9.0) == 9.0)


def test_steps_of_any_length_give_the_same_mean_of_a_held_command():
    law = EFFECTS["actuator_lag"](0.03)
    held, long = np.array([1.0, 3.0, 2.0, 0.0, 0.0, 5.0]), np.array([0.02, 0.01, 0.005, 0.03, 0.01, 0.02])
    counts = np.array([4, 1, 2, 7, 1, 5])
    fine = answers(law, np.repeat(held, counts), np.repeat(long / counts, counts), initial=2.0)
    means = [part.mean() for part in np.split(fine, counts.cumsum()[:-1])]
    np.testing.assert_allclose(answers(law, held, long, initial=2.0), means, rtol=0, atol=1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.013, 0.02, 0.0305, 0.5])
def test_a_dead_time_shifts_the_integral_of_the_torque(delay):
    torque, step = np.array([1.0, 3.0, 2.0, 0.0, 0.0, 5.0]), 0.02
    edges = step * np.arange(7)
    impulse = np.append(0.0, np.cumsum(torque) * step)
    passed = np.where(edges < delay, (edges - delay) * 2.0, np.interp(edges - delay, edges, impulse))
    found = delivered(EFFECTS["dead_time"](delay), torque, step, initial=2.0)
    np.testing.assert_allclose(found, np.diff(passed) / step, rtol=0, atol=1e-12)


def test_the_torque_changes_evenly_with_a_dead_time_within_a_step():
    late = [delivered(EFFECTS["dead_time"](d), [0.0, 1.0, 4.0, 4.0]) for d in (0.012, 0.013, 0.018)]
    np.testing.assert_allclose((late[1] - late[0]) * 5, late[2] - late[1], atol=1e-12)


def test_a_bias_is_a_shift_of_the_command():
    arm = ArmSpecification()
    biased = simulate(step_scenario(arm, 0.5, duration=1, effects=(EFFECTS["torque_bias"](0.1),)))
    shifted = step_scenario(arm, 0.5, duration=1)
    shifted = type(shifted)(arm, shifted.time, shifted.torque + 0.1, Settled(0.1))
    np.testing.assert_allclose(biased.trajectory.positions, simulate(shifted).trajectory.positions, atol=1e-14)


def test_the_torque_map_bends_the_command_both_ways_alike():
    law = EFFECTS["torque_map"](0.3)
    np.testing.assert_allclose(delivered(law, [1.0, -1.0, 2.0]), [1.15, -1.15, 2.6])
    batch = ArmBatch.of([Scenario(ArmSpecification(keq=KEQ), [0.0, 1.0], [0.0, 0.0], effects=(law,))])
    assert deliver(batch, np.zeros((2, 1)), np.array([2.0]), 1.0).initial == pytest.approx([2.6])  # before the first step too


def test_an_even_torque_map_is_a_parabola():
    law = EFFECTS["torque_map"](0.3, parity="even")
    np.testing.assert_allclose(delivered(law, [1.0, -1.0, 2.0]), [1.15, -0.85, 2.6])


def test_up_to_the_threshold_no_torque_arrives_and_beyond_it_the_rest():
    edge = 0.2 * KEQ
    law = EFFECTS["torque_map"](threshold=0.2)
    np.testing.assert_allclose(
        delivered(law, [0.0, 0.9 * edge, 3 * edge, -0.9 * edge, -3 * edge]), [0, 0, 2 * edge, 0, -2 * edge]
    )


def test_torque_decay_falls_from_base_to_tip():
    drive = along((EFFECTS["torque_decay"](0.4),), "actuation", 4)
    np.testing.assert_allclose(drive[0], 1 - 0.4 * np.array([0.125, 0.375, 0.625, 0.875]))


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
def test_a_tilted_base_is_the_declared_tilt_and_its_own_frame_turns_back_with_it(mount):
    arm = ArmSpecification(mount=mount, placement="mid")
    markers = (Marker("fixed", 0.01), Marker("tip", 0.24))  # the first half link does not move against the base

    def seen(text=None, **declared):
        plain = step_scenario(ArmSpecification(mount=mount, placement="mid", **declared), 0.4, duration=0.5, markers=markers)
        effects = (parse_effect(text),) if text else ()
        return simulate(type(plain)(plain.arm, plain.time, plain.torque, plain.start, effects, markers)).trajectory.positions

    world, base = seen("gravity_tilt:angle=0.2"), seen("gravity_tilt:angle=0.2,frame=base")
    np.testing.assert_allclose(world, seen(tilt=0.2), atol=1e-14)
    np.testing.assert_allclose(base[:, 0], seen()[:, 0], atol=1e-14)
    assert np.abs(world[:, 0] - seen()[:, 0]).max() > 1e-3
    np.testing.assert_allclose(np.linalg.norm(base, axis=-1), np.linalg.norm(world, axis=-1), atol=1e-14)
    cameras = seen("gravity_tilt:angle=0.2,frame=cameras")
    np.testing.assert_allclose(cameras[:, 0], world[:, 0], atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(cameras, axis=-1), np.linalg.norm(seen(), axis=-1), atol=1e-14)
    assert arm.tilt == 0


def test_a_tilt_beyond_half_a_turn_comes_round():
    assert EFFECTS["gravity_tilt"](0.3).arm(ArmSpecification(tilt=3.0)).tilt == pytest.approx(3.3 - 2 * math.pi)


def test_masses_are_added_to_what_was_declared():
    arm = ArmSpecification(mass=0.2, tip_mass=0.05)
    assert EFFECTS["tip_mass"](0.1).arm(arm) == ArmSpecification(mass=0.2, tip_mass=0.05 + 0.1)
    assert EFFECTS["added_mass"](0.1).arm(arm) == ArmSpecification(mass=0.2 + 0.1, tip_mass=0.05)


def _seen(*effects):
    plain = step_scenario(ArmSpecification(placement="mid"), 0.8, duration=0.5)
    return simulate(replace(plain, effects=tuple(map(parse_effect, effects)))).trajectory.positions


def test_markers_are_seen_at_their_offset_across_the_backbone():
    shift = _seen("marker_offset:offset=0.01") - _seen()
    np.testing.assert_allclose(np.linalg.norm(shift, axis=-1), 0.01, atol=1e-15)
    np.testing.assert_allclose(shift[:, 0], [[0.01, 0, 0]] * len(shift), atol=1e-15)  # bends towards +x
    kept = _seen("marker_offset:offset=0.01,base=kept") - _seen()
    assert np.all(kept[:, 0] == 0)
    np.testing.assert_array_equal(kept[:, 1:], shift[:, 1:])


def test_each_marker_is_seen_beside_its_place_by_its_own_distance_and_by_what_bending_adds():
    arm, bend = ArmSpecification(links=3, placement="base"), np.array([0.2, 0.3, -0.1])
    marks = tuple(Marker(f"m{s}", 0.24 * s) for s in (0.0, 0.5, 1.0))  # before the first joint, on the second link, at the tip
    law = parse_effect("marker_profile:across=0.004,taper=-0.003,lift=0.005,slide=0.006")
    plain, seen = (
        simulate(Scenario(arm, [0.0, 1e-4], [0.0, 0.0], Pose(bend), laws, marks)).trajectory.positions[0] for laws in ((), (law,))
    )
    for shift, x, angle in zip((seen - plain)[1:], (0.0, 1.0), (0.5, 0.4), strict=True):
        beside, along = 0.004 - 0.003 * x + 0.005 * angle, 0.006 * angle
        c, s = math.cos(angle), math.sin(angle)
        assert shift == pytest.approx([c * beside + s * along, 0, s * beside - c * along], abs=1e-12)
    assert (seen - plain)[0] == pytest.approx([0.007, 0, 0], abs=1e-12)


def test_a_line_beside_the_one_that_keeps_its_length_is_longer_by_the_depth_times_the_angle():
    arm = ArmSpecification(links=400, placement="mid", mass=1e-6)
    angle, marks = 0.9, tuple(Marker(f"m{k}", 0.24 * k / 40) for k in range(41))
    start = Pose(np.full(400, angle / 400))
    scenario = Scenario(arm, [0.0, 1e-4], [0.0, 0.0], start, (EFFECTS["length_change"](0.02),), marks)
    seen = simulate(scenario).trajectory.positions[0]
    assert np.linalg.norm(np.diff(seen, axis=0), axis=1).sum() == pytest.approx(0.24 + 0.02 * angle, rel=1e-3)
    tangent = seen[-1] - seen[-2]
    assert np.arctan2(tangent[0], -tangent[2]) == pytest.approx(angle, abs=0.02)  # and bent as it was


def test_lengths_are_seen_larger_by_the_scale():
    seen, plain = _seen("camera_scale:scale=0.02"), _seen()
    np.testing.assert_allclose(seen, 1.02 * plain, rtol=1e-12)


def test_a_marker_that_slipped_is_seen_where_the_backbone_is_at_its_own_place():
    arm = ArmSpecification(links=400, placement="mid")
    start, marks = Pose(np.full(400, 1.2 / 400)), tuple(Marker(f"m{s}", 0.24 * s) for s in (0.0, 0.5, 1.0))
    true = tuple(Marker(f"m{s}", 0.24 * s + slip) for s, slip in ((0.0, 0.0), (0.5, -0.003), (1.0, -0.006)))
    between = tuple(Marker(f"m{s}", 0.24 * s + slip) for s, slip in ((0.0, 0.0), (0.5, 0.005), (1.0, 0.0)))

    def seen(marks, *effects):
        return simulate(Scenario(arm, [0.0, 1e-4], [0.0, 0.0], start, effects, marks)).trajectory.positions[0]

    for where, text in ((true, "marker_slip:slip=-0.006"), (between, "marker_slip:slip=0.005,which=between")):
        off = np.linalg.norm(seen(marks, parse_effect(text)) - seen(where), axis=-1)
        assert off.max() < 1e-4 < np.linalg.norm(seen(marks) - seen(where), axis=-1).max()  # the arc, to first order


def test_no_distance_of_a_restraint_is_far_from_one_that_a_first_look_tries():
    # an arm that meets it with its last few millimetres shows nothing of one much nearer or farther
    (distance,) = (fact for fact in EFFECTS["restraint"].parameters() if fact.name == "distance")
    for there in np.geomspace(distance.lower, distance.upper, 40):
        assert min(max(there / tried, tried / there) for tried in distance.start_values) < 1.5


@pytest.mark.parametrize("side", ["positive", "negative"])
def test_a_restraint_holds_the_tip_back_by_the_lever_of_its_force(side):
    sign = 1.0 if side == "positive" else -1.0
    arm, bend = ArmSpecification(links=2, placement="base", keq=KEQ), np.array([0.3, 0.5]) * sign
    restraint = parse_effect(f"restraint:contact_stiffness=100,distance=0.05,side={side}")
    batch = ArmBatch.of([Scenario(arm, [0.0, 0.01], [0.0, 0.0], Pose(bend), (restraint,))])
    system, resisting = batch.pinocchio("aba"), np.zeros((1, 2))
    reference.add_joint_moments(system, bend[None], np.zeros((1, 2)), np.zeros((0, 1, 2)), resisting)
    depth = 0.12 * (math.sin(0.3) + math.sin(0.8)) - 0.05
    force, lever = 100 * (depth - 0.0025), 0.12 * math.cos(0.8)
    assert depth > 0.005
    assert resisting[0] * sign == pytest.approx([force * (lever + 0.12 * math.cos(0.3)), force * lever])
    resisting[:] = 0.0
    reference.add_joint_moments(system, -bend[None], np.zeros((1, 2)), np.zeros((0, 1, 2)), resisting)
    assert not resisting.any()


def test_a_partial_bias_is_there_beyond_its_start_half_there_at_it_and_not_before():
    law = parse_effect("partial_bias:bias=0.3,start=0.6")
    for place, share in ((0.1, 0.0), (0.55, 1 / (1 + math.e)), (0.6, 0.5), (0.95, 1.0)):
        bending = Bending(np.array([-0.4, 0.0, 0.7]), 2.0, KEQ, 1.0, place, ())
        np.testing.assert_allclose(law.moment(law.p, bending), -0.3 * share, rtol=0, atol=0.3 * 1e-3)


@pytest.mark.parametrize("at", [1.0, 0.75, 0.5, 0.3])
def test_a_side_force_bends_the_arm_up_to_where_it_acts_and_no_further(at):
    """Against F (s - s') of a nearly straight arm of length L, in the limit of many links."""
    links, length = 64, 0.24
    arm = ArmSpecification(links=links, placement="mid", keq=KEQ)
    force = parse_effect(f"side_force:force=0.01,at={at}")
    batch = ArmBatch.of([Scenario(arm, [0.0, 0.01], [0.0, 0.0], Pose(np.zeros(links)), (force,))])
    system, resisting = batch.pinocchio("aba"), np.zeros((1, links))
    reference.add_joint_moments(system, np.zeros((1, links)), np.zeros((1, links)), np.zeros((0, 1, links)), resisting)
    places = (np.arange(links) + 0.5) / links
    assert -resisting[0] == pytest.approx(0.01 * length * np.maximum(at - places, 0.0), abs=1e-12)


def test_a_drive_rings_with_its_period_and_its_damping_ratio():
    law = parse_effect("ringing_drive:period=0.2,damping_ratio=0.15")
    step, memory, seen = 0.001, (0.0, 0.0, 0.0), []
    for _ in range(600):
        mean, memory = law.actuator_response(law.p, 1.0, memory, step, KEQ)
        seen.append(mean)
    w, zeta, t = 2 * math.pi / 0.2, 0.15, (np.arange(600) + 0.5) * step
    wd = w * math.sqrt(1 - zeta**2)
    closed = 1 - np.exp(-zeta * w * t) * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
    np.testing.assert_allclose(seen, closed, atol=2e-4)
    plain = parse_effect("ringing_drive:period=0")
    assert plain.actuator_response(plain.p, 0.7, (0.1, 0.1, 0.1), 0.01, KEQ)[0] == 0.7


def test_of_a_partial_lag_a_share_comes_at_once():
    law = parse_effect("partial_lag:time_constant=0.1,at_once=0.25")
    mean, _ = law.actuator_response(law.p, 1.0, (0.0,), 1e-6, KEQ)
    assert mean == pytest.approx(0.25, abs=1e-4)
    mean, _ = law.actuator_response(law.p, 1.0, (0.0,), 100.0, KEQ)
    assert mean == pytest.approx(1.0, abs=1e-3)


def arrived(law, commands, keq=1.0):
    """The torque that arrives for commands that are held one after another, from rest under the first one."""
    memory, arrives = (commands[0],) * law.memories, []
    for command in commands:
        torque, memory = law.actuator_response(law.p, command, memory, 0.01, keq)
        arrives.append(float(torque))
    return np.array(arrives)


def test_the_torque_of_a_cable_falls_while_it_is_pulled_and_stays_and_exceeds_while_it_is_released():
    """Along an arm that is bent by u / Keq, from the differential equation of a belt, dT = -coefficient T dangle."""
    coefficient, conduit = 0.4, 0.2
    law = EFFECTS["capstan_friction"](friction=coefficient, conduit=conduit)
    commands = np.concatenate([np.linspace(0, 1.2, 50), np.linspace(1.2, 0, 50), np.linspace(0, -0.8, 50)])
    arrives = arrived(law, commands)
    for sign, moment in ((-1, 30), (1, 95), (-1, 140)):
        bend = abs(commands[moment])
        belt = solve_ivp(
            lambda s, t, a=bend, w=sign: w * coefficient * a * t, (0, 1), [np.exp(sign * conduit)], rtol=1e-10, t_eval=S[:, 0]
        )
        assert arrives[moment] == pytest.approx(commands[moment] * trapezoid(belt.y[0], S[:, 0]), rel=1e-6)
    assert np.ptp(arrives[50:60]) == 0  # neither pulled nor released
    assert np.array_equal(arrived(law, -commands), -arrives)


def test_a_cable_at_rest_is_as_pulled_from_the_straight_arm():
    law = EFFECTS["capstan_friction"](friction=0.4, conduit=0.2)
    slowly = arrived(law, np.linspace(0, 0.9, 200))
    assert arrived(law, np.full(3, 0.9)) == pytest.approx(slowly[-1], rel=1e-12)


@pytest.mark.parametrize("pulls, side", [("positive", 1), ("negative", -1)])
def test_a_cable_that_only_pulls_loses_what_would_push(pulls, side):
    law = EFFECTS["one_sided_cable"](lost=0.75, pulls=pulls)
    commands = side * np.array([-0.8, 0.0, 0.4, 1.0])
    assert np.allclose(arrived(law, commands), side * np.array([-0.2, 0.0, 0.4, 1.0]))
