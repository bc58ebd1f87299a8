"""Position servos, which convert a commanded angle of a joint into a torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.optimize import nnls
from scipy.signal import savgol_filter

from hsr_pin.errors import InputError
from hsr_pin.explain.model import factor
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Prior standard deviation of the logarithm of a guessed number.
_GUESS_WIDTH = 1.0
#: Smoothing window for the estimate [samples], and the speed at which the regularised friction is nearly complete [rad/s].
_WINDOW, _SLIDING_SPEED = 21, 0.1


@dataclass(frozen=True)
class Servo:
    """Position servos of the joints: torque = stiffness (target - angle) - damping * speed, up to a limit.

    Attributes:
        stiffness: (n,) [N m/rad].
        damping: (n,) [N m s/rad].
        limit: (n,) largest torque [N m].
        guessed: whether stiffness and damping are always fitted, because they were not measured.
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    limit: tuple[float, ...]
    guessed: bool = False

    @classmethod
    def of(
        cls, joints: int, stiffness: Sequence[float], damping: Sequence[float] = (), limit: Sequence[float] = (), *, guessed: bool
    ) -> Servo:
        """Return servos with one number for each joint; damping defaults to 0 and the limit to infinity.

        Raises:
            InputError: the number of values differs from the number of joints, or a value is negative.
        """
        none = {"damping": (0.0,) * joints, "limit": (np.inf,) * joints}
        given = {"stiffness": stiffness, "damping": damping, "limit": limit}
        given = {name: values if len(values) else none.get(name, ()) for name, values in given.items()}
        for name, values in given.items():
            if len(values) != joints or not all(value >= 0 for value in values):
                expected = f"{joints} numbers of at least 0, one for each joint"
                raise InputError(f"{name} of the servo", expected=expected, received=str(list(values)))
        return cls(**{name: tuple(float(value) for value in values) for name, values in given.items()}, guessed=guessed)

    def parameters(self, joints: Sequence[str]) -> tuple[Parameter, ...]:
        """Return the factors on guessed stiffness and damping that are fitted."""
        if not self.guessed:
            return ()
        names = [f"servo_stiffness:{joint}" for joint in joints]
        names += [f"servo_damping:{joint}" for joint, damping in zip(joints, self.damping, strict=True) if damping]
        return tuple(factor(name, _GUESS_WIDTH, lower=0.05, upper=20.0) for name in names)

    def numbers(self, joints: Sequence[str], values: Sequence[Mapping[str, float]]) -> tuple[Array, Array]:
        """Return stiffness and damping, multiplied by the fitted factors, each (B, n)."""
        factors = [
            np.array([[each.get(f"{name}:{joint}", 1.0) for joint in joints] for each in values])
            for name in ("servo_stiffness", "servo_damping")
        ]
        return factors[0] * np.array(self.stiffness), factors[1] * np.array(self.damping)

    def torque(self, target: Array, position: Array) -> Array:
        """Return the torque of the servos at rest, (N, n) [N m], for targets and angles (N, n) [rad]; 0 without a target."""
        pulled = np.nan_to_num(np.array(self.stiffness) * (target - position))
        return np.clip(pulled, -np.array(self.limit), np.array(self.limit))


def estimate_servo(
    model: pin.Model, order: Sequence[int], trials: Sequence[tuple[Array, Array, Array]]
) -> dict[str, list[float]]:
    """Estimate stiffness and damping by least squares on the inverse-dynamics torques of recorded motions.

    Args:
        model: model of the robot as declared.
        order: index of the recorded joint for each joint of the model.
        trials: for each trial times (N,) [s], angles (N, n) and targets (N, n) [rad], NaN while the servo is off.

    Raises:
        InputError: a joint does not follow its target.
    """
    data, back = model.createData(), np.argsort(order)
    torques, columns = [], []
    for time, position, target in trials:
        step = float(np.median(np.diff(time)))
        even = np.arange(time[0], time[-1], step)
        angle = np.column_stack([np.interp(even, time, each) for each in position.T])
        q, v, a = (savgol_filter(angle, min(_WINDOW, len(even)), 3, deriv=n, delta=step, axis=0) for n in range(3))
        wanted = target[np.clip(np.searchsorted(time, even, side="right") - 1, 0, None)]
        moving = zip(q[:, order], v[:, order], a[:, order], strict=True)
        torques.append(np.array([pin.rnea(model, data, *each)[back] for each in moving]))
        columns.append(np.stack([wanted - q, -v, -np.tanh(v / _SLIDING_SPEED)], axis=-1))
    torque, column = np.concatenate(torques), np.concatenate(columns)
    stiffness, damping = [], []
    for k in range(torque.shape[1]):
        on = np.isfinite(column[:, k]).all(axis=1)
        found = nnls(column[on, k], torque[on, k])[0] if on.any() else np.zeros(3)
        if not found[0] > 0:
            expected = "targets that the joints follow, or [servo] with stiffness = [...] in N m/rad"
            received = f"joint {k + 1}, whose torque does not grow with its position error"
            raise InputError("target", expected=expected, received=received)
        stiffness.append(float(found[0]))
        damping.append(float(found[1]))
    return {"stiffness": stiffness, "damping": damping}
