"""URDF and SDF of arms in space have the bodies and hinges of the model; what is lost is told."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.sdf import to_sdf
from hsr_pin.export.urdf import to_urdf
from hsr_pin.robot.sections import Section
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Marker

EFFECTS = ("dry_friction:level=0.1", "weak_chamber:loss=0.3", "tip_mass:mass=0.03", "base_tilt:towards_x=0.1,towards_y=0.2")
MARKERS = (Marker("mid", 0.1, 0.03, 1.0), Marker("tip", 0.24))


@pytest.fixture(params=["hanging", "upright", "horizontal"])
def told(request):
    arm = ArmSpecification(links=4, placement="mid", mount=request.param, bending="space", torsion=0.8, cross_tilt=0.1)
    return CorrectedModel(arm, tuple(map(parse_effect, EFFECTS)), markers=MARKERS)


def test_each_hinge_of_a_urdf_bends_to_its_side(told):
    model = pin.buildModelFromXML(to_urdf(told).text)
    data, places = (
        model.createData(),
        space_marker_map(told.loaded_arm, [m.arc_length for m in MARKERS], [m.offset for m in MARKERS]),
    )
    assert model.nq == 12
    for joint in range(4):
        for k, way in enumerate(("x", "y", "twist")):
            q, ours = np.zeros(12), np.zeros((4, 3))
            q[model.joints[model.getJointId(f"joint_{joint + 1}_{way}")].idx_q] = ours[joint, k] = 0.7
            pin.framesForwardKinematics(model, data, q)
            seen = [data.oMf[model.getFrameId(f"marker_{marker.name}")].translation for marker in MARKERS]
            np.testing.assert_allclose(seen, places.positions(ours.ravel()), atol=1e-12)


def test_it_weighs_what_the_arm_weighs_and_turns_as_heavily(told):
    model = pin.buildModelFromXML(to_urdf(told).text)
    data = model.createData()
    upper = np.triu(pin.crba(model, data, np.zeros(12)))
    straight = upper + np.triu(upper, 1).T
    at = [model.joints[model.getJointId(f"joint_{i + 1}_x")].idx_v for i in range(4)]
    from hsr_pin.robot.chain import Arms, chain_of, mass_matrix

    np.testing.assert_allclose(straight[np.ix_(at, at)], mass_matrix(chain_of(Arms.of([told.loaded_arm]))), rtol=1e-4)


def test_the_hinges_of_an_sdf_have_the_springs_of_the_model(told):
    model = ElementTree.fromstring(to_sdf(told).text).find("model")
    joints = {
        joint.get("name"): joint.find("axis/dynamics") for joint in model.findall("joint") if joint.get("type") == "revolute"
    }
    assert list(joints)[:6] == [
        *(f"joint_1_{way}" for way in ("x", "y", "twist")),
        *(f"joint_2_{way}" for way in ("twist", "y", "x")),
    ]
    springs = {name[8:]: float(each.findtext("spring_stiffness")) for name, each in joints.items()}
    assert springs == pytest.approx({"x": 4.44, "y": 4.44, "twist": 3.2})
    assert float(joints["joint_1_twist"].findtext("friction")) == 0.0


def test_drake_bends_an_sdf_as_the_model_is_bent(told, tmp_path):
    plant_module = pytest.importorskip("pydrake.multibody.plant", reason="drake is not installed (group export)")
    from pydrake.multibody.parsing import Parser

    path = tmp_path / "arm.sdf"
    path.write_text(to_sdf(told).text, encoding="utf-8")
    plant = plant_module.MultibodyPlant(1e-3)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    context, ours = plant.CreateDefaultContext(), np.zeros((4, 3))
    for joint, way in ((0, 0), (2, 1)):
        plant.GetJointByName(f"joint_{joint + 1}_{'xy'[way]}").set_angle(context, 0.5)
        ours[joint, way] = 0.5
    seen = [plant.GetFrameByName(f"marker_{m.name}").CalcPoseInWorld(context).translation() for m in MARKERS]
    places = space_marker_map(told.loaded_arm, [m.arc_length for m in MARKERS], [m.offset for m in MARKERS])
    np.testing.assert_allclose(seen, places.positions(ours.ravel()), atol=1e-12)


def test_what_is_lost_is_told(told):
    exported = to_urdf(told)
    for line in exported.missing:
        assert f"Not in it: {line}" in exported.text
    said = "\n".join(exported.missing)
    assert "joints: hinges in series" in said and "4 links are few; use 10 or more" in said
    assert "towards x and towards y, from base to tip k [Nm/rad] = 4.44 each" in said
    assert "torsional springs: a torque of -k times the twist at each joint, k [Nm/rad] = 3.2 each" in said
    assert "weak_chamber: the torque towards one side arrives only in part (loss 0.3, direction 0 rad)" in said
    assert "actuator: two components of torque" in said
    assert {line.partition(":")[0] for line in exported.held} == {"dry_friction", "tip_mass", "base_tilt"}


def test_sections_are_told_with_what_each_gives_to_which_joint():
    arm = ArmSpecification.in_sections([Section(0.1, 0.09, 3.0, 0.2), Section(0.1, 0.05, 1.5, 0.1)], links=4, placement="mid")
    (line,) = [line for line in to_sdf(CorrectedModel(arm)).missing if line.startswith("actuator")]
    assert line.endswith("of section 1 1, 1, 0, 0; of section 2 0, 0, 1, 1")
