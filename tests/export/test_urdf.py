"""Exported URDF loads in the readers that people use, with the bodies of the model and an honest list of what is not in it."""

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.urdf import to_urdf
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification

EFFECTS = ("dry_friction:level=0.1", "viscoelastic:ratio=0.3", "torque_decay:decay=0.2", "tip_mass:mass=0.03")
ARMS = [
    {"placement": placement, "mount": mount} for placement in ("base", "mid") for mount in ("hanging", "upright", "horizontal")
]


@pytest.fixture(params=ARMS, ids=lambda arm: " ".join(arm.values()))
def told(request):
    return CorrectedModel(ArmSpecification(links=3, tilt=0.2, **request.param), tuple(map(parse_effect, EFFECTS)))


def test_pinocchio_finds_the_same_bodies(told):
    exported, ours = pin.buildModelFromXML(to_urdf(told).text), build_model(told.loaded_arm).model
    pose, rate, torque = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -1.0]), np.array([0.1, 0.2, 0.3])
    theirs = pin.aba(exported, exported.createData(), pose, rate, torque)
    friction = {tuple(np.round(exported.lowerDryFrictionLimit, 9)), tuple(np.round(exported.upperDryFrictionLimit, 9))}
    assert friction == {(0.111,) * 3, (-0.111,) * 3}
    assert np.allclose(exported.damping, [0.15] * 3)
    assert np.allclose(theirs, pin.aba(ours, ours.createData(), pose, rate, torque), rtol=1e-9)


def test_the_markers_are_frames(told):
    model = pin.buildModelFromXML(to_urdf(told).text)
    data = model.createData()
    q = np.array([0.3, -0.2, 0.5])
    pin.framesForwardKinematics(model, data, q)
    from hsr_pin.robot.kinematics import marker_map

    expected = marker_map(told.loaded_arm, [0.0, 0.12, 0.24]).positions(q)
    seen = [data.oMf[model.getFrameId(f"marker_{name}")].translation for name in ("base", "mid", "tip")]
    assert np.allclose(seen, expected, atol=1e-12)


def test_yourdfpy_loads_it(told, tmp_path):
    from yourdfpy import URDF

    path = tmp_path / "arm.urdf"
    path.write_text(to_urdf(told).text, encoding="utf-8")
    assert URDF.load(str(path)).num_actuated_joints == 3


def test_pybullet_loads_it_and_frames_weigh_nothing(told, tmp_path):
    pybullet = pytest.importorskip("pybullet", reason="pybullet has wheels for Python up to 3.11 only")
    path = tmp_path / "arm.urdf"
    path.write_text(to_urdf(told).text, encoding="utf-8")
    world = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=world)
        joints = range(pybullet.getNumJoints(body, physicsClientId=world))
        masses = {
            pybullet.getJointInfo(body, j, physicsClientId=world)[12].decode(): pybullet.getDynamicsInfo(
                body, j, physicsClientId=world
            )[0]
            for j in joints
        }
    finally:
        pybullet.disconnect(world)
    moving = 0.125 if told.arm.placement == "mid" else 0.15
    assert sum(masses.values()) == pytest.approx(moving + 0.03)
    assert masses["payload"] == pytest.approx(0.03)
    assert masses["marker_tip"] == masses["base"] == 0


def test_what_a_urdf_cannot_say_is_listed_in_it(told):
    exported = to_urdf(told)
    for line in exported.missing:
        assert f"Not in it: {line}" in exported.text
    said = " ".join(exported.missing)
    assert "viscoelastic: creep and relaxation (ratio 0.3, time_constant 0.5 s)" in said
    assert "torque_decay: shares of the command at the joints, from base to tip: 0.966667, 0.9, 0.833333" in said
    assert "springs: " in said
    assert {line.partition(":")[0] for line in exported.held} == {"dry_friction", "tip_mass"}


def test_a_turned_gravity_is_told_as_the_simulation_has_it():
    told = CorrectedModel(ArmSpecification(mount="hanging"), (parse_effect("gravity_tilt:angle=0.1,frame=base"),))
    (line,) = [line for line in to_urdf(told).missing if line.startswith("gravity_tilt")]
    assert line == "gravity_tilt: set the gravity of the world to (-0.979366, 0, -9.76099) m/s^2"


def test_friction_that_grows_with_the_load_is_no_friction_of_a_joint():
    exported = to_urdf(CorrectedModel(ArmSpecification(), (parse_effect("dry_friction:level=0.1,form=load"),)))
    assert 'friction="0' in exported.text and not exported.held
    assert "dry_friction: rate-independent friction at the joints, sticking (level 0.1 rad, load)" in exported.missing
