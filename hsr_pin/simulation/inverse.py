"""Inverse dynamics by the recursive Newton-Euler algorithm: the torque or the pressures that produce a given motion.

J. Y. S. Luh, M. W. Walker, R. P. C. Paul, On-line computational scheme for mechanical manipulators, J. Dyn. Sys. Meas. Control
102 (1980); ``pin.rnea``. A motion consists of angles q [rad], rates v [rad/s] and accelerations a [rad/s^2], (T, N) each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.pressure import PressureMap
from hsr_pin.robot.specification import ArmSpecification, in_plane
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.reference import add_joint_moments
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class RequiredTorque:
    """The uniform torque nearest to the torques that a motion requires.

    Attributes:
        torque: (T,) torque that the actuators must deliver [N m].
        residual: (T, N) required joint torques minus the delivered ones [N m]; no uniform torque removes this residual.
    """

    torque: Array
    residual: Array


def joint_torques(arm: ArmSpecification, q: ArrayLike, v: ArrayLike, a: ArrayLike, effects: Sequence[Effect] = ()) -> Array:
    """Return the torques (T, N) [N m] that the actuators must deliver at the joints.

    They are the torques of the rigid bodies (RNEA) plus those that overcome springs, dampers and effects.

    Raises:
        InputError: the arrays are not (T, N), an effect has a memory (its moment does not follow from q and v), or the arm has
            obstacles.
    """
    batch = _batch(arm, effects)
    q, v, a = (_checked(name, x, arm.links) for name, x in (("q", q), ("v", v), ("a", a)))
    if not q.shape == v.shape == a.shape:
        raise InputError("motion", expected="q, v and a of the same shape", received=f"{q.shape}, {v.shape}, {a.shape}")
    system, chain = batch.pinocchio("rnea"), batch.arrays
    needed = np.array([pin.rnea(system.models[0], system.data[0], *row) for row in zip(q, v, a, strict=True)]).reshape(q.shape)
    moment = np.zeros(q.shape)
    add_joint_moments(system, q, v, np.zeros((0, *q.shape)), moment)
    return np.asarray(needed + chain.spring * q + chain.damper * v + moment)


def required_torque(
    arm: ArmSpecification, q: ArrayLike, v: ArrayLike, a: ArrayLike, effects: Sequence[Effect] = ()
) -> RequiredTorque:
    """Return the torque, distributed along the arm as the actuators act, that best produces a motion (least squares).

    The result is the torque that must arrive at the arm: lag, dead time and other effects on the command are not inverted.
    """
    share = _batch(arm, effects).arrays.share[0]
    tau = joint_torques(arm, q, v, a, effects)
    torque = tau @ share / (share @ share)
    return RequiredTorque(torque, tau - torque[:, None] * share)


def required_pressures(
    arm: ArmSpecification,
    q: ArrayLike,
    v: ArrayLike,
    a: ArrayLike,
    effects: Sequence[Effect] = (),
    pressure_map: PressureMap | None = None,
) -> Array:
    """Return the pressures P1 and P2 (T, 2) [bar] that deliver :func:`required_torque` at the arm's stiffness.

    Raises:
        PressureError: the motion requires pressures out of range.
    """
    pressures = pressure_map or PressureMap.fit()
    return pressures.pressures_for_torque(arm.keq, required_torque(arm, q, v, a, effects).torque)


def _batch(arm: ArmSpecification, effects: Sequence[Effect]) -> ArmBatch:
    with_memory = [effect.name for effect in effects if effect.states]
    if with_memory:
        raise InputError("effects", expected="only effects without memory", received=", ".join(with_memory))
    scenario = Scenario(in_plane(arm, "inverse dynamics"), np.array([0.0, 1.0]), np.zeros(2), effects=tuple(effects))
    batch = ArmBatch.of([scenario])
    if batch.world.shape[1]:
        hint = "contact forces do not follow from the motion alone"
        raise InputError("obstacles", expected="none for inverse dynamics", received=batch.world.shape[1], hint=hint)
    return batch


def _checked(name: str, values: ArrayLike, links: int) -> Array:
    array = np.asarray(values, dtype=float)
    if array.ndim != 2 or array.shape[1] != links or not np.all(np.isfinite(array)):
        raise InputError(name, expected=f"finite values (T, {links})", received=f"shape {array.shape}")
    return array
