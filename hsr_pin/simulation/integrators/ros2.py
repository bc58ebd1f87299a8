"""ROS2, a two-stage W-method of order 2, L-stable where its Jacobian is exact.

J. G. Verwer, E. J. Spee, J. G. Blom, W. Hundsdorfer, A second-order Rosenbrock method applied to photochemical dispersion
problems, SIAM J. Sci. Comput. 20 (1999), Eq. (2.8). A W-method keeps its order with any approximation of the Jacobian, here the
springs and dampers alone. Stage 2 solves with M at its own pose instead of the first's: they differ by O(h), which leaves
order 2.
"""

from __future__ import annotations

from math import sqrt

from hsr_pin.simulation.integrators.integrator import Chain, Integrator
from hsr_pin.trajectory import Array

GAMMA = 1 - 1 / sqrt(2)


class Ros2(Integrator):
    """Two evaluations a step: the cheapest for fits, where many runs at moderate accuracy are wanted."""

    order = 2

    def lengths(self, step: float) -> tuple[float, ...]:
        return (GAMMA * step,)

    def advance(self, chain: Chain, q: Array, v: Array, step: float) -> tuple[Array, Array]:
        ((q_n, v_n, _),), length = chain.work, GAMMA * step
        q_n[:], v_n[:] = q, v
        v_1 = chain.solve(0, 0.0).copy()  # k_1 = (q_1, v_1), slopes of q and v
        change = length * v_1
        q_1 = v_n + change
        push = chain.stiffness * (q_1 + change) + chain.damping * v_1
        push *= 2 * length
        q_1 *= step
        q_n += q_1
        v_n += step * v_1
        w = chain.solve(0, 1 / GAMMA, push)  # k_2 = (q_2, v_2), v_2 = w - 2 v_1
        q_new = q_n + (step**2 / 2 * (1 - 3 * GAMMA)) * v_1 + (step**2 / 2 * GAMMA) * w  # q + h (3 q_1 + q_2) / 2
        w -= v_1
        w *= step / 2
        w += v_n  # v + h (3 v_1 + v_2) / 2
        return q_new[0], w[0].copy(order="F")
