"""An arm in space as URDF: hinges that other readers have, and the arm itself for us."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hsr_pin.errors import SpecificationError, UrdfError
from hsr_pin.robot.model import build_model
from hsr_pin.robot.space import space_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf, urdf_to_arm

ARM = ArmSpecification(3, placement="shifted", mount="horizontal", tilt=0.3, cross_tilt=-0.5, tip_mass=0.02, bending="space")
ARMS = [ARM, replace(ARM, torsion=0.7), replace(ARM, torsion=0.0, placement="base", mount="hanging")]


@pytest.mark.parametrize("arm", ARMS)
def test_the_file_alone_gives_the_arm_back(arm):
    assert urdf_to_arm(arm_to_urdf(arm)) == arm


@pytest.mark.parametrize("arm", ARMS)
def test_the_straight_chain_of_hinges_weighs_what_the_arm_does(arm):
    """Mass matrix and gravity's pull, which the links of no length change by millionths."""
    hinges, chain = pin.buildModelFromXML(arm_to_urdf(arm)), space_model(arm)
    moves = np.arange(9) if arm.torsion < math.inf else np.array([0, 1, 3, 4, 6, 7])
    to_body = np.kron(np.eye(3), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])[:, moves]  # towards x is about y
    straight = np.tile([0.0, 0.0, 0.0, 1.0], 3)
    wanted = [pin.crba(chain, chain.createData(), straight), pin.computeGeneralizedGravity(chain, chain.createData(), straight)]
    found = [pin.crba(hinges, hinges.createData(), np.zeros(len(moves)))]
    found.append(pin.computeGeneralizedGravity(hinges, hinges.createData(), np.zeros(len(moves))))
    upper = [np.triu(matrix) + np.triu(matrix, 1).T for matrix in (wanted[0], found[0])]
    np.testing.assert_allclose(upper[1], to_body.T @ upper[0] @ to_body, rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(found[1], to_body.T @ wanted[1], rtol=1e-4, atol=1e-9)


def test_other_readers_take_it(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    assert mujoco.MjModel.from_xml_string(arm_to_urdf(ARMS[1])).nq == 9


def test_a_planar_arm_says_nothing_of_space():
    assert "torsion" not in arm_to_urdf(ArmSpecification())
    assert 'version="1"' in arm_to_urdf(ArmSpecification())


def test_a_changed_file_is_refused():
    with pytest.raises(UrdfError, match="does not fit the arm"):
        urdf_to_arm(arm_to_urdf(ARM).replace('axis xyz="-1 0 0"', 'axis xyz="1 0 0"'))


def test_what_is_planar_refuses_it():
    with pytest.raises(SpecificationError, match="plane for a chain of hinges"):
        build_model(ARM)
