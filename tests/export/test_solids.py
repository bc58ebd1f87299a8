"""Obstacles are exported where they are, with contact between them and the arm only."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.effects.obstacle import Obstacle
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.sdf import to_sdf
from hsr_pin.export.urdf import to_urdf
from hsr_pin.obstacles import Box, Cylinder, HalfSpace, Sphere, from_dict, to_dict
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate

HARD = {"stiffness": 1e8, "friction": 0.3}
POST = Cylinder(centre=(0.06, 0.0, -0.14), radius=0.01, **HARD)
BESIDE = (
    HalfSpace(point=(0.14, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), **HARD),
    Box(centre=(-0.2, 0.0, -0.1), rotation=(0.2, 0.3, 0.4)),
    Sphere(centre=(-0.3, 0.0, 0.0), radius=0.02),
)


def arm(bending, *obstacles):
    return ArmSpecification(links=16, placement="shifted", bending=bending, obstacles=obstacles)


@pytest.mark.parametrize("bending", ["plane", "space"])
def test_an_arm_round_a_post_rests_in_mujoco_where_it_rests_here(bending):
    mujoco = pytest.importorskip("mujoco")
    bent = arm(bending, POST, *BESIDE)
    text = to_mjcf(CorrectedModel(bent), major=int(mujoco.__version__.split(".")[0])).text
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.5
    for _ in range(int(3 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    here = simulate(step_scenario(bent, 1.5, duration=3.0)).trajectory.positions[-1, -1]
    free = simulate(step_scenario(arm(bending), 1.5, duration=3.0)).trajectory.positions[-1, -1]
    assert np.linalg.norm(here - free) > 0.02
    assert np.linalg.norm(data.site("tip").xpos - here) < 1e-3


def test_an_effect_that_is_an_obstacle_is_exported_as_one():
    declared = to_mjcf(CorrectedModel(arm("plane", POST)))
    found = to_mjcf(CorrectedModel(arm("plane"), effects=(Obstacle(hardness=3e6, gap=0.03, at=0.14 / 0.24, friction=0.3),)))
    place = [[geom for geom in ET.fromstring(e.text).iter("geom") if geom.get("name") == "obstacle_1"] for e in (declared, found)]
    assert [each[0].get("type") for each in place] == ["cylinder", "cylinder"]
    for key in ("size", "pos", "friction"):
        np.testing.assert_allclose(*([float(x) for x in each[0].get(key).split()] for each in place), atol=1e-12)


def test_a_file_without_obstacles_has_no_contact():
    assert 'contact="disable"' in to_mjcf(CorrectedModel(arm("plane"))).text
    assert "collision" not in to_urdf(CorrectedModel(arm("plane"))).text


@pytest.mark.parametrize("bending", ["plane", "space"])
def test_urdf_and_sdf_have_the_obstacles_in_the_world(bending):
    model = CorrectedModel(arm(bending, POST, *BESIDE))
    urdf = to_urdf(model).text
    robot = pin.buildModelFromXML(urdf)
    solids = pin.buildGeomFromUrdfString(robot, urdf, pin.GeometryType.COLLISION)
    data, places = robot.createData(), solids.createData()
    pin.updateGeometryPlacements(robot, data, solids, places, pin.neutral(robot))
    found = {o.name: m.translation for o, m in zip(solids.geometryObjects, places.oMg, strict=True) if "obstacle" in o.name}
    assert len(found) == 4
    np.testing.assert_allclose(found["obstacle_1_0"], POST.centre, atol=1e-9)
    np.testing.assert_allclose(found["obstacle_3_0"], BESIDE[1].centre, atol=1e-9)
    links = [link.get("name") for link in ET.fromstring(to_sdf(model).text).iter("link")]
    assert [name for name in links if name.startswith("obstacle")] == [f"obstacle_{k}" for k in (1, 2, 3, 4)]


@pytest.mark.parametrize("obstacle", [POST, *BESIDE], ids=lambda o: o.shape)
def test_an_obstacle_survives_a_document(obstacle):
    assert from_dict(to_dict(obstacle)) == obstacle
