"""State estimation from a few markers: an extended Kalman filter with a disturbance torque.

R. E. Kalman, A new approach to linear filtering and prediction problems, J. Basic Eng. 82 (1960). The disturbance, a slowly
varying torque, represents model errors: G. Pannocchia, J. B. Rawlings, Disturbance models for offset-free model-predictive
control, AIChE J. 49 (2003).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.fleet import ArmFleet
from hsr_pin.control.reach import static_pose
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import RANGES, in_plane
from hsr_pin.trajectory import Array, Marker, read_only

#: Largest step of the prediction [s].
_LONGEST = 0.01
_NO_LIMIT = RANGES["bending_limit"][2]


@dataclass(frozen=True, eq=False)
class Estimate:
    """The estimated state with its covariance.

    Attributes:
        q: (N,) angles [rad].
        v: (N,) rates [rad/s].
        disturbance: disturbance torque d in addition to the command [N m].
        covariance: (2N + 1, 2N + 1) covariance of (q, v, d).
    """

    q: Array
    v: Array
    disturbance: float
    covariance: Array

    def __post_init__(self) -> None:
        for name in ("q", "v", "covariance"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


class Observer:
    """Estimates q, v and a disturbance torque from marker positions; it keeps no state.

    Each estimate is an argument and a result of each call.

    Args:
        dynamics: the model.
        markers: (M,) measured markers.
        dt: interval between measurements [s].
        noise: standard deviation of each coordinate of a marker [m].
        joint_torque: standard deviation of unknown torques at each joint, independent in each step [N m].
        drift: change of the disturbance torque within a second (standard deviation) [N m].
    """

    def __init__(
        self,
        dynamics: ArmDynamics,
        markers: Sequence[Marker],
        dt: float,
        *,
        noise: float = 5e-4,
        joint_torque: float = 0.02,
        drift: float = 0.1,
    ) -> None:
        if not min(dt, noise, joint_torque, drift) > 0 or not markers:
            raise InputError("observer", expected="markers; dt, noise, joint_torque and drift above zero", received=len(markers))
        in_plane(dynamics.nominal, "an observer")
        self.dynamics, self.markers, self.dt = dynamics, tuple(markers), dt
        self._noise, self._joint_torque, self._drift = noise, joint_torque, drift
        self._places = dynamics.markers([marker.arc_length for marker in markers])
        unlimited = replace(dynamics.nominal, bending_limit=_NO_LIMIT)  # an estimate may be beyond the limit
        self._fleet = ArmFleet([unlimited], [dynamics.effects], step=_LONGEST)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are built anew with separate workspaces."""
        made = partial(Observer, noise=self._noise, joint_torque=self._joint_torque, drift=self._drift)
        return made, (self.dynamics, self.markers, self.dt)

    def begin(self, torque: float = 0.0, angle: float = 0.1, rate: float = 0.1, disturbance: float = 0.3) -> Estimate:
        """Return an initial estimate: equilibrium under a torque [N m], with these standard deviations.

        They are ``angle`` [rad], ``rate`` [rad/s] and ``disturbance`` [N m].
        """
        n = self.dynamics.links
        spread = np.concatenate([np.full(n, angle), np.full(n, rate), [disturbance]])
        return Estimate(static_pose(self.dynamics, torque), np.zeros(n), 0.0, np.diag(spread**2))

    def predict(self, estimate: Estimate, torque: float) -> Estimate:
        """Predict the state after one step under a command [N m] by the model, and its covariance by the linearised model."""
        n, u = self.dynamics.links, torque + estimate.disturbance
        linear = self.dynamics.linearise(estimate.q, u, estimate.v).discrete(self.dt)
        F = np.eye(2 * n + 1)
        F[:-1, :-1], F[:-1, -1] = linear.A, linear.B[:, 0]
        Q = np.zeros_like(F)
        Q[:-1, :-1] = self._joint_torque**2 * linear.joints @ linear.joints.T
        Q[-1, -1] = self._drift**2 * self.dt
        command = np.array([u])
        ahead, _ = self._fleet.advance(self._fleet.placed(estimate.q[None], estimate.v[None], command), command, self.dt)
        return Estimate(ahead.chain[0, 0], ahead.chain[1, 0], estimate.disturbance, F @ estimate.covariance @ F.T + Q)

    def correct(self, estimate: Estimate, positions: ArrayLike) -> Estimate:
        """Correct an estimate with the markers' positions (M, 3) [m] in the world frame; NaN for a marker that was not measured.

        Raises:
            InputError: the positions have another shape.
        """
        seen = np.asarray(positions, dtype=float)
        if seen.shape != (len(self.markers), 3):
            raise InputError("positions", expected=f"shape ({len(self.markers)}, 3)", received=f"shape {seen.shape}")
        innovation = (seen - self._places.positions(estimate.q))[:, [0, 2]].ravel()
        visible = np.isfinite(innovation)
        H = np.zeros((len(innovation), len(estimate.covariance)))
        H[:, : self.dynamics.links] = self._places.jacobian(estimate.q)[:, [0, 2]].reshape(len(innovation), -1)
        H, R = H[visible], self._noise**2 * np.eye(int(visible.sum()))
        P = estimate.covariance
        L = np.linalg.solve(H @ P @ H.T + R, H @ P).T
        keep = np.eye(len(P)) - L @ H
        n, change = self.dynamics.links, L @ innovation[visible]
        covariance = keep @ P @ keep.T + L @ R @ L.T  # Joseph's form stays symmetric and positive
        return Estimate(estimate.q + change[:n], estimate.v + change[n:-1], estimate.disturbance + float(change[-1]), covariance)
