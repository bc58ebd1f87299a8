"""Feedback controllers that follow a reference with the single input of the arm, in space with two inputs per section.

Each controller is a frozen dataclass without memory: equal arguments give equal results.
The torque of the actuators does work on y = b.q, which is the bending angle of the whole arm if the torque is uniform. y and u
are a collocated pair, so feedback from y is passive, and motion that y does not show is damped by the arm's own dampers.
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
    """Base class of feedback controllers."""

    @abstractmethod
    def torque(self, k: int, q: Array, v: Array) -> Any:
        """Return the command u [N m] for the interval from sample ``k`` of the reference to the next.

        The angles q [rad] and rates v [rad/s] are (N,), of arms in space (N, 3); u is then (2 S,) for S sections.
        """


@dataclass(frozen=True, eq=False)
class OpenLoop(Controller):
    """Feedforward of the reference without feedback."""

    reference: Reference

    def torque(self, k: int, q: Array, v: Array) -> Any:
        return _as_command(self.reference.torque[k])


@dataclass(frozen=True, eq=False)
class FeedforwardPD(Controller):
    """PD control with feedforward: u = u_ff + kp (y_ref - y) + kd (dy_ref - dy).

    The feedforward is the inverse dynamics along the reference. S. Arimoto, F. Miyazaki, Stability and robustness of PID feedback
    control for robot manipulators, Robotics Research 1 (1984).

    Attributes:
        dynamics: the model.
        reference: the motion to follow.
        kp: proportional gain [Nm/rad] of bending.
        kd: derivative gain [Nm s/rad] of bending.
    """

    dynamics: ArmDynamics
    reference: Reference
    kp: float
    kd: float

    def torque(self, k: int, q: Array, v: Array) -> Any:
        b, r = self.dynamics.b.T, self.reference
        return _as_command(r.torque[k] + self.kp * (b @ (r.q[k] - np.ravel(q))) + self.kd * (b @ (r.v[k] - np.ravel(v))))


@dataclass(frozen=True, eq=False)
class ComputedTorque(Controller):
    """Computed-torque control: inverse dynamics of the current state for a_ref + 2 w (v_ref - v) + w^2 (q_ref - q).

    J. J. Craig, Introduction to Robotics, 3rd ed., Pearson (2005), section 10.4. The arm has one input for N joints: u is the
    uniform torque nearest to the required joint torques tau, b.(tau - b u) = 0. From b.(M a + ...) = b.b u, with an exact model
    the errors e obey b.M (d2e + 2 w de + w^2 e) = 0: the bending of the whole arm converges with w, and the arm's own springs and
    dampers control the rest. (Prescribing d2y itself, as in partial feedback linearisation, would require M^-1 and therefore the
    fastest modes of the tip, which no sampled command can follow.)

    Attributes:
        dynamics: the model.
        reference: the motion to follow.
        frequency: frequency w [rad/s] at which errors vanish; both poles are at -w.
    """

    dynamics: ArmDynamics
    reference: Reference
    frequency: float

    def torque(self, k: int, q: Array, v: Array) -> Any:
        r, w, q, v = self.reference, self.frequency, np.ravel(q), np.ravel(v)
        return self.dynamics.uniform(self.dynamics.inverse(q, v, r.a[k] + 2 * w * (r.v[k] - v) + w * w * (r.q[k] - q)))


@dataclass(frozen=True, eq=False)
class LQR(Controller):
    """Linear-quadratic regulator about one pose: u = u_ff - gain (x - x_ref), x = (q, v).

    Attributes:
        reference: the motion to follow.
        gain: (2N,) [Nm/rad] and [Nm s/rad]; in space (2 S, 6N).
    """

    reference: Reference
    gain: Array

    def torque(self, k: int, q: Array, v: Array) -> Any:
        r = self.reference
        return _as_command(r.torque[k] - self.gain @ np.concatenate([np.ravel(q) - r.q[k], np.ravel(v) - r.v[k]]))


def _as_command(torque: Any) -> Any:
    """Return a torque as a number, or as an array of two components for each section."""
    return float(torque) if np.ndim(torque) == 0 else torque


def lqr_gain(dynamics: ArmDynamics, torque: ArrayLike, dt: float, tip_error: float = 2e-3, effort: float = 0.1) -> Array:
    """Return the LQR gain (2N,), in space (2 S, 6N), about the equilibrium pose of a torque.

    It minimises the sum of (tip error / tip_error)^2 + (torque / effort)^2. The command is held over each step, so the gain is
    that of the discrete Riccati equation: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd
    ed., Addison-Wesley (1998).

    Args:
        dynamics: the model.
        torque: torque of the pose [N m], in space (2 S,).
        dt: interval between commands [s].
        tip_error: tip error that has the same cost as ``effort`` [m].
        effort: torque in addition to the feedforward that has the same cost as ``tip_error`` [N m].

    Raises:
        InputError: a weight or the step is not positive.
    """
    if not min(dt, tip_error, effort) > 0:
        raise InputError("lqr", expected="dt, tip_error and effort above zero", received=f"{dt}, {tip_error}, {effort}")
    q = static_pose(dynamics, torque)
    linear = dynamics.linearise(q, torque).discrete(dt)
    J = np.hstack([dynamics.tip_jacobian(q), np.zeros((3, len(q)))]) / tip_error
    free = np.tile(dynamics.moves, 2)  # fixed coordinates need no gain
    A, B, J = linear.A[np.ix_(free, free)], linear.B[free], J[:, free]
    Q, R = J.T @ J, np.eye(B.shape[1]) / effort**2
    P = solve_discrete_are(A, B, Q, R)
    gain = np.zeros((B.shape[1], len(free)))
    gain[:, free] = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    return gain if dynamics.batch.space else gain[0]
