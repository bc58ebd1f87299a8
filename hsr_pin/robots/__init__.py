"""Explanation of model errors at the joints of rigid-link robots, from a URDF, encoder angles and recorded commands.

- ``cause``: interface of one cause
- ``causes``: catalogue of causes, one file each
- ``declared``: errors of the declared numbers within their tolerances
- ``explain``: explain_robot and explain_robot_change
- ``friction``: regularised friction that can be integrated
- ``model``: prediction model with its causes; recordings cut into stretches
- ``read``: recordings from a folder with ``robot.toml``
- ``robot``: the robot as its URDF declares it
- ``servo``: position servos at the joints
- ``simulation``: batch simulation of many cases
- ``start``: state at the start of a stretch from encoder angles
- ``transmission``: motors connected to their joints by elastic or loose transmissions
"""

from hsr_pin.robots.explain import explain_robot, explain_robot_change
from hsr_pin.robots.read import RobotRecordings, RobotTrial, read_robot
from hsr_pin.robots.robot import Robot

__all__ = ["Robot", "RobotRecordings", "RobotTrial", "explain_robot", "explain_robot_change", "read_robot"]
