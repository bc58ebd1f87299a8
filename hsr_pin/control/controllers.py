"""Laws that follow a reference with the arm's one input, in space with two for each section.

Each is a frozen dataclass: no memory, the same answer every time.
The torque of the muscles does work on y = b.q, which is the bending angle of the whole arm where the torque arrives everywhere
alike: y and u are a collocated pair, so feedback from y is passive, and what y does not show is left to the arm's own dampers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_are

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reach import static_pose
from hsr_pin.control.reference import Reference
from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array


class Controller(ABC):
    """A law of feedback."""

    @abstractmethod
    def torque(self, k: int, q: Array, v: Array) -> Any:
        """The command u [N m] from sample ``k`` of the reference to the next, at angles q (N,) [rad] and rates v (N,) [rad/s].

        In space u is (2 S,), for S sections; q and v are (N, 3).
        """


@dataclass(frozen=True, eq=False)
class OpenLoop(Controller):
    """The reference's feedforward, whatever the arm does."""

    reference: Reference

    def torque(self, k: int, q: Array, v: Array) -> Any:
        return _told(self.reference.torque[k])


@dataclass(frozen=True, eq=False)
class FeedforwardPD(Controller):
    """u = u_ff + kp (y_ref - y) + kd (dy_ref - dy): inverse dynamics along the reference, and a spring and a damper to it.

    S. Arimoto, F. Miyazaki, Stability and robustness of PID feedback control for robot manipulators, Robotics Research 1 (1984).

    Attributes:
        dynamics: the model.
        reference: what to follow.
        kp: [Nm/rad] of bending.
        kd: [Nm s/rad].
    """

    dynamics: ArmDynamics
    reference: Reference
    kp: float
    kd: float

    def torque(self, k: int, q: Array, v: Array) -> Any:
        b, r = self.dynamics.b.T, self.reference
        return _told(r.torque[k] + self.kp * (b @ (r.q[k] - np.ravel(q))) + self.kd * (b @ (r.v[k] - np.ravel(v))))


@dataclass(frozen=True, eq=False)
class ComputedTorque(Controller):
    """Inverse dynamics of where the arm is, for the acceleration a_ref + 2 w (v_ref - v) + w^2 (q_ref - q).

    J. J. Craig, Introduction to Robotics, 3rd ed., Pearson (2005), section 10.4. The arm has one input for N joints: u is the
    uniform torque nearest to the joint torques tau that this asks for, b.(tau - b u) = 0. By b.(M a + ...) = b.b u, with an exact
    model the errors e then obey b.M (d2e + 2 w de + w^2 e) = 0: what bends the arm as a whole vanishes with w, the rest is left
    to the arm's own springs and dampers. (Making d2y itself what is wanted, as in partial feedback linearisation, would ask M^-1
    for the answer, and so the fastest of the tip's modes, which no sampled command can follow.)

    Attributes:
        dynamics: the model.
        reference: what to follow.
        frequency: w [rad/s] with which errors vanish; both poles at -w.
    """

    dynamics: ArmDynamics
    reference: Reference
    frequency: float

    def torque(self, k: int, q: Array, v: Array) -> Any:
        r, w, q, v = self.reference, self.frequency, np.ravel(q), np.ravel(v)
        return self.dynamics.uniform(self.dynamics.inverse(q, v, r.a[k] + 2 * w * (r.v[k] - v) + w * w * (r.q[k] - q)))


@dataclass(frozen=True, eq=False)
class LQR(Controller):
    """u = u_ff - gain (x - x_ref), x = (q, v): the gain that is best about one pose.

    Attributes:
        reference: what to follow.
        gain: (2N,) [Nm/rad] and [Nm s/rad]; in space (2 S, 6N).
    """

    reference: Reference
    gain: Array

    def torque(self, k: int, q: Array, v: Array) -> Any:
        r = self.reference
        return _told(r.torque[k] - self.gain @ np.concatenate([np.ravel(q) - r.q[k], np.ravel(v) - r.v[k]]))


def _told(torque: Any) -> Any:
    """A number, or two for each section."""
    return float(torque) if np.ndim(torque) == 0 else torque


def lqr_gain(dynamics: ArmDynamics, torque: ArrayLike, dt: float, tip_error: float = 2e-3, effort: float = 0.1) -> Array:
    """(2N,), in space (2 S, 6N), the gain about the rest pose of a torque.

    Of least cost sum (tip error / tip_error)^2 + (torque / effort)^2.

    The command is held over each step, so the gain is that of the discrete Riccati equation: G. F. Franklin, J. D. Powell,
    M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley (1998).

    Args:
        dynamics: the model.
        torque: [N m] of the pose, in space (2 S,).
        dt: [s] between commands.
        tip_error: [m] that is as bad as
        effort: a torque of this size [N m] beside the feedforward.

    Raises:
        InputError: weights or a step that are not positive.
    """
    if not min(dt, tip_error, effort) > 0:
        raise InputError("lqr", expected="dt, tip_error and effort above zero", received=f"{dt}, {tip_error}, {effort}")
    q = static_pose(dynamics, torque)
    linear = dynamics.linearise(q, torque).discrete(dt)
    J = np.hstack([dynamics.tip_jacobian(q), np.zeros((3, len(q)))]) / tip_error
    free = np.tile(dynamics.moves, 2)  # what does not move needs no gain
    A, B, J = linear.A[np.ix_(free, free)], linear.B[free], J[:, free]
    Q, R = J.T @ J, np.eye(B.shape[1]) / effort**2
    P = solve_discrete_are(A, B, Q, R)
    gain = np.zeros((B.shape[1], len(free)))
    gain[:, free] = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    return gain if dynamics.columns.space else gain[0]
