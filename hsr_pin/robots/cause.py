"""Interface of one cause: physics at the joints of a robot that the declared model may lack."""

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

#: Kind of physics -> short description, which a verdict quotes.
KINDS = {
    "friction": "a torque that opposes the motion of a joint and hardly depends on its speed",
    "damping": "a resisting torque that grows with the speed of a joint",
    "elastic": "a torque that depends on the angle of a joint",
    "contact": "contact with a stop at the end of the range of a joint",
    "mass_gravity": "masses, moments of inertia and gravity",
    "transmission": "play or elasticity between the motors and the joints",
    "actuation_map": "the relation between the recorded torque and the acting torque",
    "actuation_time": "a delay or lag of the command",
    "measurement": "the relation between the true angle and the shown angle",
}


@dataclass(frozen=True, eq=False)
class Scales:
    """Typical magnitudes in the recordings, from which the scales of the causes follow.

    Attributes:
        torque: (n,) RMS torque of each joint [N m].
        max_torque: (n,) largest recorded torque of each joint [N m].
        speed: (n,) RMS speed of each joint [rad/s].
        min_angle: (n,) smallest angle of each joint [rad].
        max_angle: (n,) largest angle of each joint [rad].
        mass: total mass of the moving links [kg].
        inertia: (n,) inertia at each joint while the other joints are fixed [kg m^2].
        free_inertia: (n,) inertia at each joint while the other joints are free [kg m^2].
        rotor_inertia: (n,) declared inertia of each motor [kg m^2].
        encoders: part on which the encoders are mounted, "joint" or "motor"; empty: unknown.
        accuracy: relative standard deviation of the errors of declared numbers.
        interval: sampling interval of the recordings [s].
        declared_servos: whether there are servos whose numbers are declared, not guessed.
    """

    torque: Array
    max_torque: Array
    speed: Array
    min_angle: Array
    max_angle: Array
    mass: float
    inertia: Array
    free_inertia: Array
    rotor_inertia: Array
    encoders: str = ""
    accuracy: float = 0.0
    interval: float = 0.0
    declared_servos: bool = False

    @property
    def angle(self) -> Array:
        """(n,) half the range of each joint [rad]."""
        return np.maximum(self.max_angle - self.min_angle, 2e-3) / 2


class Values:
    """Parameter values of one cause for a batch of B simulations, as arrays (B, n) or (B, 1)."""

    def __init__(self, cause: JointCause, joints: Sequence[str], values: Sequence[Mapping[str, float]], scales: Scales) -> None:
        self._cause, self._joints, self._values, self.scales = cause, joints, values, scales
        self._cache: dict[str, Array] = {}

    def __len__(self) -> int:
        """Return the number of simulations."""
        return len(self._values)

    def of_joints(self, name: str = "") -> Array:
        """Return the values of a parameter that each joint has, (B, n)."""
        return self._array(name, [joint_parameter(name, joint) for joint in self._joints])

    def shared(self, name: str) -> Array:
        """Return the values of a parameter that all joints share, (B, 1)."""
        return self._array(name, [name])

    def of_other_cause(self, cause: str) -> Array:
        """Return the parameters of another cause with one for each joint, (B, n); 0 if the model does not have this cause."""
        return np.array([[each.get(f"{cause}.{joint}", 0.0) for joint in self._joints] for each in self._values])

    def _array(self, cache_key: str, names: Sequence[str]) -> Array:
        """Return the values of K parameters, (B, K); the array is cached."""
        if cache_key not in self._cache:
            keys = [f"{self._cause.name}.{name}" for name in names]
            self._cache[cache_key] = np.array([[each[key] for key in keys] for each in self._values])
        return self._cache[cache_key]


@dataclass(frozen=True, eq=False)
class StepStart:
    """State of a batch of B simulations at the start of a step.

    Attributes:
        q: (B, n) angles [rad].
        v: (B, n) speeds [rad/s].
        motor_torque: (B, n) torque of the motors [N m].
        slope: (B, n) decrease of the motor torque per speed at the end of the step [N m s/rad].
        h: (B, 1) length of the step [s].
        state: internal state of the cause that is called, as returned by :meth:`JointCause.next_state`.
    """

    q: Array
    v: Array
    motor_torque: Array
    slope: Array
    h: Array
    state: Any = None


def joint_parameter(name: str, joint: str) -> str:
    """Return the name of a parameter of a joint: the joint's name alone if a cause has one parameter for each joint."""
    return f"{name}:{joint}" if name else joint


class JointCause(ABC):
    """One piece of physics that the declared model of a robot may lack.

    A subclass overrides the methods through which it acts; the other methods leave the model unchanged. B simulations run as a
    batch, each with its own values; if all amplitudes are 0, the result is the declared model.
    """

    name: ClassVar[str]
    #: One of :data:`KINDS`.
    kind: ClassVar[str]
    description: ClassVar[str]
    citation: ClassVar[str] = ""
    #: Names of the causes that are special cases of this one.
    contains: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the parameters for a robot: those of each joint, named by :func:`joint_parameter`, then shared ones."""

    def as_cause(self, joints: Sequence[str], scales: Scales) -> Cause:
        """Return the cause in the form that the search needs, with variants for all joints and for each single joint."""
        facts = self.parameters(joints, scales)
        shared = tuple(fact.name for fact in facts if fact.name.rpartition(":")[2] not in joints)
        own = {joint: tuple(fact.name for fact in facts if fact.name.rpartition(":")[2] == joint) for joint in joints}
        single = tuple((*names, *shared) for names in own.values() if names) if len(joints) > 1 else ()
        return Cause(self.name, self.kind, facts, self.description, apart=single, contains=self.contains)

    def armature(self, values: Values) -> Array | None:
        """Return the inertia added at the joints, (B, n) [kg m^2], or None."""
        return None

    def bodies(self, values: Values) -> Array | None:
        """Return K numbers that change masses or gravity, (B, K), or None; simulations with equal numbers share a model."""
        return None

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Change the bodies of a model by its numbers (K,); the joints are in the order of the recordings."""
        raise NotImplementedError

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """Return the acting command (a torque, or the target of a servo), (B, N, n), for the one recorded at times (N,) [s]."""
        return command

    def servo(self, values: Values) -> tuple[Array, Array] | None:
        """Return the factors on stiffness and damping of the servos, each (B, n), or None."""
        return None

    def drive(self, values: Values, torque: Array) -> tuple[Array, Array] | None:
        """Return the torque of the motors for a commanded torque (B, n) [N m], and its derivative, or None."""
        return None

    def initial_state(self, values: Values, now: StepStart, a: Array) -> Any:
        """Return the internal state at the start with joint accelerations a (B, n) [rad/s^2]; None: the cause has no state."""
        return None

    def torque(self, values: Values, now: StepStart) -> tuple[Array, Array] | None:
        """Return the torque added at the joints, (B, n) [N m], and its decrease per speed, (B, n) [N m s/rad], or None."""
        return None

    def next_state(self, values: Values, now: StepStart, a: Array) -> Any:
        """Return the internal state at the end of a step with joint accelerations a (B, n) [rad/s^2]."""
        return now.state

    def encoder_lead(self, values: Values, state: Any) -> tuple[Array, Array] | None:
        """Return the lead of the encoders over the joints [rad], and the relative motor speed [rad/s], each (B, n), or None."""
        return None

    def encoder_reading(self, values: Values, q: Array) -> Array:
        """Return the angles that the encoders show, (B, ..., n) [rad], for true angles (B, ..., n)."""
        return q

    def true_angle(self, values: Values, q: Array) -> Array:
        """Return the true angles, (B, n) [rad], for shown angles (B, n): the inverse of :meth:`encoder_reading`."""
        return q
