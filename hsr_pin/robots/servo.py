"""Position servos: the torque of a joint that is commanded by an angle."""

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

#: Standard deviation of the logarithm of a number that was guessed.
_GUESSED = 1.0
#: Samples over which motion is smoothed to guess from it, and the speed [rad/s] from which on friction has its full size.
_WINDOW, _SLIDES = 21, 0.1


@dataclass(frozen=True)
class Servo:
    """Motors that pull each joint to its target: torque = stiffness (target - angle) - damping * speed, up to a limit.

    Attributes:
        stiffness: (n,) [N m/rad].
        damping: (n,) [N m s/rad].
        limit: (n,) [N m] that the torque does not exceed.
        guessed: whether stiffness and damping are fitted in any case, since nobody measured them.
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    limit: tuple[float, ...]
    guessed: bool = False

    @classmethod
    def of(
        cls, joints: int, stiffness: Sequence[float], damping: Sequence[float] = (), limit: Sequence[float] = (), *, guessed: bool
    ) -> Servo:
        """With a number for each joint; no damping and no limit unless they are given.

        Raises:
            InputError: another count of numbers, or numbers that cannot be.
        """
        none = {"damping": (0.0,) * joints, "limit": (np.inf,) * joints}
        given = {"stiffness": stiffness, "damping": damping, "limit": limit}
        given = {name: values if len(values) else none.get(name, ()) for name, values in given.items()}
        for name, values in given.items():
            if len(values) != joints or not all(value >= 0 for value in values):
                expected = f"{joints} numbers, none negative, one for each joint"
                raise InputError(f"{name} of the servo", expected=expected, received=str(list(values)))
        return cls(**{name: tuple(float(value) for value in values) for name, values in given.items()}, guessed=guessed)

    def parameters(self, joints: Sequence[str]) -> tuple[Parameter, ...]:
        """Factors on what was guessed."""
        if not self.guessed:
            return ()
        names = [f"servo_stiffness:{joint}" for joint in joints]
        names += [f"servo_damping:{joint}" for joint, damping in zip(joints, self.damping, strict=True) if damping]
        return tuple(factor(name, _GUESSED, lower=0.05, upper=20.0) for name in names)

    def numbers(self, joints: Sequence[str], values: Sequence[Mapping[str, float]]) -> tuple[Array, Array]:
        """(B, n) stiffness and damping with those factors."""
        factors = [
            np.array([[each.get(f"{name}:{joint}", 1.0) for joint in joints] for each in values])
            for name in ("servo_stiffness", "servo_damping")
        ]
        return factors[0] * np.array(self.stiffness), factors[1] * np.array(self.damping)

    def torque(self, target: Array, position: Array) -> Array:
        """(N, n) [N m] for a joint that is at rest, of targets and angles (N, n) [rad]; 0 where there is no target."""
        pulled = np.nan_to_num(np.array(self.stiffness) * (target - position))
        return np.clip(pulled, -np.array(self.limit), np.array(self.limit))


def guess_servo(model: pin.Model, order: Sequence[int], trials: Sequence[tuple[Array, Array, Array]]) -> dict[str, list[float]]:
    """Stiffness and damping by least squares on the torques that recorded motions took.

    Args:
        model: of the robot as declared.
        order: which of the recorded joints each of the model's is.
        trials: of each, (N,) times [s], (N, n) angles and (N, n) targets [rad], NaN while the servo is off.

    Raises:
        InputError: a joint that does not go where its target is.
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
        columns.append(np.stack([wanted - q, -v, -np.tanh(v / _SLIDES)], axis=-1))
    torque, column = np.concatenate(torques), np.concatenate(columns)
    stiffness, damping = [], []
    for k in range(torque.shape[1]):
        on = np.isfinite(column[:, k]).all(axis=1)
        found = nnls(column[on, k], torque[on, k])[0] if on.any() else np.zeros(3)
        if not found[0] > 0:
            expected = "targets that the joints follow, or [servo] with stiffness = [...] in N m/rad"
            raise InputError("target", expected=expected, received=f"joint {k + 1}, whose torque does not grow with its error")
        stiffness.append(float(found[0]))
        damping.append(float(found[1]))
    return {"stiffness": stiffness, "damping": damping}
