"""Robots of rigid links from their URDF, with encoders and commands as recordings: what their model lacks at the joints.

- ``cause``: the interface of one cause
- ``causes``: the catalogue, one file each
- ``explain``: explain_robot and explain_robot_change
- ``friction``: friction that can be integrated
- ``model``: a robot as a model of its own causes; recordings cut into stretches
- ``read``: recordings from a folder with ``robot.toml``
- ``robot``: a robot as its URDF declares it
- ``servo``: motors that pull joints to commanded angles
- ``simulation``: many simulations side by side
- ``transmission``: motors that turn beside their joints
"""

from hsr_pin.robots.explain import explain_robot, explain_robot_change
from hsr_pin.robots.read import RobotRecordings, RobotTrial, read_robot
from hsr_pin.robots.robot import Robot

__all__ = ["Robot", "RobotRecordings", "RobotTrial", "explain_robot", "explain_robot_change", "read_robot"]
