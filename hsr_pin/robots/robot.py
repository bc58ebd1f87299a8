"""A robot of rigid links as its URDF declares it, with the joints that were recorded; the others are locked."""

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

#: Parts of a URDF that say nothing of how it moves, and name files that may be absent.
_SEEN = ("visual", "collision")
#: Where encoders are.
_SIDES = ("", "joint", "motor")


@dataclass(frozen=True, eq=False)
class Robot:
    """A serial robot of rigid links.

    Attributes:
        urdf: its text, without pictures.
        joints: (n,) names of those that move, in the order of the recordings.
        rotor_inertia: (n,) [kg m^2] of the motors, as seen at the joints.
        gravity: (3,) [m/s^2].
        encoders: what they sit on, "joint" or "motor" where there is play or a spring between the two; empty: unknown.
        servo: how the joints are driven, where angles are commanded; None: torques are.
        notes: what was added to the URDF.
    """

    urdf: str
    joints: tuple[str, ...]
    rotor_inertia: tuple[float, ...]
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    encoders: str = ""
    servo: Servo | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def load(cls, path: str | Path, joints: Sequence[str], rotor_inertia: Sequence[float] = (), **more: Any) -> Robot:
        """From a file.

        Args:
            path: of the URDF.
            joints: names of those that were recorded.
            rotor_inertia: [kg m^2] of each, as seen at the joint; default: none.
            more: ``gravity``, ``encoders``, ``servo``.

        Raises:
            InputError: a file that is no URDF, or that has not these joints.
        """
        text, notes = _plain(Path(path))
        robot = cls(text, tuple(joints), tuple(rotor_inertia) or (0.0,) * len(joints), notes=notes, **more)
        if len(robot.rotor_inertia) != len(joints):
            expected, received = f"{len(joints)} numbers, one for each joint", len(robot.rotor_inertia)
            raise InputError("rotor_inertia", expected=expected, received=received)
        if robot.encoders not in _SIDES:
            raise InputError("encoders", expected=" or ".join(filter(None, _SIDES)), received=quoted(robot.encoders))
        if robot.model.nv != len(joints):
            raise InputError(f"joints of {path}", expected="joints with one angle or way each", received=", ".join(joints))
        return robot

    @cached_property
    def model(self) -> pin.Model:
        """Of Pinocchio, with the motors' inertia.

        Raises:
            InputError: a joint that there is not.
        """
        whole = pin.buildModelFromXML(self.urdf)
        names = list(whole.names)[1:]
        if unknown := [name for name in self.joints if name not in names]:
            raise InputError("joints", expected=f"names among {', '.join(names)}", received=quoted(unknown[0]))
        locked = [whole.getJointId(name) for name in names if name not in self.joints]
        model = pin.buildReducedModel(whole, locked, pin.neutral(whole)) if locked else whole
        model.gravity.linear = np.array(self.gravity)
        model.armature = self.sorted(np.array(self.rotor_inertia))
        return model

    @cached_property
    def order(self) -> list[int]:
        """Which of the recorded joints each of the model's is."""
        names = list(pin.buildModelFromXML(self.urdf).names)[1:]
        return [self.joints.index(name) for name in names if name in self.joints]

    def sorted(self, values: Array) -> Array:
        """(..., n) in the order of the recordings -> in the order of the model's joints."""
        return np.asarray(values[..., self.order])

    @cached_property
    def damping(self) -> Array:
        """(n,) [N m s/rad] that the URDF declares, in the order of the recordings."""
        return self._recorded(self.model.damping)

    @cached_property
    def friction(self) -> Array:
        """(n,) [N m] that the URDF declares, in the order of the recordings."""
        return self._recorded(self.model.friction)

    def _recorded(self, values: Any) -> Array:
        """(n,) in the order of the model's joints -> in the order of the recordings."""
        given = np.zeros(len(self.joints))
        given[self.order] = np.asarray(values)
        return given

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name in self.__dataclass_fields__}


def _plain(path: Path) -> tuple[str, tuple[str, ...]]:
    """The text of a URDF without pictures, with the links that its joints name and nobody declared; and what was added."""
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        raise InputError(str(path), expected="a URDF", received=str(error)) from error
    if root.tag != "robot":
        raise InputError(str(path), expected="a URDF, whose first element is <robot>", received=f"<{root.tag}>")
    for link in root.iter("link"):
        for part in [part for part in link if part.tag in _SEEN]:
            link.remove(part)
    declared = {link.get("name") for link in root.iter("link")}
    named = [end.get("link") for joint in root.findall("joint") for end in joint if end.tag in ("parent", "child")]
    missing = [name for name in dict.fromkeys(named) if name is not None and name not in declared]
    for name in missing:
        ElementTree.SubElement(root, "link", name=name)
    notes = (f"links without a declaration were taken as massless: {', '.join(missing)}",) if missing else ()
    return ElementTree.tostring(root, encoding="unicode"), notes
