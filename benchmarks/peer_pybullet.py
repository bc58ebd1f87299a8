"""The benchmark problem in PyBullet: the same bodies, with the torques of springs and dampers set in every step.

E. Coumans, Y. Bai, PyBullet, a Python module for physics simulation (2016-2021). The world is set up beforehand.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pybullet
from problem import DURATION, SAMPLE, TORQUE
from pybullet_utils.bullet_client import BulletClient

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.robot.urdf import arm_to_urdf
from hsr_pin.trajectory import Array

_FIXED = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'


class PybulletChain:
    """A solver by PyBullet.

    Args:
        arm: arm to simulate.
        substeps: steps per sample.
    """

    def __init__(self, arm: ArmSpecification, substeps: int) -> None:
        self.setting = f"{1e3 * SAMPLE / substeps:.3g} ms"
        self._arm, self._substeps = arm, substeps
        self._world = world = BulletClient(pybullet.DIRECT)
        world.setGravity(0, 0, -9.81)
        world.setTimeStep(SAMPLE / substeps)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "arm.urdf"
            path.write_text(_bodies(arm), encoding="utf-8")
            self._body = world.loadURDF(str(path), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        joints = range(world.getNumJoints(self._body))
        self._joints = [joint for joint in joints if world.getJointInfo(self._body, joint)[2] == pybullet.JOINT_REVOLUTE]
        for link in (-1, *joints):
            world.changeDynamics(self._body, link, linearDamping=0, angularDamping=0)
        world.setJointMotorControlArray(self._body, self._joints, pybullet.VELOCITY_CONTROL, forces=[0] * arm.links)

    def run(self) -> Array:
        """Return the joint angles, see `Solver`."""
        body, joints, world = self._body, self._joints, self._world
        stiffness, damping = self._arm.joint_stiffness, self._arm.joint_damping
        push, step, read = world.setJointMotorControlArray, world.stepSimulation, world.getJointStates
        for joint in joints:
            world.resetJointState(body, joint, 0.0)
        q = v = (0.0,) * len(joints)
        angles = np.zeros((round(DURATION / SAMPLE) + 1, 1, len(joints)))
        for n in range(1, len(angles)):
            for _ in range(self._substeps):
                forces = [TORQUE - stiffness * angle - damping * rate for angle, rate in zip(q, v, strict=True)]
                push(body, joints, pybullet.TORQUE_CONTROL, forces=forces)
                step()
                q, v, *_ = zip(*read(body, joints), strict=True)
            angles[n, 0] = q
        return angles


def _bodies(arm: ArmSpecification) -> str:
    """Return the URDF without visual elements, and without massless frames on the arm, to which PyBullet would give 1 kg each."""
    root = ElementTree.fromstring(arm_to_urdf(arm))
    for element in list(root):
        if element.get("name", "").rpartition("_to_")[2] in ("middle", "tip"):
            root.remove(element)
        for look in element.findall("visual"):
            element.remove(look)
    for name in ("world", "base"):
        fixed = root.find(f"link[@name='{name}']")
        assert fixed is not None
        fixed.append(ElementTree.fromstring(_FIXED))
    return ElementTree.tostring(root, encoding="unicode")
