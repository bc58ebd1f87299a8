"""The dynamics of an arm for controllers, in the paper's notation: M(q) a + C(q, v) v + G(q) = b u - K q - D v.

q (N,) [rad], v (N,) [rad/s], a (N,) [rad/s^2] are angles, rates and accelerations of the joints; u [N m] is the single input, the
torque of the actuators, which acts on every joint (b = 1, unless an effect changes it). For an arm in space N stands for its 3 N
coordinates (towards x, towards y and twist of each joint, as a row or (N, 3)); u has two components for each of S sections, one
if the arm has none, and b is (3 N, 2 S).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.control.bodies import Bodies, Hinged, Spherical
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.robot.space_kinematics import SpaceMarkerMap, space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array

#: Methods through which known effects may act, so that the model stays linear in springs, dampers and input.
_KNOWABLE = ("arm", "stiffness", "damping", "actuation")
_HOOKS = (*_KNOWABLE, "actuator_response", "command_delay", "moment", "contact_force", "obstacle", "update", "observe")


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Linearised dynamics d/dt (x - x0) = A (x - x0) + B (u - u0) + rate, x = (q, v).

    Attributes:
        A: (2N, 2N) state matrix.
        B: (2N, 1) input matrix; in space (2N, 2 S).
        joints: (2N, N) input matrix of separate torques at the joints [N m]; B = joints b.
        rate: (2N,) dx/dt at the pose itself; zero in an equilibrium.
    """

    A: Array
    B: Array
    joints: Array
    rate: Array

    def discrete(self, dt: float) -> Linearisation:
        """Return the dynamics over a step of ``dt`` [s] with constant torques: x+ - x0 = A (x - x0) + B (u - u0) + rate.

        One matrix exponential gives all matrices: C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE TAC
        23 (1978).
        """
        n, inputs = len(self.A), np.column_stack([self.B, self.joints, self.rate])
        block = _exponential(dt * np.vstack([np.hstack([self.A, inputs]), np.zeros((inputs.shape[1], n + inputs.shape[1]))]))
        first = n + self.B.shape[1]
        return Linearisation(block[:n, :n], block[:n, n:first], block[:n, first:-1], block[:n, -1])


class ArmDynamics:
    """The equations of motion of one arm in air: obstacles of the arm are not part of them.

    Args:
        arm: the nominal arm.
        effects: known effects, which change its bodies, or its stiffness, damping or actuation along the arm.

    Attributes:
        batch: the arm with the effects, for the simulation.
        nominal: the arm without the effects.
        arm: the arm with what they make of its bodies.
        K: (N,) stiffness of the joints [Nm/rad].
        D: (N,) damping of the joints [Nm s/rad].
        b: (N,) share of the torque that arrives at each joint; in space (3 N, 2 S), of each section's torque.
        moves: (N,) which coordinates move; in space a twist that is infinitely stiff does not.

    Raises:
        InputError: an effect acts in another way (it has a memory, is nonlinear, or acts on the command or the markers), or the
            arm has more sections than links, so that their torques are not distinguishable.
    """

    def __init__(self, arm: ArmSpecification, effects: Sequence[Effect] = ()) -> None:
        strange = [e.name for e in effects if any(e.acts_through(hook) for hook in _HOOKS if hook not in _KNOWABLE)]
        if strange:
            expected = f"known ones that act through {', '.join(_KNOWABLE)} only"
            raise InputError("effects", expected=expected, received=", ".join(strange))
        if len(arm.sections) > arm.links:
            raise InputError("links", expected=f"at least {len(arm.sections)}, one for each section", received=arm.links)
        space = arm.bending == "space"
        still = np.zeros((2, 2 * max(1, len(arm.sections))) if space else 2)
        self.batch = batch = ArmBatch.of([Scenario(arm, np.array([0.0, 1.0]), still, effects=tuple(effects))])
        self.nominal, self.effects = arm, tuple(effects)
        self.arm = batch.arms.specification(0)
        rows = batch.arrays
        self.K, self.D, self.b = (each[0].copy() for each in (rows.spring, rows.damper, rows.share))
        self.moves = np.ones(len(self.K), dtype=bool)
        self._bodies: Bodies
        if space:
            self.moves = np.isfinite(np.column_stack([self.K, self.K, rows.twist[0]])).ravel()
            self.K = np.nan_to_num(np.column_stack([self.K, self.K, rows.twist[0]]), posinf=0.0).ravel()
            self.D = np.nan_to_num(np.column_stack([self.D, self.D, rows.twist_damper[0]]), posinf=0.0).ravel()
            self.b = np.kron(self.b[:, None] * rows.inputs, np.eye(3, 2))
            self._bodies = Spherical(batch, self.moves)
        else:
            self._bodies = Hinged(batch)
        self._tip = self.markers([self.arm.length])

    @property
    def links(self) -> int:
        """Number N of links."""
        return self.arm.links

    def M(self, q: ArrayLike) -> Array:
        """Return the mass matrix (N, N) [kg m^2], by the composite-rigid-body algorithm."""
        return self._bodies.mass(self._vector("q", q))

    def C(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Return the matrix (N, N) [kg m^2/s] of Coriolis and centrifugal terms for which dM/dt - 2 C is skew-symmetric."""
        return self._bodies.coriolis(self._vector("q", q), self._vector("v", v))

    def G(self, q: ArrayLike) -> Array:
        """Return the gravity torques (N,) [N m]."""
        still = np.zeros(len(self.K))
        return self._bodies.torques(self._vector("q", q), still, still)

    def inverse(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the joint torques (N,) [N m] for the acceleration ``a``: RNEA plus springs and dampers."""
        q, v = self._vector("q", q), self._vector("v", v)
        return np.asarray(self._bodies.torques(q, v, self._vector("a", a)) + self.K * q + self.D * v)

    def uniform(self, torques: ArrayLike) -> Any:
        """Return the torque u [N m] whose b u is nearest to given joint torques (N,) [N m]; in space (2 S,)."""
        if self.b.ndim > 1:
            return np.linalg.solve(self.b.T @ self.b, self.b.T @ np.asarray(torques))
        return float(self.b @ np.asarray(torques) / (self.b @ self.b))

    def forward(self, q: ArrayLike, v: ArrayLike, u: ArrayLike) -> Array:
        """Return the accelerations (N,) [rad/s^2] under the torque u [N m], by ABA; in space by M^-1."""
        q, v = self._vector("q", q), self._vector("v", v)
        return self._bodies.accelerations(q, v, self._applied(q, v, u))

    def linearise(self, q: ArrayLike, u: ArrayLike, v: ArrayLike | None = None) -> Linearisation:
        """Return the linearised dynamics near a pose q under u [N m].

        The derivatives are those of ABA (in space finite differences), with springs and dampers.

        Args:
            q: (N,) pose [rad].
            u: torque [N m], in space (2 S,).
            v: (N,) rates [rad/s]; default: at rest.
        """
        q, v = self._vector("q", q), self._vector("v", np.zeros(len(self.K)) if v is None else v)
        a_q, a_v, a_tau, a = self._bodies.derivatives(q, v, self._applied(q, v, u))
        n = len(self.K)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [a_q - a_tau * self.K, a_v - a_tau * self.D]])
        joints = np.vstack([np.zeros((n, n)), a_tau])
        return Linearisation(A, joints @ self.b.reshape(n, -1), joints, np.concatenate([v, a]))

    def _applied(self, q: Array, v: Array, u: ArrayLike) -> Array:
        """Return the joint torques (N,) [N m] of input, springs and dampers."""
        drive = self.b @ np.asarray(u, dtype=float) if self.b.ndim > 1 else self.b * u
        return np.asarray(drive - self.K * q - self.D * v)

    def tip(self, q: ArrayLike) -> Array:
        """Return the tip positions (..., 3) [m] in the world frame, for q (..., N)."""
        return np.asarray(self._tip.positions(np.asarray(q, dtype=float))[..., 0, :])

    def tip_jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian d tip / dq (3, N) [m/rad]."""
        return np.asarray(self._tip.jacobian(self._vector("q", q))[0])

    def markers(self, arc_lengths: ArrayLike) -> MarkerMap | SpaceMarkerMap:
        """Return the marker map of points at ``arc_lengths`` (M,) [m] from the base along the backbone."""
        return space_marker_map(self.arm, arc_lengths) if self.batch.space else marker_map(self.arm, arc_lengths)

    def _vector(self, name: str, values: ArrayLike) -> Array:
        array = np.asarray(values, dtype=float)
        if self.batch.space and array.shape == (self.links, 3):
            array = array.ravel()
        if array.shape != (len(self.K),) or not np.isfinite(array).all():
            raise InputError(name, expected=f"{len(self.K)} finite numbers", received=array)
        return array


def _exponential(A: Array) -> Array:
    """Return exp(A) of (n, n), by the [8/8] Pade approximant with scaling and squaring.

    G. H. Golub, C. F. Van Loan, Matrix Computations, 9.3.1. SciPy's function is equivalent, but its LAPACK divides matrices of
    this size among threads, which is hundreds of times slower on a busy machine; NumPy does not.
    """
    order, squarings = 8, max(0, 2 + int(np.log2(max(np.abs(A).sum(axis=1).max(), 1e-300))))
    scaled, power, share = A / 2.0**squarings, np.eye(len(A)), 1.0
    numerator, denominator = power.copy(), power.copy()
    for k in range(1, order + 1):
        share *= (order - k + 1) / ((2 * order - k + 1) * k)
        power = scaled @ power
        numerator += share * power
        denominator += (-1) ** k * share * power
    result = np.linalg.solve(denominator, numerator)
    for _ in range(squarings):
        result = result @ result
    return np.asarray(result)
