"""Errors of the declared numbers of a robot within their tolerances.

Masses, centres of mass and moments of inertia are never declared exactly, nor are the inertia of rotors and the numbers of
servos. Their errors are independent, with the relative standard deviation that ``accuracy`` in ``robot.toml`` gives. The instants
at which commands act are known to within one sampling interval.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from hsr_pin.explain.model import amplitude
from hsr_pin.parameters import Parameter
from hsr_pin.robots.cause import JointCause, Scales, Values
from hsr_pin.robots.causes.dead_time import delayed
from hsr_pin.trajectory import Array

#: Numbers of one link: mass, moments of inertia, and the centre of mass along three axes.
_OF_LINK = 5


class DeclaredNumbers(JointCause):
    """Errors of the declared numbers and of the instants of commands, in standard deviations."""

    name = "tolerance"
    kind = "mass_gravity"
    description = "errors of the declared numbers within their tolerances"

    def parameters(self, joints: Sequence[str], scales: Scales) -> tuple[Parameter, ...]:
        """Return the errors of each link's numbers, each declared rotor inertia, each servo, and the instants of commands."""
        found = [f"{number}:{joint}" for joint in joints for number in range(_OF_LINK)]
        found += [f"rotor:{joint}" for joint in joints if scales.rotor_inertia.any()]
        found += [f"{number}:{joint}" for joint in joints for number in ("stiffness", "damping") if scales.declared_servos]
        return tuple(amplitude(name, 1.0) for name in (*found, "instant"))

    def named(self, joints: Sequence[str], scales: Scales) -> list[str]:
        """Return the names of the errors in the values of a simulation."""
        return [f"{self.name}.{fact.name}" for fact in self.parameters(joints, scales)]

    def bodies(self, values: Values) -> Array:
        """Return the relative errors of the links, (B, 5 n)."""
        return values.scales.accuracy * np.hstack([values.of_joints(str(number)) for number in range(_OF_LINK)])

    def armature(self, values: Values) -> Array | None:
        """Return the errors of the rotors' inertia, (B, n) [kg m^2]."""
        if not values.scales.rotor_inertia.any():
            return None
        return values.scales.accuracy * values.of_joints("rotor") * values.scales.rotor_inertia

    def command(self, values: Values, time: Array, command: Array) -> Array:
        """Return the commands shifted by the error of their instants."""
        return delayed(time, command, values.scales.interval / np.sqrt(12) * values.shared("instant")[:, 0])

    def servo(self, values: Values) -> tuple[Array, Array] | None:
        """Return the factors on stiffness and damping of the servos, each (B, n)."""
        accuracy = values.scales.accuracy
        if not values.scales.declared_servos:
            return None
        return 1 + accuracy * values.of_joints("stiffness"), 1 + accuracy * values.of_joints("damping")

    def change_bodies(self, numbers: Array, joints: Sequence[str], model: pin.Model) -> None:
        """Change the links; the centre of mass moves by a share of the link's largest radius of gyration about its joint."""
        for joint, (mass, moment, *shift) in zip(joints, numbers.reshape(_OF_LINK, -1).T, strict=True):
            k = model.getJointId(joint)
            own = model.inertias[k]
            if own.mass > 0:
                size = np.sqrt(own.lever @ own.lever + np.trace(own.inertia) / (2 * own.mass))
                lever = own.lever + size * np.array(shift)
                model.inertias[k] = pin.Inertia((1 + mass) * own.mass, lever, (1 + mass) * (1 + moment) * own.inertia)


#: The errors of the declared numbers of any robot.
DECLARED = DeclaredNumbers()
