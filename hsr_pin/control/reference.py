"""A motion to follow: the tip moves along the curve on which it can rest, slowly enough that the arm keeps to its rest poses."""

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
    """What to follow.

    Attributes:
        time: (T,) [s] evenly spaced.
        tip: (T, 3) [m] in the world frame.
        q, v, a: (T, N) [rad], [rad/s], [rad/s^2]; in space (T, 3 N).
        torque: (T,) [N m], in space (T, 2 S), feedforward: the uniform torque nearest to what inverse dynamics asks for.
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
        """Time between samples [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


def reference_from_torque(dynamics: ArmDynamics, time: ArrayLike, torque: ArrayLike) -> Reference:
    """Through the rest poses of a torque (T,) [N m], in space (T, 2 S), that varies smoothly over even times (T,) [s], T > 5.

    Raises:
        InputError: arrays of other shapes, or a torque that the arm cannot rest under.
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
    """From rest at the first of some tip positions to the next, and so on, each move with least jerk.

    T. Flash, N. Hogan, The coordination of arm movements, J. Neurosci. 5 (1985).

    Args:
        dynamics: the arm.
        tips: (K, 2) x and z, or (K, 3) [m], as in space; where one is out of reach, the nearest point is taken.
        torque_range: lowest and highest torque [N m].
        move: [s] from one to the next.
        hold: [s] at rest at each.
        step: [s].
    """
    levels = [np.asarray(rest_at_tip(dynamics, tip, torque_range).torque) for tip in np.asarray(tips, dtype=float)]
    time = np.arange(round((hold + (len(levels) - 1) * (move + hold)) / step) + 1) * step
    torque = np.repeat(levels[0][None], len(time), axis=0)
    for number, (before, after) in enumerate(pairwise(levels)):
        s = np.clip((time - hold - number * (move + hold)) / move, 0.0, 1.0)
        torque += (np.multiply.outer(after - before, s**3) * (10 - 15 * s + 6 * s**2)).T
    return reference_from_torque(dynamics, time, torque)
