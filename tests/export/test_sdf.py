"""Exported SDF has the bodies, springs and frames of the model; Drake, which reads it with Gazebo's own parser, agrees."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.sdf import to_sdf
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.specification import ArmSpecification

EFFECTS = (
    "stiffness_gradient:slope=0.5",
    "dry_friction:level=0.1",
    "actuator_lag:time_constant=0.05",
    "marker_offset:offset=0.01",
)


@pytest.fixture(params=["base", "mid"])
def told(request):
    return CorrectedModel(
        ArmSpecification(links=3, placement=request.param, mount="horizontal", tip_mass=0.02), tuple(map(parse_effect, EFFECTS))
    )


def test_every_joint_has_its_spring_damper_and_friction(told):
    model = ElementTree.fromstring(to_sdf(told).text).find("model")
    joints = [joint.find("axis/dynamics") for joint in model.findall("joint") if joint.get("type") == "revolute"]
    springs = told.batch.arrays.spring[0]
    assert np.ptp(springs) > 0.5
    assert [float(j.findtext("spring_stiffness")) for j in joints] == pytest.approx(list(springs))
    assert [float(j.findtext("damping")) for j in joints] == pytest.approx([0.15] * 3)
    assert [float(j.findtext("friction")) for j in joints] == pytest.approx([0.111] * 3)


def test_what_an_sdf_cannot_say_is_listed_in_it(told):
    exported = to_sdf(told)
    assert [line for line in exported.missing if line.startswith("actuator_lag")] == [
        "actuator_lag: the torque follows the command with a lag of first or second order, or as through an orifice "
        "(time_constant 0.05 s, first)"
    ]
    assert not any(line.startswith("springs") for line in exported.missing)
    for line in exported.missing:
        assert f"Not in it: {line}" in exported.text


def test_drake_moves_it_as_the_model_is_bent(told, tmp_path):
    plant_module = pytest.importorskip("pydrake.multibody.plant", reason="drake is not installed (group export)")
    from pydrake.multibody.parsing import Parser

    path = tmp_path / "arm.sdf"
    path.write_text(to_sdf(told).text, encoding="utf-8")
    plant = plant_module.MultibodyPlant(1e-3)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    bent = np.array([0.3, -0.2, 0.5])
    plant.SetPositions(context, bent)
    seen = [plant.GetFrameByName(f"marker_{name}").CalcPoseInWorld(context).translation() for name in ("mid", "tip")]
    places = marker_map(told.arm, [0.12, 0.24])
    assert np.allclose(seen, places.positions(bent) + 0.01 * places.normals(bent), atol=1e-12)
    assert [plant.GetBodyByName(f"link_{i}").default_mass() for i in (1, 2)] == pytest.approx([0.05, 0.05])
    forces = plant.MakeMultibodyForces(plant) if hasattr(plant, "MakeMultibodyForces") else None
    assert forces is None or plant.num_force_elements() == 4  # gravity and three springs
