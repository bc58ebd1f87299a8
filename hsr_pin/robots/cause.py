"""What may be missing at the joints of a robot: the interface of one cause."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from hsr_pin.explain.model import Cause
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    import pinocchio as pin

#: Kind of physics -> what it says, in a few words.
KINDS = {
    "friction": "a torque that opposes the motion of a joint, and hardly depends on its speed",
    "damping": "a torque that grows with the speed of a joint",
    "elastic": "a torque that grows with the angle of a joint",
    "contact": "an end of the way of a joint",
    "mass_gravity": "masses, inertias and gravity",
    "transmission": "what lies between the motors and the joints",
    "actuation_map": "the map from the recorded torque to the torque that acts",
    "actuation_time": "the torque comes late",
    "measurement": "what the encoders show",
}


@dataclass(frozen=True, eq=False)
class Sizes:
    """What is usual in the recordings: it sets the scales of what may be missing.

    Attributes:
        torque: (n,) [N m] RMS of each joint.
        largest: (n,) [N m] recorded of each.
        speed: (n,) [rad/s] RMS of each.
        lowest: (n,) [rad] angle of each.
        highest: (n,) [rad] likewise.
        mass: [kg] of all that moves.
        inertia: (n,) [kg m^2] seen at each joint.
        alone: (n,) [kg m^2] likewise, while the other joints yield.
        rotor: (n,) [kg m^2] declared of each motor.
        encoders: what they sit on, "joint" or "motor"; empty: nobody said it.
    """

    torque: Array
    largest: Array
    speed: Array
    lowest: Array
    highest: Array
    mass: float
    inertia: Array
    alone: Array
    rotor: Array
    encoders: str = ""

    @property
    def angle(self) -> Array:
        """(n,) [rad] half the range of each joint."""
        return np.maximum(self.highest - self.lowest, 2e-3) / 2


class Values:
    """Values of one cause for B simulations side by side, as arrays (B, n) or (B, 1)."""

    def __init__(self, cause: JointCause, joints: Sequence[str], values: Sequence[Mapping[str, float]], sizes: Sizes) -> None:
        self._cause, self._joints, self._values, self.sizes = cause, joints, values, sizes
        self._made: dict[str, Array] = {}

    def __len__(self) -> int:
        """How many simulations."""
        return len(self._values)

    def of_joints(self, name: str = "") -> Array:
        """(B, n) of each joint."""
        return self._array(name, [of(name, joint) for joint in self._joints])

    def shared(self, name: str) -> Array:
        """(B, 1) of all joints."""
        return self._array(name, [name])

    def _array(self, made: str, names: Sequence[str]) -> Array:
        """(B, K) of these names; made once."""
        if made not in self._made:
            keys = [f"{self._cause.name}.{name}" for name in names]
            self._made[made] = np.array([[each[key] for key in keys] for each in self._values])
        return self._made[made]


@dataclass(frozen=True, eq=False)
class Now:
    """B simulations at the start of a step.

    Attributes:
        q: (B, n) [rad].
        v: (B, n) [rad/s].
        driven: (B, n) [N m] torque of the motors.
        slope: (B, n) [N m s/rad] by how much that falls with the speed at the end of the step.
        h: (B, 1) [s] length of the step.
        state: of the cause that is asked, as :meth:`JointCause.after` left it.
    """

    q: Array
    v: Array
    driven: Array
    slope: Array
    h: Array
    state: Any = None


def of(name: str, joint: str) -> str:
    """What a number of a joint is called: by the joint alone where a cause has one number for each."""
    return f"{name}:{joint}" if name else joint


class JointCause(ABC):
    """One thing that the declared model of a robot may lack.

    A subclass overrides the method where it acts; the others leave the model as it is. B simulations run side by side, each with
    values of its own; amplitudes that are 0 give back the declared model.
    """

    name: ClassVar[str]
    #: One of :data:`KINDS`.
    kind: ClassVar[str]
    description: ClassVar[str]
    citation: ClassVar[str] = ""
    #: Names of causes that are special cases of this one.
    contains: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def parameters(self, joints: Sequence[str], sizes: Sizes) -> tuple[Parameter, ...]:
        """Those of a robot with these joints: of each of them, named by :func:`of`; then what they share."""

    def as_cause(self, joints: Sequence[str], sizes: Sizes) -> Cause:
        """It as a search takes it: at all joints, or at any one of them."""
        facts = self.parameters(joints, sizes)
        shared = tuple(fact.name for fact in facts if fact.name.rpartition(":")[2] not in joints)
        own = {joint: tuple(fact.name for fact in facts if fact.name.rpartition(":")[2] == joint) for joint in joints}
        single = tuple((*names, *shared) for names in own.values() if names) if len(joints) > 1 else ()
        return Cause(self.name, self.kind, facts, self.description, apart=single, contains=self.contains)

    def armature(self, values: Values) -> Array | None:
        """(B, n) [kg m^2] that is added at the joints."""
        return None

    def bodies(self, values: Values) -> Array | None:
        """(B, K) numbers that change masses or gravity; simulations that have the same share a model."""
        return None

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Change the bodies of a model by its numbers (K,); the joints are in the order of the recordings."""
        raise NotImplementedError

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """(B, N, n) the command that acts (a torque, or the target of a servo), of what was recorded at times (N,) [s]."""
        return command

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array] | None:
        """(B, n) [N m] the torque of the motors where (B, n) is commanded, and its derivative."""
        return None

    def start(self, values: Values, now: Now, a: Array) -> Any:
        """Its state at the start of a simulation in which the encoders show accelerations a (B, n); None: it has none."""
        return None

    def torque(self, values: Values, now: Now) -> tuple[Array, Array] | None:
        """(B, n) [N m] added at the joints, and (B, n) [N m s/rad] by how much it falls with the speed."""
        return None

    def after(self, values: Values, now: Now, a: Array) -> Any:
        """Its state at the end of a step in which the joints accelerate by a (B, n) [rad/s^2]."""
        return now.state

    def beside(self, values: Values, state: Any) -> tuple[Array, Array] | None:
        """(B, n) [rad] by which what the encoders sit on is ahead of the joints, and (B, n) [rad/s] motors of their speeds."""
        return None

    def shown(self, values: Values, q: Array) -> Array:
        """(B, ..., n) what the encoders show of angles (B, ..., n)."""
        return q

    def read(self, values: Values, q: Array) -> Array:
        """(B, n) the angles of which the encoders show (B, n): the inverse of :meth:`shown`."""
        return q
