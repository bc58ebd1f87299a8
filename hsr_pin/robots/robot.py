"""A rigid-link robot as its URDF declares it, with the recorded joints free and all others locked."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from hsr_pin.errors import InputError, quoted
from hsr_pin.robots.servo import Servo
from hsr_pin.trajectory import Array

#: Elements of a URDF without influence on the motion, which may refer to absent mesh files.
_VISUALS = ("visual", "collision")
#: Allowed places of the encoders; empty: unknown.
_ENCODER_SIDES = ("", "joint", "motor")


@dataclass(frozen=True, eq=False)
class Robot:
    """A serial robot with rigid links.

    Attributes:
        urdf: text of the URDF, without visual and collision elements.
        joints: (n,) names of the free joints, in the order of the recordings.
        rotor_inertia: (n,) inertia of the motors, reflected to the joints [kg m^2].
        gravity: (3,) gravity in the frame of the base [m/s^2].
        encoders: part on which the encoders are mounted, "joint" or "motor"; it matters for play or springs in the transmission;
            empty: unknown.
        accuracy: relative standard deviation of the errors of declared masses, centres of mass, inertias and servo numbers.
        servo: position servos, if angles are commanded; None: torques are commanded.
        notes: notes on changes of the URDF.
    """

    urdf: str
    joints: tuple[str, ...]
    rotor_inertia: tuple[float, ...]
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    encoders: str = ""
    accuracy: float = 0.02
    servo: Servo | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def load(cls, path: str | Path, joints: Sequence[str], rotor_inertia: Sequence[float] = (), **more: Any) -> Robot:
        """Return the robot in a URDF file.

        Args:
            path: URDF file.
            joints: names of the recorded joints.
            rotor_inertia: inertia of each motor, reflected to its joint [kg m^2]; default: none.
            more: ``gravity``, ``encoders``, ``accuracy``, ``servo``.

        Raises:
            InputError: the file is no URDF, or it does not contain these joints.
        """
        text, notes = _without_visuals(Path(path))
        robot = cls(text, tuple(joints), tuple(rotor_inertia) or (0.0,) * len(joints), notes=notes, **more)
        if len(robot.rotor_inertia) != len(joints):
            expected, received = f"{len(joints)} numbers, one for each joint", len(robot.rotor_inertia)
            raise InputError("rotor_inertia", expected=expected, received=received)
        if robot.encoders not in _ENCODER_SIDES:
            raise InputError("encoders", expected=" or ".join(filter(None, _ENCODER_SIDES)), received=quoted(robot.encoders))
        if robot.model.nv != len(joints):
            raise InputError(f"joints of {path}", expected="joints with one degree of freedom each", received=", ".join(joints))
        return robot

    @cached_property
    def model(self) -> pin.Model:
        """Pinocchio model of the robot, with the inertia of the motors.

        Raises:
            InputError: a joint does not exist.
        """
        whole = pin.buildModelFromXML(self.urdf)
        names = list(whole.names)[1:]
        if unknown := [name for name in self.joints if name not in names]:
            raise InputError("joints", expected=f"names among {', '.join(names)}", received=quoted(unknown[0]))
        locked = [whole.getJointId(name) for name in names if name not in self.joints]
        model = pin.buildReducedModel(whole, locked, pin.neutral(whole)) if locked else whole
        model.gravity.linear = np.array(self.gravity)
        model.armature = self.in_model_order(np.array(self.rotor_inertia))
        return model

    @cached_property
    def order(self) -> list[int]:
        """Index of the recorded joint for each joint of the model."""
        names = list(pin.buildModelFromXML(self.urdf).names)[1:]
        return [self.joints.index(name) for name in names if name in self.joints]

    def in_model_order(self, values: Array) -> Array:
        """Return values (..., n), given in the order of the recordings, in the order of the model's joints."""
        return np.asarray(values[..., self.order])

    @cached_property
    def damping(self) -> Array:
        """(n,) viscous damping that the URDF declares [N m s/rad], in the order of the recordings."""
        return self._in_recorded_order(self.model.damping)

    @cached_property
    def friction(self) -> Array:
        """(n,) Coulomb friction that the URDF declares [N m], in the order of the recordings."""
        return self._in_recorded_order(self.model.friction)

    def _in_recorded_order(self, values: Any) -> Array:
        """Return values (n,), given in the order of the model's joints, in the order of the recordings."""
        given = np.zeros(len(self.joints))
        given[self.order] = np.asarray(values)
        return given

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name in self.__dataclass_fields__}


def _without_visuals(path: Path) -> tuple[str, tuple[str, ...]]:
    """Return the text of a URDF without visual and collision elements, and notes on undeclared links, added without mass."""
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        raise InputError(str(path), expected="a URDF", received=str(error)) from error
    if root.tag != "robot":
        raise InputError(str(path), expected="a URDF, whose first element is <robot>", received=f"<{root.tag}>")
    for link in root.iter("link"):
        for part in [part for part in link if part.tag in _VISUALS]:
            link.remove(part)
    declared = {link.get("name") for link in root.iter("link")}
    named = [end.get("link") for joint in root.findall("joint") for end in joint if end.tag in ("parent", "child")]
    missing = [name for name in dict.fromkeys(named) if name is not None and name not in declared]
    for name in missing:
        ElementTree.SubElement(root, "link", name=name)
    notes = (f"undeclared links are taken as massless: {', '.join(missing)}",) if missing else ()
    return ElementTree.tostring(root, encoding="unicode"), notes
