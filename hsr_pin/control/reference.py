"""Reference motions: the tip moves slowly along its equilibrium positions, so the arm stays close to its equilibrium poses."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import rest_at_tip, static_pose
from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array, read_only


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion to follow.

    Attributes:
        time: (T,) evenly spaced times [s].
        tip: (T, 3) tip positions in the world frame [m].
        q, v, a: (T, N) angles [rad], rates [rad/s] and accelerations [rad/s^2]; in space (T, 3 N).
        torque: (T,) feedforward torque, in space (T, 2 S) [N m]: the uniform torque nearest to the inverse dynamics.
    """

    time: Array
    tip: Array
    q: Array
    v: Array
    a: Array
    torque: Array

    def __post_init__(self) -> None:
        for name in ("time", "tip", "q", "v", "a", "torque"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def step(self) -> float:
        """Sampling interval [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


def reference_from_torque(dynamics: ArmDynamics, time: ArrayLike, torque: ArrayLike) -> Reference:
    """Return a reference through the equilibrium poses of a smooth torque (T,) [N m], in space (T, 2 S).

    The times (T,) [s] are evenly spaced, T > 5.

    Raises:
        InputError: the arrays have other shapes, or the arm has no equilibrium under a torque.
    """
    t, u = np.asarray(time, dtype=float), np.asarray(torque, dtype=float)
    if t.ndim != 1 or u.shape != (*t.shape, *dynamics.b.shape[1:]) or len(t) < 6 or np.any(np.diff(t) <= 0):
        raise InputError(
            "reference", expected="six or more increasing times, a torque for each", received=f"{t.shape}, {u.shape}"
        )
    q = static_pose(dynamics, u)
    spline = make_interp_spline(t, q, k=5)
    v, a = spline.derivative(1)(t), spline.derivative(2)(t)
    needed = [dynamics.uniform(dynamics.inverse(*row)) for row in zip(q, v, a, strict=True)]
    return Reference(t, dynamics.tip(q), q, v, a, np.array(needed))


def reference_through_tips(
    dynamics: ArmDynamics,
    tips: ArrayLike,
    torque_range: tuple[float, float],
    *,
    move: float = 0.8,
    hold: float = 0.4,
    step: float = 0.01,
) -> Reference:
    """Return a reference through equilibrium positions of the tip, with minimum-jerk moves between them.

    T. Flash, N. Hogan, The coordination of arm movements, J. Neurosci. 5 (1985).

    Args:
        dynamics: the arm.
        tips: (K, 2) x and z, or (K, 3), as in space [m]; a position out of reach is replaced by the nearest one.
        torque_range: lowest and highest torque [N m].
        move: duration of each move [s].
        hold: duration at rest at each position [s].
        step: sampling interval [s].
    """
    levels = [np.asarray(rest_at_tip(dynamics, tip, torque_range).torque) for tip in np.asarray(tips, dtype=float)]
    time = np.arange(round((hold + (len(levels) - 1) * (move + hold)) / step) + 1) * step
    torque = np.repeat(levels[0][None], len(time), axis=0)
    for number, (before, after) in enumerate(pairwise(levels)):
        s = np.clip((time - hold - number * (move + hold)) / move, 0.0, 1.0)
        torque += (np.multiply.outer(after - before, s**3) * (10 - 15 * s + 6 * s**2)).T
    return reference_from_torque(dynamics, time, torque)
