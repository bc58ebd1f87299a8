"""Batch simulations of a robot agree with Pinocchio and SciPy, and every cause acts as described."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

from hsr_pin.robots import Robot, RobotRecordings, RobotTrial
from hsr_pin.robots.cause import Values
from hsr_pin.robots.causes import CAUSES
from hsr_pin.robots.model import RobotModel
from hsr_pin.robots.servo import Servo
from hsr_pin.robots.simulation import Case, Stretch, simulate

URDF = """
<robot name="two_links">
  <link name="base"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-6" upper="6" effort="50" velocity="20"/><dynamics damping="0.05" friction="0"/>
  </joint>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1.2"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="elbow" type="revolute">
    <origin xyz="0 0 -0.4"/><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
    <limit lower="-6" upper="6" effort="50" velocity="20"/>
  </joint>
  <link name="lower"><inertial><origin xyz="0 0 -0.15"/><mass value="0.7"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="wrist" type="revolute">
    <origin xyz="0 0 -0.3"/><parent link="lower"/><child link="hand"/><axis xyz="1 0 0"/>
    <limit lower="-6" upper="6" effort="50" velocity="20"/>
  </joint>
  <link name="hand"><inertial><origin xyz="0 0 -0.05"/><mass value="0.2"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>
"""
JOINTS = ["elbow", "shoulder"]  # not in the order of the URDF
TIME = np.arange(0, 1.0, 0.002)
TORQUE = np.column_stack([0.6 * np.sin(7 * TIME), 2.0 * np.cos(4 * TIME)])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    file = tmp_path_factory.mktemp("robot") / "robot.urdf"
    file.write_text(URDF, encoding="utf-8")
    return Robot.load(file, JOINTS, [0.01, 0.02])


@pytest.fixture(scope="module")
def model(robot):
    position = np.column_stack([0.3 * np.sin(5 * TIME), 0.5 * np.sin(3 * TIME)])
    return RobotModel.of(RobotRecordings("robot", robot, (RobotTrial("one", TIME, position, TORQUE),)))


def stretch(q=(0.3, -0.2), v=(0.5, 0.0)):
    before = np.arange(-0.5, 0, 0.002)
    return Stretch(TIME, TORQUE, before, np.zeros((len(before), 2)), np.array(q), np.array(v), np.zeros(2))


def run(model, **values):
    named = model.neutral | {name.replace("__", "."): value for name, value in values.items()}
    return simulate(model.recordings.robot, CAUSES, model.neutral, model.scales, [Case(stretch(), named, np.zeros(2))])[0]


def exact(robot, extra=lambda q, v: 0.0):
    """Return encoder angles from SciPy, for the same URDF built again."""
    whole = pin.buildModelFromXML(robot.urdf)
    model = pin.buildReducedModel(whole, [whole.getJointId("wrist")], pin.neutral(whole))
    model.armature = np.array([0.02, 0.01])
    data = model.createData()

    def rates(t, y):
        q, v = y[:2], y[2:]
        torque = np.array([np.interp(t, TIME, TORQUE[:, 1]), np.interp(t, TIME, TORQUE[:, 0])])
        return np.append(v, pin.aba(model, data, q, v, torque - np.array([0.05, 0.0]) * v + extra(q, v)))

    found = solve_ivp(rates, (0, TIME[-1]), [-0.2, 0.3, 0.0, 0.5], t_eval=TIME, rtol=1e-9, atol=1e-10, max_step=0.002)
    return found.y[:2][::-1].T


def test_the_declared_robot_agrees_with_pinocchio_and_scipy(robot, model):
    assert run(model) == pytest.approx(exact(robot), abs=2e-4)


def test_viscous_friction_agrees_with_scipy(robot, model):
    found = run(model, viscous_friction__shoulder=0.4)
    assert found == pytest.approx(exact(robot, lambda q, v: np.array([-0.4, 0.0]) * v), abs=5e-4)


def elastic(robot, passed, y0, command, side=0, rotor=0.01):
    """Return angles (N, 2) from SciPy: elbow, or on side 1 its rotor, and shoulder; the rotor transmits a torque to the elbow."""
    whole = pin.buildModelFromXML(robot.urdf)
    model = pin.buildReducedModel(whole, [whole.getJointId("wrist")], pin.neutral(whole))
    model.armature = np.array([0.02, 0.0])
    data = model.createData()

    def rates(t, y):
        q, v, ahead, faster = y[:2], y[2:4], y[4], y[5]
        motors = command(t, q, v)
        through = passed(ahead, faster)
        a = pin.aba(model, data, q, v, np.array([motors[0], through]) - np.array([0.05, 0.0]) * v)
        return np.concatenate([v, a, [faster, (motors[1] - through) / rotor - a[1]]])

    y0 = np.array(y0) - side * np.array([0, y0[4], 0, 0, 0, 0])
    found = solve_ivp(rates, (0, TIME[-1]), y0, t_eval=TIME, rtol=1e-8, atol=1e-9, max_step=1e-3).y
    return np.column_stack([found[1] + side * found[4], found[0]])


def recorded(t, q, v):
    return np.interp(t, TIME, TORQUE[:, 1]), np.interp(t, TIME, TORQUE[:, 0])


@pytest.mark.parametrize("side", [0, 1])
def test_a_joint_with_a_spring_agrees_with_scipy(robot, model, side):
    stiffness, damping = 20.0, 2 * 0.1 * np.sqrt(20.0 * 0.01)
    first = stretch().command[0, 0] / stiffness
    truth = elastic(robot, lambda x, w: stiffness * x + damping * w, [-0.2, 0.3, 0.0, 0.5, first, 0.0], recorded, side)
    shapes = {"joint_elasticity__damping_ratio": 0.1, "joint_elasticity__encoder_side": side}
    found = run(model, joint_elasticity__elbow=1 / stiffness, **shapes)
    assert np.abs(truth - exact(robot)).max() > 0.02  # a rigid joint would not pass
    assert found == pytest.approx(truth, abs=3e-3)


def test_rotor_inertia_belongs_to_the_motor_of_an_elastic_joint(robot, model):
    stiffness, rotor = 20.0, 0.03
    damping, first = 2 * 0.1 * np.sqrt(stiffness * rotor), stretch().command[0, 0] / stiffness
    truth = elastic(robot, lambda x, w: stiffness * x + damping * w, [-0.2, 0.3, 0.0, 0.5, first, 0.0], recorded, rotor=rotor)
    causes = {
        "joint_elasticity__elbow": 1 / stiffness,
        "joint_elasticity__damping_ratio": 0.1,
        "rotor_inertia__elbow": rotor - 0.01,
    }
    found, rigid = run(model, joint_elasticity__encoder_side=0, **causes), run(model, rotor_inertia__elbow=rotor - 0.01)
    assert np.abs(truth - rigid).max() > 0.02
    assert found == pytest.approx(truth, abs=3e-3)


def test_an_eccentric_encoder_shows_the_angle_plus_a_sine_of_it(model):
    (law,) = (cause for cause in CAUSES if cause.name == "encoder_eccentricity")
    named = model.neutral | {"encoder_eccentricity.sine:elbow": 0.1, "encoder_eccentricity.cosine:elbow": -0.05}
    values, angle = Values(law, JOINTS, [named], model.scales), np.array([[0.7, -1.2]])
    shown = law.encoder_reading(values, angle)
    assert shown == pytest.approx(np.array([[0.7 + 0.1 * np.sin(0.7) - 0.05 * np.cos(0.7), -1.2]]))
    assert law.true_angle(values, shown) == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("side", [0, 1])
def test_a_joint_with_play_agrees_with_scipy(robot, model, side):
    """The reference has flanks of the same stiffness as the cause."""
    half, inertia = 0.05, 0.01
    stiffness, damping = inertia * 250.0**2, 2 * 0.3 * inertia * 250.0

    def passed(ahead, faster):
        beyond = ahead - np.clip(ahead, -half, half)
        torque = stiffness * beyond + damping * faster
        return torque if beyond and torque * ahead > 0 else 0.0

    truth = elastic(robot, passed, [-0.2, 0.3, 0.0, 0.5, 0.0, 0.0], recorded, side)
    found = run(model, backlash__elbow=2 * half, backlash__encoder_side=side)
    assert np.abs(truth - exact(robot)).max() > 0.02  # a joint without play would not pass
    assert np.sqrt(np.mean((found - truth) ** 2)) < 0.2 * np.sqrt(np.mean((truth - exact(robot)) ** 2))


def test_a_servo_agrees_with_scipy(robot):
    stiffness, damping, limit = np.array([30.0, 8.0]), np.array([0.6, 0.2]), np.array([6.0, 100.0])
    servo = Servo.of(2, stiffness[::-1], damping[::-1], limit[::-1], guessed=False)
    target = np.column_stack([0.5 * np.sin(6 * TIME), 0.8 * np.sign(np.sin(4 * TIME))])
    target[TIME > 0.8] = np.nan  # the servo is off
    driven = replace(robot, servo=servo)
    still = RobotRecordings("servo", driven, (RobotTrial("one", TIME, np.nan_to_num(target), target),))
    model = RobotModel.of(still)
    given = replace(stretch(), command=target, before=np.zeros((250, 2)), held=True)
    found = simulate(driven, CAUSES, model.neutral, model.scales, [Case(given, model.neutral, np.zeros(2))])[0]
    whole = pin.buildModelFromXML(robot.urdf)
    plain = pin.buildReducedModel(whole, [whole.getJointId("wrist")], pin.neutral(whole))
    plain.armature = np.array([0.02, 0.01])
    data, steps = plain.createData(), [np.array([-0.2, 0.3, 0.0, 0.5])]
    for begin, end, wanted in zip(TIME[:-1], TIME[1:], target[:-1, ::-1], strict=True):

        def rates(_, y, wanted=wanted):
            pulled = np.nan_to_num(np.clip(stiffness * (wanted - y[:2]) - damping * y[2:], -limit, limit))
            return np.append(y[2:], pin.aba(plain, data, y[:2], y[2:], pulled - np.array([0.05, 0.0]) * y[2:]))

        steps.append(solve_ivp(rates, (begin, end), steps[-1], rtol=1e-8, atol=1e-10).y[:, -1])
    assert found == pytest.approx(np.array(steps)[:, 1::-1], abs=5e-3)


def test_halving_the_samples_step_changes_little(model):
    half = replace(stretch(), time=TIME[::2], command=TORQUE[::2])
    coarse = simulate(model.recordings.robot, CAUSES, model.neutral, model.scales, [Case(half, model.neutral, np.zeros(2))])[0]
    assert coarse == pytest.approx(run(model)[::2], abs=1e-3)


def test_steps_of_five_milliseconds_are_short_enough(robot, model):
    fifth = Stretch(
        TIME[::5] / 2, TORQUE[::5], TIME[:2] - 1, np.zeros((2, 2)), np.array([0.3, -0.2]), np.array([0.5, 0.0]), np.zeros(2)
    )
    many = np.linspace(0, fifth.time[-1], 10 * (len(fifth.time) - 1) + 1)
    command = np.column_stack([np.interp(many, fifth.time, column) for column in fifth.command.T])
    finer = replace(fifth, time=many, command=command)
    coarse, fine = (
        simulate(robot, CAUSES, model.neutral, model.scales, [Case(each, model.neutral, np.zeros(2))])[0]
        for each in (fifth, finer)
    )
    assert np.diff(fifth.time)[0] == pytest.approx(0.005)
    assert coarse == pytest.approx(fine[::10], abs=1e-3)


def test_a_sticking_robot_does_not_move(robot, model):
    still = Stretch(TIME, 0 * TORQUE, TIME[:2] - 1, np.zeros((2, 2)), np.array([0.2, 0.1]), np.zeros(2), np.zeros(2))
    stuck = model.neutral | {"coulomb_friction.elbow": 5.0, "coulomb_friction.shoulder": 5.0}
    found = simulate(robot, CAUSES, model.neutral, model.scales, [Case(still, stuck, np.zeros(2))])[0]
    assert np.abs(found - found[0]).max() < 0.02


SIZES = {
    "coulomb_friction.elbow": 0.3,
    "stribeck_friction.level:shoulder": 0.3,
    "load_friction.shoulder": 0.3,
    "viscous_friction.elbow": 0.2,
    "quadratic_damping.shoulder": 0.2,
    "joint_spring.stiffness:elbow": 1.0,
    "joint_stop.upper:elbow": 20.0,
    "rotor_inertia.elbow": 0.02,
    "payload.mass": 0.2,
    "link_mass.elbow": 0.2,
    "link_inertia.shoulder": 0.5,
    "centre_of_mass.elbow": 0.2,
    "tilted_base.about_y": 0.1,
    "backlash.elbow": 0.1,
    "joint_elasticity.elbow": 0.05,
    "transmission_hysteresis.elbow": 0.3,
    "torque_gain.shoulder": 0.1,
    "torque_bias.elbow": 0.2,
    "torque_ripple.cosine:elbow": 0.2,
    "saturation.shoulder": 0.4,
    "dead_time.delay": 0.05,
    "drive_lag.time_constant": 0.05,
    "encoder_offset.elbow": 0.05,
    "encoder_gain.shoulder": 0.05,
    "encoder_eccentricity.cosine:shoulder": 0.05,
}


def test_every_cause_is_tried_here():
    assert {name.partition(".")[0] for name in SIZES} == {cause.name for cause in CAUSES}


@pytest.mark.parametrize(("name", "size"), SIZES.items(), ids=SIZES)
def test_a_cause_moves_the_robot_and_its_neutral_value_does_not(model, name, size):
    plain = run(model)
    changed = run(model, **{name.replace(".", "__", 1): size})
    assert np.isfinite(changed).all() and np.abs(changed - plain).max() > 1e-3
    shapes = {key: value for key, value in model.neutral.items() if key.startswith(name.partition(".")[0])}
    others = {key: value + 0.1 for key, value in shapes.items() if value != 0}  # shape parameters alone have no influence
    assert np.array_equal(run(model, **{key.replace(".", "__", 1): value for key, value in others.items()}), plain)


def test_a_batch_equals_its_single_simulations(model):
    named = [model.neutral | {name: size} for name, size in SIZES.items()]
    cases = [Case(stretch(), values, np.zeros(2)) for values in named]
    together = simulate(model.recordings.robot, CAUSES, model.neutral, model.scales, cases)
    for case, seen in zip(cases, together, strict=True):
        (alone,) = simulate(model.recordings.robot, CAUSES, model.neutral, model.scales, [case])
        assert seen == pytest.approx(alone, abs=1e-10)


def test_a_dead_time_shows_the_motion_later(model):
    """The robot hangs at rest until its torque begins."""
    at = np.where(TIME[:, None] > 0.3, [0.5, 0.0], 0.0)
    before = np.arange(-0.5, 0, 0.002)
    hanging = Stretch(TIME, at, before, np.zeros((len(before), 2)), np.zeros(2), np.zeros(2), np.zeros(2))
    late = model.neutral | {"dead_time.delay": 0.1}
    now, then = (
        simulate(model.recordings.robot, CAUSES, model.neutral, model.scales, [Case(hanging, values, np.zeros(2))])[0]
        for values in (model.neutral, late)
    )
    assert then[50:] == pytest.approx(now[:-50], abs=1e-4)


def test_a_payload_adds_its_mass_to_the_last_link(robot, model):
    """The payload is added to the last link of the URDF."""
    changed = robot.model.copy()
    (payload,) = (cause for cause in CAUSES if cause.name == "payload")
    payload.change_bodies(np.array([0.5, 1.0]), robot.joints, changed)
    assert changed.inertias[-1].mass - robot.model.inertias[-1].mass == pytest.approx(0.5)
    assert changed.inertias[-1].lever == pytest.approx(robot.model.inertias[-1].lever, rel=0.1)


@pytest.mark.parametrize("name", ["link_mass", "link_inertia", "centre_of_mass"])
def test_the_link_of_a_joint_is_changed_in_whatever_order_joints_were_recorded(robot, model, name):
    (cause,) = (cause for cause in CAUSES if cause.name == name)
    changed = robot.model.copy()
    cause.change_bodies(np.array([0.5, 0.0]), robot.joints, changed)
    elbow, shoulder = (changed.getJointId(joint) for joint in ("elbow", "shoulder"))
    assert changed.inertias[shoulder] == robot.model.inertias[shoulder]
    assert changed.inertias[elbow] != robot.model.inertias[elbow]
